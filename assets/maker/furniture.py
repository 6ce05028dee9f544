"""Furniture. Each piece stands on y = 0 at the origin. A function returns one shape, or one shape per material."""

import math
import random

from .shapes import box, cone, disc, joined, lathe, quad, rod, rounded_box, sphere, surface, torus, tube


def chair():
    """A chair that faces +z. Returns (wood, cushion)."""
    leg = joined(lathe([(0.013, 0.0), (0.019, 0.2), (0.022, 0.43)], 10, 4), disc(0.013, 10).turned("x", 180))
    legs = [leg.turned("z", -4 * sx).turned("x", 4 * sz).moved(0.19 * sx, 0.0015, 0.18 * sz)
            for sx in (-1, 1) for sz in (-1, 1)]
    posts = [tube(lambda v, s=s: (s * (0.19 + 0.01 * v), 0.42 + 0.5 * v, -0.185 - 0.1 * v * v),
                  lambda v: 0.019 - 0.005 * v, 8, 6, (1, 0, 0)) for s in (-1, 1)]
    knobs = [sphere(0.017, 10).moved(s * 0.2, 0.92, -0.285) for s in (-1, 1)]
    bend = lambda p: (p[0], p[1], p[2] - 0.05 + 1.4 * p[0] ** 2)
    back = [rounded_box(0.38, height, 0.016, 0.007, 1).warped(bend).turned("x", -10).moved(0, y, z)
            for y, z, height in ((0.60, -0.20, 0.05), (0.72, -0.222, 0.05), (0.855, -0.25, 0.09))]
    frame = rounded_box(0.43, 0.05, 0.41, 0.012, 1).moved(y=0.43)
    cushion = rounded_box(0.41, 0.05, 0.39, 0.024, 2).moved(y=0.474)
    return joined(*legs, *posts, *knobs, *back, frame), cushion


def table(length=1.5, width=0.85, height=0.75):
    top = rounded_box(length, 0.035, width, 0.015, 3).moved(y=height - 0.0175)
    apron = [box(length - 0.24, 0.08, 0.022).moved(0, height - 0.075, s * (width / 2 - 0.1)) for s in (-1, 1)]
    ends = [box(0.022, 0.08, width - 0.22).moved(s * (length / 2 - 0.12), height - 0.075, 0) for s in (-1, 1)]
    leg = lathe([(0.02, 0.0), (0.026, 0.06), (0.022, 0.12), (0.032, 0.35), (0.036, height - 0.03)], 16, 10)
    legs = [leg.moved(sx * (length / 2 - 0.11), 0, sz * (width / 2 - 0.1))
            for sx in (-1, 1) for sz in (-1, 1)]
    return joined(top, *apron, *ends, *legs)


def sofa(length=2.0):
    """A sofa that faces +x, with its back at x = 0. Returns (cloth, feet, two throw pillows)."""
    plump = lambda shape, k: shape.warped(
        lambda p: (p[0], p[1] * (1 + k * math.cos(2.2 * p[2]) * math.cos(3 * p[0])), p[2]))
    base = rounded_box(0.80, 0.22, length - 0.1, 0.03, 2).moved(0.43, 0.24, 0)
    back = rounded_box(0.2, 0.62, length - 0.1, 0.07, 2).turned("z", 6).moved(0.13, 0.53, 0)
    arms = [rounded_box(0.84, 0.5, 0.16, 0.07, 2).moved(0.43, 0.37, s * (length / 2 - 0.08)) for s in (-1, 1)]
    seat_length = (length - 0.34) / 2
    seats = [plump(rounded_box(0.62, 0.17, seat_length, 0.06, 3), 0.14).moved(0.53, 0.43, s * seat_length / 2)
             for s in (-1, 1)]
    rests = [plump(rounded_box(0.44, 0.17, seat_length - 0.02, 0.065, 3), 0.2).turned("z", 102)
             .moved(0.3, 0.70, s * seat_length / 2) for s in (-1, 1)]
    feet = [cone(0.018, 0.026, 0.13, 14).moved(x, 0, z) for x in (0.1, 0.76)
            for z in (-length / 2 + 0.1, length / 2 - 0.1)]
    pillows = [pillow().turned("x", roll).turned("z", 68).turned("y", yaw).moved(0.5, 0.73, z)
               for roll, yaw, z in ((38, 12, -0.68), (50, -14, 0.7))]
    return joined(base, back, *arms, *seats, *rests), joined(*feet), pillows


