"""Triangle shapes: boxes, and everything round as a parametric surface whose normals follow from its formula.

Metres, +y up, counter-clockwise from outside. Shapes are values: moving or colouring one makes another.
"""

import math
from dataclasses import dataclass


def add(a, b):
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def times(a, s):
    return (a[0] * s, a[1] * s, a[2] * s)


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    length = math.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])
    return times(a, 1 / length)


def rotation(axis, degrees):
    """The function that turns a vector about the coordinate axis "x", "y" or "z", right-handed."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return {
        "x": lambda v: (v[0], c * v[1] - s * v[2], s * v[1] + c * v[2]),
        "y": lambda v: (c * v[0] + s * v[2], v[1], -s * v[0] + c * v[2]),
        "z": lambda v: (c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]),
    }[axis]


WHITE = (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class Shape:
    positions: tuple = ()
    normals: tuple = ()
    uvs: tuple = ()
    colors: tuple = ()  # linear RGB
    triangles: tuple = ()

    def moved(self, x=0.0, y=0.0, z=0.0):
        return self._with(lambda p: (p[0] + x, p[1] + y, p[2] + z), lambda n: n)

    def turned(self, axis, degrees):
        turn = rotation(axis, degrees)
        return self._with(turn, turn)

    def scaled(self, x, y, z):
        """All factors must be positive."""
        return self._with(lambda p: (p[0] * x, p[1] * y, p[2] * z),
                          lambda n: unit((n[0] / x, n[1] / y, n[2] / z)))

    def warped(self, f):
        """Maps every point by the smooth function f, and every normal by its derivative."""
        def normal(p, n):
            side = unit(cross(n, (0, 1, 0) if abs(n[1]) < 0.9 else (1, 0, 0)))
            up = cross(n, side)
            return unit(cross(derivative(lambda t: f(add(p, times(side, t))), 0.0),
                              derivative(lambda t: f(add(p, times(up, t))), 0.0)))
        return Shape(tuple(map(f, self.positions)), tuple(map(normal, self.positions, self.normals)),
                     self.uvs, self.colors, self.triangles)

    def colored(self, color):
        """`color` is linear RGB, or a function from position to it."""
        paint = color if callable(color) else lambda p: color
        return Shape(self.positions, self.normals, self.uvs, tuple(map(paint, self.positions)),
                     self.triangles)

    def pictured(self, place):
        """Maps the texture coordinates by place(u, v)."""
        return Shape(self.positions, self.normals, tuple(place(u, v) for u, v in self.uvs), self.colors,
                     self.triangles)

    def flipped(self):
        """Turns the surface inside out."""
        return Shape(self.positions, tuple(times(n, -1) for n in self.normals), self.uvs, self.colors,
                     tuple((a, c, b) for a, b, c in self.triangles))

    def _with(self, move, turn):
        return Shape(tuple(map(move, self.positions)), tuple(map(turn, self.normals)), self.uvs, self.colors,
                     self.triangles)


def joined(*shapes):
    positions, normals, uvs, colors, triangles = [], [], [], [], []
    for s in shapes:
        first = len(positions)
        positions += s.positions
        normals += s.normals
        uvs += s.uvs
        colors += s.colors
        triangles += [(a + first, b + first, c + first) for a, b, c in s.triangles]
    return Shape(tuple(positions), tuple(normals), tuple(uvs), tuple(colors), tuple(triangles))


def derivative(f, t):
    step = 1e-4
    return times(sub(f(t + step), f(t - step)), 0.5 / step)


def _grid(rows, columns):
    """Triangles of a grid of vertices. The vertices are numbered row by row, and u runs along a row."""
    for j in range(rows - 1):
        for i in range(columns - 1):
            a = j * columns + i
            yield a, a + 1, a + columns + 1
            yield a, a + columns + 1, a + columns


def surface(f, across, along):
    """The surface f(u, v), with u and v in [0, 1]. Its front is the side from which u runs to the right when v runs up."""
    positions, normals, uvs = [], [], []
    for j in range(along + 1):
        for i in range(across + 1):
            u, v = i / across, j / along
            # At a pole the derivative by u vanishes, so the normal is taken next to the pole.
            nu, nv = u, min(max(v, 1e-3), 1 - 1e-3)
            positions.append(f(u, v))
            normals.append(unit(cross(derivative(lambda t: f(t, nv), nu),
                                      derivative(lambda t: f(nu, t), nv))))
            uvs.append((u, 1 - v))
    near = lambda a, b: max(map(abs, sub(positions[a], positions[b]))) < 1e-7
    triangles = tuple(t for t in _grid(along + 1, across + 1)
                      if not (near(t[0], t[1]) or near(t[1], t[2]) or near(t[2], t[0])))
    return Shape(tuple(positions), tuple(normals), tuple(uvs), (WHITE,) * len(positions), triangles)


def quad(corner, right, up, across=1, along=1):
    """A flat rectangle. Its front is the side from which `right` points to the right when `up` points up."""
    return surface(lambda u, v: add(corner, add(times(right, u), times(up, v))), across, along)


def box(x, y, z):
    """A box with sharp edges, centred at the origin."""
    half = (x / 2, y / 2, z / 2)
    face = quad((-1, -1, 1), (2, 0, 0), (0, 2, 0))
    faces = [face.turned("y", a) for a in (0, 90, 180, 270)] + [face.turned("x", a) for a in (-90, 90)]
    return joined(*faces).scaled(*half)


def rounded_box(x, y, z, radius, steps=2):
    """A box centred at the origin. Its edges and corners are rounded in 2 * `steps` steps."""
    inner = (x / 2 - radius, y / 2 - radius, z / 2 - radius)
    quarter = [math.pi / 4 * i / steps for i in range(steps + 1)]
    turns = [(-1, math.tan(a - math.pi / 4)) for a in quarter] + [(1, math.tan(a)) for a in quarter]

    def face(turn):
        positions, normals = [], []
        for sv, tv in turns:
            for su, tu in turns:
                normal = turn(unit((tu, tv, 1.0)))
                core = [round(c) for c in turn((su, sv, 1.0))]
                normals.append(normal)
                positions.append(tuple(core[k] * inner[k] + radius * normal[k] for k in range(3)))
        count = len(positions)
        return Shape(tuple(positions), tuple(normals), ((0.0, 0.0),) * count, (WHITE,) * count,
                     tuple(_grid(len(turns), len(turns))))

    return joined(*[face(rotation("y", a)) for a in (0, 90, 180, 270)],
                  *[face(rotation("x", a)) for a in (-90, 90)])


def spline(points, t):
    """A Catmull-Rom spline through the points (tuples of numbers) for t in [0, 1], continued straight outside."""
    spans = len(points) - 1
    i = min(max(int(t * spans), 0), spans - 1)
    w = t * spans - i
    at = lambda k: points[k] if 0 <= k <= spans else tuple(
        2 * p - q for p, q in zip(points[min(max(k, 0), spans)], points[1 if k < 0 else spans - 1]))
    blend = lambda a, b, c, d: 0.5 * (2 * b + (c - a) * w + (2 * a - 5 * b + 4 * c - d) * w * w
                                      + (3 * b - a - 3 * c + d) * w * w * w)
    return tuple(map(blend, at(i - 1), at(i), at(i + 1), at(i + 2)))


def lathe(profile, sides, along):
    """A surface of revolution about +y. `profile` lists (radius, y) from bottom to top and is interpolated smoothly.
    Negative radii are set to 0."""
    def f(u, v):
        r, y = spline(profile, v)
        r, a = max(r, 0.0), 2 * math.pi * u
        return (r * math.cos(a), y, -r * math.sin(a))
    return surface(f, sides, along)


def cone(bottom, top, height, sides, closed=True):
    """A frustum standing on y = 0 with sharp rims; radii `bottom` and `top`."""
    wall = lathe([(bottom, 0.0), (top, height)], sides, 1)
    if not closed:
        return wall
    return joined(wall, disc(bottom, sides).turned("x", 180), disc(top, sides).moved(y=height))


def disc(radius, sides):
    """A disc on y = 0 that faces up."""
    return surface(lambda u, v: (radius * (1 - v) * math.cos(2 * math.pi * u), 0.0,
                                 -radius * (1 - v) * math.sin(2 * math.pi * u)), sides, 1)


def sphere(radius, sides=24):
    ring = lambda v: radius * math.sin(math.pi * v)
    return surface(lambda u, v: (ring(v) * math.cos(2 * math.pi * u), -radius * math.cos(math.pi * v),
                                 -ring(v) * math.sin(2 * math.pi * u)), sides, sides // 2)


def torus(ring, thickness, sides=32, around=12):
    """A torus on y = 0. `ring` is the radius of its centre line."""
    return tube(lambda v: (ring * math.cos(2 * math.pi * v), 0.0, -ring * math.sin(2 * math.pi * v)),
                lambda v: thickness, around, sides, (0, 1, 0))


def tube(path, radius, around, along, aside):
    """A tube around path(v) for v in [0, 1] with radius(v) and open ends. `aside` must never be parallel to the path."""
    def f(u, v):
        ahead = unit(derivative(path, v))
        n = unit(cross(aside, ahead))
        b = cross(ahead, n)
        a = 2 * math.pi * u
        return add(path(v), add(times(n, radius(v) * math.cos(a)), times(b, radius(v) * math.sin(a))))
    return surface(f, around, along)


def rod(start, end, radius, sides=8):
    ahead = unit(sub(end, start))
    aside = (1, 0, 0) if abs(ahead[0]) < 0.9 else (0, 1, 0)
    return tube(lambda v: add(start, times(sub(end, start), v)), lambda v: radius, sides, 1, aside)
