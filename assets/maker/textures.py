"""Pictures for the room: oak planks that tile, a leaf cut out by its alpha, a rug and three paintings."""

import math
import random

from . import png


def _noise(rng, columns, rows):
    """Smooth noise in [0, 1] that repeats at 1 in u and v."""
    grid = [[rng.random() for _ in range(columns)] for _ in range(rows)]

    def at(u, v):
        x, y = u * columns, v * rows
        i, j = math.floor(x), math.floor(y)
        fx, fy = x - i, y - j
        fx, fy = fx * fx * (3 - 2 * fx), fy * fy * (3 - 2 * fy)
        a, b = grid[j % rows], grid[(j + 1) % rows]
        top = a[i % columns] * (1 - fx) + a[(i + 1) % columns] * fx
        low = b[i % columns] * (1 - fx) + b[(i + 1) % columns] * fx
        return top * (1 - fy) + low * fy

    return at


def planks(size=512, rows=14):
    """Oak boards along u, two per row, with different tones and grains and dark joints. One tile covers 2 m x 2 m."""
    rng = random.Random(20)
    streaks, grain, clouds = _noise(rng, 6, 160), _noise(rng, 40, 256), _noise(rng, 5, 24)
    boards = [[(rng.random(), rng.random(), rng.random()) for _ in range(2)] for _ in range(rows)]
    starts = [rng.random() for _ in range(rows)]

    def pixel(x, y):
        u, v = (x + 0.5) / size, (y + 0.5) / size
        row = int(v * rows)
        along = (u - starts[row]) % 1.0 * 2
        tone, du, dv = boards[row][int(along)]
        across = v * rows - row
        joint = min(across, 1 - across) * 2 / rows < 0.0028 or min(along % 1, 1 - along % 1) < 0.0028
        wood = (0.55 * streaks(u + du, v + dv) + 0.25 * grain(u + du, v + dv)
                + 0.45 * math.sin(22 * clouds(u + du, v + dv)) ** 2 + 1.1 * tone) / 2.35
        light = 0.36 if joint else 0.72 + 0.42 * wood
        return tuple(min(255, round(c * light)) for c in (186, 139, 96 - 8 * tone))

    return png.encode([[pixel(x, y) for x in range(size)] for y in range(size)])


def leaf(width=64, height=128):
    """A pointed leaf that fills the picture. The stalk is at the bottom, and the veins are lighter than the blade."""
    def pixel(x, y):
        v = 1 - (y + 0.5) / height
        u = abs((x + 0.5) / width * 2 - 1)
        edge = 0.96 * math.sin(math.pi * v ** 0.72) ** 0.8 * (1 + 0.05 * math.sin(v * 60))
        inside = (edge - u) * width / 2
        stalk = (0.05 - u) * width / 2 if v < 0.2 else -1.0
        alpha = round(255 * min(max(max(inside, stalk) + 0.5, 0), 1))
        rib = max(0.0, 1 - u / 0.05)
        side = max(0.0, 1 - abs((v * 9 - u * 2.6) % 1 - 0.5) / 0.12) * 0.5
        shade = 0.82 + 0.18 * v + 0.35 * max(rib, side)
        return (min(255, round(82 * shade)), min(255, round(134 * shade)), min(255, round(58 * shade)), alpha)

    return png.encode([[pixel(x, y) for x in range(width)] for y in range(height)])


def _srgb(color):
    """The sRGB bytes of a linear colour (IEC 61966-2-1)."""
    code = lambda c: 12.92 * c if c <= 0.0031308 else 1.055 * c ** (1 / 2.4) - 0.055
    return tuple(round(255 * min(max(code(c), 0.0), 1.0)) for c in color)


def rug(width=176, height=208):
    """A rug: woven diamonds within a border. The colours in the code are linear."""
    rng = random.Random(13)
    field = ((0.40, 0.11, 0.07), (0.56, 0.45, 0.30), (0.40, 0.11, 0.07), (0.09, 0.18, 0.21))

    def pixel(x, y):
        u, v = abs(2 * (x + 0.5) / width - 1), abs(2 * (y + 0.5) / height - 1)
        color = field[int(5.5 * u + 6.6 * v + 0.5) % 4]
        if max(u, v) > 0.86:
            color = (0.08, 0.16, 0.19) if max(u, v) < 0.94 else (0.58, 0.48, 0.33)
        thread = 0.88 + 0.16 * rng.random() - 0.10 * ((x + y) % 2)
        return _srgb(tuple(c * thread for c in color))

    return png.encode([[pixel(x, y) for x in range(width)] for y in range(height)])


def paintings(size=96):
    """Three pictures side by side: a dusk, three discs, waves. The colours in the code are linear, and v points up."""
    def dusk(u, v):
        sun = max(0.0, 1 - 9 * ((u - 0.64) ** 2 + (v - 0.42) ** 2))
        if v < 0.30 + 0.09 * math.sin(5 * u + 0.6):
            return (0.05, 0.07, 0.11)
        return (0.24 + 0.40 * (1 - v) + 0.2 * sun, 0.18 + 0.16 * (1 - v) + 0.16 * sun, 0.26 + 0.10 * v)

    def discs(u, v):
        for x, y, radius, color in ((0.35, 0.6, 0.22, (0.50, 0.08, 0.05)),
                                    (0.6, 0.42, 0.26, (0.60, 0.40, 0.09)),
                                    (0.45, 0.25, 0.16, (0.05, 0.17, 0.25))):
            if math.hypot(u - x, (v - y) * 1.2) < radius:
                return color
        return (0.66, 0.62, 0.53)

    def waves(u, v):
        wave = math.sin(9 * v + 2 * math.sin(4 * u))
        if wave <= -0.2:
            return (0.62, 0.56, 0.44)
        return (0.10 + 0.10 * wave, 0.28 + 0.08 * wave, 0.34 - 0.06 * wave)

    return png.encode([[_srgb(paint((x + 0.5) / size, 1 - (y + 0.5) / size))
                        for paint in (dusk, discs, waves) for x in range(size)] for y in range(size)])