def pillow(side=0.42):
    """A pillow that lies on y = 0: a square with stretched corners."""
    def f(u, v, sign):
        x, z = 2 * u - 1, 2 * v - 1
        puff = max(0.0, (1 - x * x) * (1 - z * z)) ** 0.55
        pull = 1 - 0.1 * (1 - x * x * z * z) * (x * x + z * z) / 2
        return (side / 2 * x * pull, sign * 0.09 * puff, -sign * side / 2 * z * pull)
    return joined(*[surface(lambda u, v, s=s: f(u, v, s), 12, 12) for s in (1, -1)])


def shelf(width=1.3, height=2.0, depth=0.32):
    """The back is at z = 0. The boards are at y = 0.08, 0.46, 0.84, 1.22, 1.60 and the top."""
    sides = [box(0.025, height, depth).moved(s * (width - 0.025) / 2, height / 2, depth / 2) for s in (-1, 1)]
    boards = [box(width - 0.05, 0.025, depth).moved(0, y - 0.0125, depth / 2)
              for y in (*SHELF_BOARDS, height)]
    back = box(width, height, 0.01).moved(0, height / 2, 0.005)
    return joined(*sides, *boards, back)


SHELF_BOARDS = (0.08, 0.46, 0.84, 1.22, 1.60)
BOOK_COLORS = ((0.42, 0.06, 0.05), (0.05, 0.12, 0.28), (0.09, 0.22, 0.12), (0.55, 0.36, 0.09),
               (0.60, 0.52, 0.38), (0.24, 0.06, 0.16), (0.05, 0.25, 0.28), (0.62, 0.22, 0.06),
               (0.08, 0.08, 0.09))


def books(rng, length, tallest):
    """A row of books along +x from x = 0. The spines face +z, and the last book leans."""
    row, x = [], 0.0
    while x < length:
        thick, high = 0.018 + 0.036 * rng.random(), tallest * (0.68 + 0.3 * rng.random())
        deep = 0.15 + 0.07 * rng.random()
        color = BOOK_COLORS[int(rng.random() * len(BOOK_COLORS))]
        cover = box(thick, high, deep).colored(color)
        pages = box(thick * 0.7, 0.002, deep * 0.9).moved(y=high / 2).colored((0.7, 0.66, 0.55))
        band = box(thick * 0.86, high * 0.06, 0.002).moved(0, high * 0.28, deep / 2)
        book = joined(cover, pages, band.colored((0.6, 0.45, 0.15))).moved(y=high / 2)
        lean = 14 if x + thick >= length else 0
        row.append(book.turned("z", lean).moved(x + thick / 2 + high * 0.12 * (lean > 0), 0, deep / 2))
        x += thick + 0.0015
    return joined(*row)


