"""A synthetic head recording of 20 s at 72 Hz, made for room.glb.

Gestures are minimum-jerk moves (Flash and Hogan 1985): a turn of A degrees in T seconds peaks at 1.875 A / T.
Between the gestures, a sum of slow sines moves the head, and each step moves it up and down.
"""

import math

from . import pose

RATE_HZ, SECONDS = 72, 20
START_NS = 1_000_000_000_000
EYE_DISTANCE_M = 0.063
FOV_LEFT = (-0.942, 0.698, 0.733, -0.942)  # left, right, up, down; the right eye mirrors it

# (begins, lasts, by how much): seconds, degrees to the left, degrees up, metres (x, z)
TURNS = ((0.35, 0.5, 9), (1.0, 0.62, -62), (1.85, 0.95, 88), (2.9, 1.1, -24),
         (4.4, 0.6, 14), (5.5, 0.7, -22), (6.6, 0.55, 12), (7.8, 1.6, 118), (9.6, 1.6, -150), (11.4, 0.8, 38),
         (12.5, 1.1, 30), (14.2, 0.5, -11), (15.2, 0.7, 15), (16.4, 0.85, 102), (17.5, 1.3, -110),
         (18.9, 1.0, -47))
NODS = ((0.4, 0.5, -4), (1.1, 0.6, 7), (2.0, 0.7, -9), (3.2, 0.7, 5), (4.5, 0.6, -8), (5.6, 0.7, 9),
        (6.7, 0.6, -4), (8.0, 1.0, 6), (9.6, 1.2, -8), (11.4, 0.7, 3), (13.0, 0.8, 10), (14.3, 0.6, -14),
        (15.4, 0.7, 8), (16.7, 0.8, -3), (18.0, 0.9, 4))
WALKS = ((1.8, 2.1, (-0.41, -0.56)), (5.2, 1.2, (0.15, -0.10)), (8.2, 2.3, (-0.65, -0.39)),
         (11.0, 3.0, (1.42, 1.00)), (16.2, 2.6, (-0.48, -0.15)))


def eased(t, begins, lasts):
    """Rises from 0 at `begins` to 1 at `begins` + `lasts` with minimum jerk."""
    s = min(max((t - begins) / lasts, 0.0), 1.0)
    return s * s * s * (10 - 15 * s + 6 * s * s)


def total(moves, t):
    return sum(size * eased(t, begins, lasts) for begins, lasts, size in moves)


def walked(t, axis):
    return total(((begins, lasts, way[axis]) for begins, lasts, way in WALKS), t)


def pace(t):
    """Walking speed, m/s."""
    step = 1e-3
    return math.hypot(*((walked(t + step, k) - walked(t - step, k)) / (2 * step) for k in (0, 1)))


def sway(t, seed, slowest_hz=0.13):
    """Smooth noise within +-1, 0 at t = 0: a sum of sines with incommensurable periods."""
    wave = lambda s: sum(math.sin(2 * math.pi * slowest_hz * 1.618 ** k * s + seed * (1.3 + k)) / 1.4 ** k
                         for k in range(5))
    return (wave(t) - wave(0.0)) / 3.2


def head(t):
    """Position (m) and quaternion (x, y, z, w), starting at (0, 1.6, 0) and looking along -z."""
    walking = min(pace(t) / 0.5, 1.0)
    phase = 2 * math.pi * 1.8 * t  # steps a second
    position = (walked(t, 0) + 0.012 * sway(t, 1) + 0.014 * walking * math.sin(phase / 2),
                1.6 + 0.006 * sway(t, 2) + 0.016 * walking * math.sin(phase),
                walked(t, 1) + 0.012 * sway(t, 3))
    heading = total(TURNS, t) + 6.5 * sway(t, 4, 0.21)
    pitch = total(NODS, t) + 3.2 * sway(t, 5, 0.19) + 0.5 * walking * math.sin(phase + 0.6)
    roll = 1.8 * sway(t, 6, 0.17) + 0.5 * walking * math.sin(phase / 2 + 0.4)
    rotation = pose.about((0, 1, 0), heading)
    rotation = pose.product(rotation, pose.about((1, 0, 0), pitch))
    return position, pose.product(rotation, pose.about((0, 0, 1), roll))


def make():
    left, right, up, down = FOV_LEFT
    lines = [
        "# head trace: made by assets/make.py for room.glb",
        "# axes: +x right, +y up, -z ahead, right-handed",
        "# units: m, ns",
        "# clock: monotonic",
        "# space: head in stage",
        f"# eye distance [m]: {EYE_DISTANCE_M}",
        f"# fov left eye [rad] left right up down: {left} {right} {up} {down}",
        f"# fov right eye [rad] left right up down: {-right} {-left} {up} {down}",
        "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []",
    ]
    for i in range(SECONDS * RATE_HZ + 1):
        since_start = (2 * i * 10**9 + RATE_HZ) // (2 * RATE_HZ)  # nearest nanosecond
        (px, py, pz), (qx, qy, qz, qw) = head(i / RATE_HZ)
        numbers = ",".join([f"{v:.5f}" for v in (px, py, pz)] + [f"{v:.8f}" for v in (qw, qx, qy, qz)])
        lines.append(f"{START_NS + since_start},{numbers}".replace(",-0.00000,", ",0.00000,"))
    return ("\n".join(lines) + "\n").encode()
