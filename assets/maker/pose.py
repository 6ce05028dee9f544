"""Quaternions (x, y, z, w) as glTF writes them."""

import math

from .shapes import cross, sub, unit


def about(axis, degrees):
    half = math.radians(degrees) / 2
    return (*(math.sin(half) * v for v in unit(axis)), math.cos(half))


def product(a, b):
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz)


def looking(start, target):
    """Turns -z towards the target, without roll."""
    x, y, z = unit(sub(target, start))
    heading = math.degrees(math.atan2(-x, -z))
    pitch = math.degrees(math.atan2(y, math.hypot(x, z)))
    return product(about((0, 1, 0), heading), about((1, 0, 0), pitch))