def vase(profile, sides=26, along=14):
    """An open vase with an inner wall; `profile` lists (radius, y) of the outer wall from bottom to top."""
    outside = lathe(profile, sides, along)
    inside = lathe([(max(r - 0.006, 0.004), max(y, 0.008)) for r, y in profile], sides, along // 2).flipped()
    r, y = profile[-1]
    lip = surface(lambda u, v: ((r - 0.006 * v) * math.cos(2 * math.pi * u), y,
                                -(r - 0.006 * v) * math.sin(2 * math.pi * u)), sides, 1)
    return joined(outside, inside, lip)


TALL_VASE = [(0.045, 0.0), (0.075, 0.06), (0.092, 0.15), (0.07, 0.24), (0.032, 0.31), (0.034, 0.34),
             (0.05, 0.37)]
ROUND_VASE = [(0.05, 0.0), (0.1, 0.05), (0.118, 0.11), (0.09, 0.18), (0.048, 0.215), (0.062, 0.245)]
BOWL = [(0.05, 0.0), (0.11, 0.025), (0.155, 0.065), (0.175, 0.1)]


def twigs(rng, count=7):
    """Dry twigs for a vase: thin bent rods that rise from the origin."""
    def twig():
        turn, spread = 2 * math.pi * rng.random(), 0.06 + 0.16 * rng.random()
        height = 0.35 + 0.25 * rng.random()
        bend = 0.06 * (rng.random() - 0.5)
        path = lambda v: (math.cos(turn) * spread * v * v + bend * math.sin(3 * v), height * v,
                          math.sin(turn) * spread * v * v)
        buds = [sphere(0.009, 6).moved(*path(v)) for v in (0.7, 0.82, 0.92, 1.0)]
        return joined(tube(path, lambda v: 0.0035 - 0.002 * v, 4, 6, (1, 0, 0)).colored((0.16, 0.10, 0.06)),
                      *[b.colored((0.62, 0.36, 0.28)) for b in buds])
    return joined(*[twig() for _ in range(count)])


def frame(width, height, picture):
    """A picture frame on a wall at z = 0. Returns (frame and white mount, card with picture number `picture` of 3)."""
    bar = 0.028
    sides = [rounded_box(bar, height + bar, 0.03, 0.006, 1).moved(s * width / 2, 0, 0.015) for s in (-1, 1)]
    ends = [rounded_box(width + bar, bar, 0.03, 0.006, 1).moved(0, s * height / 2, 0.015) for s in (-1, 1)]
    mount = quad((-width / 2, -height / 2, 0.008), (width, 0, 0), (0, height, 0)).colored((0.72, 0.70, 0.64))
    w, h = width * 0.74, height * 0.76
    card = quad((-w / 2, -h / 2, 0.010), (w, 0, 0), (0, h, 0)).pictured(lambda u, v: ((picture + u) / 3, v))
    return joined(*[piece.colored((0.08, 0.05, 0.035)) for piece in (*sides, *ends)], mount), card


def blind(width, top, bottom, spacing=0.055, blade=0.05, tilt=20):
    """A blind in the plane z = 0 from `top` to `bottom`: slats along x whose inner edge is lower, rails and cords."""
    def slat(y):
        arch = lambda u, v, s: (width * (u - 0.5) * s, 0.004 * math.cos(math.pi * (v - 0.5)) + 0.0008 * s,
                                -blade * (v - 0.5))
        return joined(*[surface(lambda u, v, s=s: arch(u, v, s), 1, 6) for s in (1, -1)]) \
            .turned("x", tilt).moved(y=y)
    count = int((top - bottom) / spacing)
    slats = [slat(top - spacing * (i + 1)) for i in range(count)]
    rails = [box(width, 0.035, 0.05).moved(y=top),
             box(width, 0.018, 0.04).moved(y=top - spacing * (count + 1))]
    cords = [rod((x, top, 0.026), (x, bottom, 0.026), 0.0015, 4) for x in (-0.32 * width, 0.32 * width)]
    return joined(*slats, *rails, *cords)


def curtain(width, height, folds, rng):
    """A hanging cloth, centred on x = 0, from y = 0 upwards. Its folds are deeper near the floor."""
    phase = [2 * math.pi * rng.random() for _ in range(3)]

    def f(u, v):
        loose = 0.6 + 0.4 * (1 - v)
        wave = math.sin(2 * math.pi * folds * u + 0.5 * math.sin(4 * u + phase[0])
                        + 0.25 * (1 - v) * math.sin(7 * u + phase[1]))
        return (width * (u - 0.5) * (1 + 0.06 * (1 - v) ** 2), height * v,
                0.035 * loose * wave + 0.01 * math.sin(5 * v + phase[2]) * (1 - v))
    return surface(f, folds * 10, 10)


def plant(rng, leaves=46):
    """Returns (pot, soil and stems, leaf cards with uvs)."""
    pot = vase([(0.11, 0.0), (0.135, 0.12), (0.155, 0.26), (0.165, 0.3)], 28, 10)
    soil = disc(0.15, 24).moved(y=0.26).colored((0.05, 0.035, 0.025))
    stems, cards = [soil], []
    for i in range(leaves):
        turn, rise = i * 2.39996, 0.25 + 0.75 * (i + 0.5) / leaves  # the golden angle spreads them
        reach = (0.16 + 0.3 * math.sin(math.pi * (rise - 0.1))) * (0.8 + 0.4 * rng.random())
        tip = (math.cos(turn) * reach, 0.3 + 1.05 * rise, -math.sin(turn) * reach)
        path = lambda v: (tip[0] * v * v, 0.26 + (tip[1] - 0.26) * v * (1.2 - 0.2 * v), tip[2] * v * v)
        stems.append(tube(path, lambda v: 0.006 - 0.004 * v, 4, 5, (0.3, 0, 1)).colored((0.10, 0.16, 0.05)))
        long, wide = 0.26 + 0.1 * rng.random(), 0.13 + 0.04 * rng.random()
        droop = 0.5 + 0.6 * rng.random()
        rest = lambda u, v: 0.6 * long * (v - 0.5 * droop * v * v) - 0.015 * (2 * u - 1) ** 2
        card = surface(lambda u, v: (wide * (u - 0.5), rest(u, v), -0.85 * long * v), 4, 5)
        cards.append(card.turned("y", math.degrees(turn) - 90 + 20 * (rng.random() - 0.5)).moved(*path(1.0)))
    return pot, joined(*stems), joined(*cards)


def pendant_shade():
    """A wide metal cone that hangs down from y = 0, closed at the top and open below."""
    profile = [(0.31, -0.20), (0.25, -0.135), (0.15, -0.07), (0.06, -0.035), (0.03, 0.0)]
    return joined(lathe(profile, 48, 16), disc(0.03, 24))


def cage(radius=0.13, ribs=6):
    """A globe of wire around the origin: meridians and two parallels."""
    meridian = tube(lambda v: (radius * math.sin(math.pi * v), radius * math.cos(math.pi * v), 0.0),
                    lambda v: 0.0014, 4, 16, (0, 0, 1))
    parallels = [torus(radius * math.cos(a), 0.0014, 24, 4).moved(y=radius * math.sin(a))
                 for a in (-0.6, 0.0)]
    return joined(*[meridian.turned("y", 360 * i / ribs) for i in range(ribs)], *parallels)


def petals(count=8, inner=0.06, outer=0.17):
    """A flat flower, visible from above. It covers the lamp, so that its shadow falls on the ceiling."""
    middle, swing = (inner + outer) / 2, (outer - inner) / 2

    def f(u, v):
        a = 2 * math.pi * u
        reach = (middle + swing * math.cos(count * a)) * (1 - v)
        return (reach * math.cos(a), 0.0, -reach * math.sin(a))
    return surface(f, count * 12, 1)


def orrery_arm():
    """One third of the planets: a rod along +x, a planet with a ring, and a small moon."""
    planet = joined(sphere(0.055, 22).colored((0.62, 0.30, 0.10)),
                    torus(0.085, 0.006, 28, 6).scaled(1, 0.5, 1).turned("x", 24).colored((0.70, 0.58, 0.36)))
    moon = joined(sphere(0.03, 14).colored((0.30, 0.42, 0.60)), rod((0, 0.03, 0), (0, 0.1, 0), 0.0025, 6))
    return joined(rod((0.13, 0.0, 0.0), (0.36, 0.0, 0.0), 0.004, 8).colored((0.55, 0.42, 0.18)),
                  planet.moved(0.40, -0.01, 0),
                  moon.moved(0.27, -0.1, 0))


def door(width=0.86, height=2.05):
    """A door on a wall at z = 0: leaf, panels, casing and knob."""
    white, dark = (0.66, 0.63, 0.56), (0.55, 0.40, 0.14)
    panels = [rounded_box(width * 0.36, h, 0.02, 0.009, 1).moved(s * width * 0.22, y, 0.03)
              for s in (-1, 1) for y, h in ((0.5, 0.7), (1.45, 0.9))]
    casing = [rounded_box(0.08, height + 0.08, 0.03, 0.008, 1)
              .moved(s * (width / 2 + 0.04), height / 2 + 0.04, 0.015) for s in (-1, 1)]
    lintel = rounded_box(width + 0.2, 0.09, 0.036, 0.008, 1).moved(0, height + 0.045, 0.018)
    knob = joined(sphere(0.028, 18).moved(-width * 0.42, 1.0, 0.075),
                  rod((-width * 0.42, 1.0, 0.03), (-width * 0.42, 1.0, 0.07), 0.01, 10)).colored(dark)
    leaf = box(width, height, 0.025).moved(0, height / 2, 0.0125)
    return joined(*[s.colored(white) for s in (leaf, *panels, *casing, lintel)], knob)


def sideboard(length=1.5, depth=0.38, height=0.72):
    """Faces -x, with its back at x = 0 and its length along z."""
    middle = (height + 0.14) / 2
    carcass = rounded_box(depth, height - 0.14, length, 0.012, 2).moved(-depth / 2, middle, 0)
    doors = [rounded_box(0.02, height - 0.2, length / 3 - 0.02, 0.008, 1)
             .moved(-depth - 0.006, middle, (i - 1) * length / 3) for i in range(3)]
    knobs = [sphere(0.014, 10).moved(-depth - 0.03, 0.52, (i - 1) * length / 3 + 0.18) for i in range(3)]
    legs = [cone(0.016, 0.024, 0.15, 14).moved(x, 0, z) for x in (-0.05, -depth + 0.05)
            for z in (-length / 2 + 0.08, length / 2 - 0.08)]
    return joined(carcass, *doors, *legs, *knobs)
