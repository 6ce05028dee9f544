"""A furnished room in the evening: x in [-3, 3], y in [0, 2.7], z in [-2.5, 2.5], seen from z ahead.

Three lights: the pendant over the table, which swings; the orrery's lamp, whose planets turn and throw moving
shadows; and a street lamp that shines through the blind. People walk in z > 0.5, -1.6 < x < 2.
"""

import math
import random

from . import furniture, pose, textures
from .gltf import Document
from .shapes import box, cone, joined, quad, rod, rounded_box, sphere, torus

LOOP_S = 4.0
WINDOW = {"left": 0.0, "right": 1.8, "low": 0.9, "high": 2.25, "deep": 0.12}
EYE, LOOK_AT = (0.95, 1.6, 1.75), (-0.25, 1.0, -1.0)


def make():
    doc = Document("room")
    palette = Palette(doc)
    shell(doc, palette)
    window(doc, palette)
    dining(doc, palette)
    lounge(doc, palette)
    shelf(doc, palette)
    walls(doc, palette)
    orrery(doc, palette)
    doc.node("camera:reference", at=EYE, turned=pose.looking(EYE, LOOK_AT),
             camera={"type": "perspective", "perspective": {"yfov": 1.3, "aspectRatio": 1, "znear": 0.01}})
    return doc.as_glb()


class Palette:
    """Materials by name; base colours are linear."""

    def __init__(self, doc):
        self.floor = doc.material("oak floor", texture=doc.texture(textures.planks(), "planks"))
        self.leaf = doc.material("leaf", texture=doc.texture(textures.leaf(), "leaf"), mask=True,
                                 double_sided=True)
        self.rug = doc.material("rug", texture=doc.texture(textures.rug(), "rug"))
        self.paintings = doc.material("paintings", texture=doc.texture(textures.paintings(), "paintings"))
        self.wall = doc.material("plaster", (0.66, 0.61, 0.52))
        self.accent = doc.material("blue-green plaster", (0.16, 0.30, 0.31))
        self.ceiling = doc.material("ceiling", (0.74, 0.72, 0.68))
        self.wood = doc.material("walnut", (0.30, 0.155, 0.075))
        self.pale_wood = doc.material("ash", (0.52, 0.37, 0.22))
        self.sofa = doc.material("mustard cloth", (0.56, 0.30, 0.065))
        self.linen = doc.material("linen", (0.62, 0.55, 0.44), double_sided=True)
        self.white = doc.material("white paint", (0.72, 0.71, 0.68))
        self.cushion = doc.material("chair cloth", (0.10, 0.22, 0.24))
        self.brass = doc.material("brass", (0.52, 0.36, 0.12), double_sided=True)
        self.cobalt = doc.material("cobalt glaze", (0.045, 0.11, 0.36))
        self.clay = doc.material("terracotta", (0.48, 0.18, 0.085))
        self.cream = doc.material("cream glaze", (0.70, 0.64, 0.52))
        self.painted = doc.material("painted")  # takes its colour from the vertices


def shell(doc, palette):
    floor = quad((-3, 0, 2.5), (6, 0, 0), (0, 0, -5), 3, 3).pictured(lambda u, v: (3 * u, 2.5 * v))
    w = WINDOW
    back = joined(quad((-3, 0, -2.5), (w["left"] + 3, 0, 0), (0, 2.7, 0)),
                  quad((w["right"], 0, -2.5), (3 - w["right"], 0, 0), (0, 2.7, 0)),
                  quad((w["left"], 0, -2.5), (w["right"] - w["left"], 0, 0), (0, w["low"], 0)),
                  quad((w["left"], w["high"], -2.5), (w["right"] - w["left"], 0, 0), (0, 2.7 - w["high"], 0)))
    right = quad((3, 0, -2.5), (0, 0, 5), (0, 2.7, 0))
    front = quad((3, 0, 2.5), (-6, 0, 0), (0, 2.7, 0))
    left = quad((-3, 0, 2.5), (0, 0, -5), (0, 2.7, 0))
    skirt = joined(*[box(6, 0.09, 0.016).moved(0, 0.045, s * 2.492) for s in (-1, 1)],
                   *[box(0.016, 0.09, 5).moved(s * 2.992, 0.045, 0) for s in (-1, 1)])
    doc.node("floor", mesh=doc.mesh("floor", (floor, palette.floor)))
    ceiling = quad((-3, 2.7, -2.5), (6, 0, 0), (0, 0, 5))
    doc.node("walls", mesh=doc.mesh("walls", (joined(back, right, front), palette.wall),
                                    (left, palette.accent), (ceiling, palette.ceiling),
                                    (skirt, palette.white)))


def window(doc, palette):
    w = WINDOW
    x, y = (w["left"] + w["right"]) / 2, (w["low"] + w["high"]) / 2
    wide, high, deep = w["right"] - w["left"], w["high"] - w["low"], w["deep"]
    reveal = joined(quad((w["left"], w["low"], -2.5), (0, 0, -deep), (0, high, 0)).flipped(),
                    quad((w["right"], w["low"], -2.5 - deep), (0, 0, deep), (0, high, 0)).flipped(),
                    quad((w["left"], w["low"], -2.5), (wide, 0, 0), (0, 0, -deep)),
                    quad((w["left"], w["high"], -2.5 - deep), (wide, 0, 0), (0, 0, deep)))
    bars = joined(*[box(0.05, high, 0.05).moved(x + s * (wide / 2 - 0.025), y, -2.58) for s in (-1, 0, 1)],
                  *[box(wide, 0.05, 0.05).moved(x, y + s * (high / 2 - 0.025), -2.58) for s in (-1, 1)],
                  box(wide, 0.03, 0.03).moved(x, y, -2.58),
                  rounded_box(wide + 0.16, 0.03, 0.2, 0.01, 2).moved(x, w["low"] - 0.015, -2.44))
    blind = furniture.blind(wide - 0.03, w["high"] - 0.03, w["low"] + 0.3).moved(x, 0, -2.525)
    doc.node("window", mesh=doc.mesh("window", (joined(reveal, bars, blind), palette.white)))
    cloth = doc.mesh("curtain", (furniture.curtain(0.5, 2.38, 6, random.Random(3)), palette.linen))
    doc.node("curtain left", at=(w["left"] - 0.2, 0.04, -2.36), mesh=cloth)
    doc.node("curtain right", at=(w["right"] + 0.2, 0.04, -2.36), turned=pose.about((0, 1, 0), 180),
             mesh=cloth)
    pole = joined(rod((w["left"] - 0.55, 2.46, -2.36), (w["right"] + 0.55, 2.46, -2.36), 0.012, 16),
                  *[sphere(0.028, 14).moved(px, 2.46, -2.36) for px in (w["left"] - 0.56, w["right"] + 0.56)],
                  *[torus(0.02, 0.003, 10, 4).turned("z", 90).moved(c - 0.24 + 0.06 * i, 2.452, -2.36)
                    for c in (w["left"] - 0.2, w["right"] + 0.2) for i in range(9)])
    doc.node("curtain pole", mesh=doc.mesh("curtain pole", (pole, palette.brass)))
    lamp = (2.5, 3.7, -5.3)
    doc.node("light:street lamp", at=lamp, turned=pose.looking(lamp, (0.55, 0.9, -0.9)),
             light={"type": "spot", "color": [0.72, 0.84, 1.0], "intensity": 280,
                    "spot": {"innerConeAngle": 0.3, "outerConeAngle": 0.42}})


TABLE_AT = (0.85, 0.0, -1.0)
TOP = 0.75


def dining(doc, palette):
    doc.node("table", at=TABLE_AT, mesh=doc.mesh("table", (furniture.table(), palette.wood)))
    wood, cushion = furniture.chair()
    chair = doc.mesh("chair", (wood, palette.pale_wood), (cushion, palette.cushion))
    seats = ((-0.38, 0.62, 176), (0.42, 0.66, 190), (-0.36, -0.6, -4), (0.4, -0.62, 7))
    for i, (x, z, turn) in enumerate(seats):
        doc.node(f"chair {i + 1}", at=(TABLE_AT[0] + x, 0, TABLE_AT[2] + z),
                 turned=pose.about((0, 1, 0), turn), mesh=chair)
    rng = random.Random(7)
    tx, _, tz = TABLE_AT
    round_vase = doc.mesh("round vase", (furniture.vase(furniture.ROUND_VASE), palette.cobalt),
                          (furniture.twigs(rng).moved(y=0.15), palette.painted))
    doc.node("vase with twigs", at=(tx - 0.42, TOP, tz - 0.08), mesh=round_vase)
    fruit = joined(*[sphere(r, 14).moved(x, y, z).colored(c) for x, y, z, r, c in (
        (0.06, 0.075, 0.03, 0.045, (0.60, 0.26, 0.03)), (-0.05, 0.075, 0.045, 0.043, (0.55, 0.05, 0.03)),
        (-0.01, 0.07, -0.06, 0.044, (0.36, 0.45, 0.06)), (0.005, 0.135, 0.01, 0.042, (0.62, 0.33, 0.05)))])
    doc.node("fruit bowl", at=(tx + 0.12, TOP, tz + 0.1),
             mesh=doc.mesh("fruit bowl", (furniture.vase(furniture.BOWL, 32, 10), palette.cream),
                           (fruit, palette.painted)))
    cup = furniture.vase([(0.028, 0.0), (0.038, 0.03), (0.041, 0.085)], 20, 6)
    handle = torus(0.024, 0.005, 14, 6).turned("x", 90).moved(0.05, 0.045, 0)
    cup = doc.mesh("cup", (joined(cup, handle), palette.clay))
    for i, (x, z, turn) in enumerate(((0.5, -0.2, 30), (-0.12, 0.24, 140), (0.45, 0.26, 250))):
        doc.node(f"cup {i + 1}", at=(tx + x, TOP, tz + z), turned=pose.about((0, 1, 0), turn), mesh=cup)
    pendant(doc, palette)


def pendant(doc, palette):
    """Hangs from the ceiling on a pivot that swings; the light hangs inside the shade's mouth."""
    tx, _, tz = TABLE_AT
    pivot = doc.node("pendant pivot", at=(tx, 2.7, tz))
    cord = joined(rod((0, 0, 0), (0, -0.5, 0), 0.004, 8), cone(0.05, 0.04, 0.03, 24).moved(y=-0.03))
    doc.node("pendant", parent=pivot, mesh=doc.mesh(
        "pendant", (joined(furniture.pendant_shade().moved(y=-0.5), cord), palette.brass)))
    doc.node("light:pendant", parent=pivot, at=(0, -0.655, 0),
             light={"type": "point", "color": [1.0, 0.80, 0.55], "intensity": 9})
    keys = [LOOP_S * i / 16 for i in range(17)]
    swing = [pose.about((0.6, 0, 0.8), 7 * math.sin(2 * math.pi * t / LOOP_S)) for t in keys]
    doc.animate_rotation(pivot, keys, swing)


def lounge(doc, palette):
    cloth, feet, pillows = furniture.sofa()
    pair = joined(pillows[0].colored((0.10, 0.24, 0.26)), pillows[1].colored((0.62, 0.55, 0.42)))
    doc.node("sofa", at=(-2.93, 0, -0.35), mesh=doc.mesh("sofa", (cloth, palette.sofa), (feet, palette.wood),
                                                         (pair, palette.painted)))
    edge = rounded_box(2.2, 0.014, 2.6, 0.006, 1).moved(y=0.007).colored((0.30, 0.10, 0.07))
    weave = quad((-1.08, 0.015, 1.28), (2.16, 0, 0), (0, 0, -2.56), 4, 4)
    doc.node("rug", at=(-1.15, 0, -0.2), mesh=doc.mesh("rug", (edge, palette.painted), (weave, palette.rug)))
    top = joined(rounded_box(0.6, 0.03, 0.6, 0.014, 2).moved(y=0.385),
                 *[rod((0.22 * sx, 0.0, 0.22 * sz), (0.16 * sx, 0.38, 0.16 * sz), 0.016, 12)
                   for sx in (-1, 1) for sz in (-1, 1)])
    doc.node("coffee table", at=(-1.55, 0.015, -0.35),
             mesh=doc.mesh("coffee table", (top, palette.pale_wood)))
    ring = joined(torus(0.085, 0.03, 32, 12).turned("x", 90).moved(y=0.115).colored((0.70, 0.64, 0.52)),
                  sphere(0.05, 24).moved(0.16, 0.05, 0.12).colored((0.045, 0.11, 0.36)),
                  furniture.books(random.Random(9), 0.05, 0.2).turned("z", -90).moved(-0.2, 0.052, -0.2))
    doc.node("things on coffee table", at=(-1.55, 0.415, -0.35),
             mesh=doc.mesh("things", (ring, palette.painted)))
    pot, stems, leaves = furniture.plant(random.Random(5))
    doc.node("plant", at=(2.52, 0, -1.95), mesh=doc.mesh(
        "plant", (pot, palette.clay), (stems, palette.painted), (leaves, palette.leaf)))


def shelf(doc, palette):
    at = (-2.1, 0, -2.49)
    doc.node("shelf", at=at, mesh=doc.mesh("shelf", (furniture.shelf(), palette.wood)))
    rng = random.Random(11)
    rows = ((0, 0.02, 0.75), (1, 0.3, 0.55), (2, 0.02, 0.42), (2, 0.72, 0.36), (3, 0.45, 0.6), (4, 0.02, 0.5))
    books = [furniture.books(rng, length, 0.3).moved(-0.6 + x, furniture.SHELF_BOARDS[row], 0.04)
             for row, x, length in rows]
    globe = joined(sphere(0.09, 28).colored((0.08, 0.22, 0.34)), torus(0.105, 0.005, 32, 6).turned("x", 67)
                   .colored((0.52, 0.36, 0.12))).moved(y=0.15)
    foot = joined(cone(0.06, 0.012, 0.05, 24), rod((0, 0.04, 0), (0, 0.06, 0), 0.008, 12))
    foot = foot.colored((0.1, 0.06, 0.03))
    blocks = [box(0.09, 0.09, 0.09).turned("y", a).moved(x, furniture.SHELF_BOARDS[0] + y, 0.17).colored(c)
              for a, x, y, c in ((20, 0.42, 0.045, (0.50, 0.08, 0.05)), (5, 0.52, 0.045, (0.62, 0.42, 0.09)),
                                 (40, 0.47, 0.135, (0.06, 0.22, 0.30)))]
    small = joined(joined(globe, foot).moved(-0.38, furniture.SHELF_BOARDS[3], 0.16), *blocks)
    doc.node("books", at=at, mesh=doc.mesh("books", (joined(*books, small), palette.painted)))
    tall = doc.mesh("tall vase", (furniture.vase(furniture.TALL_VASE), palette.cobalt))
    bowl = furniture.vase([(0.03, 0), (0.09, 0.02), (0.11, 0.06)], 32, 8)
    bowl = doc.mesh("shelf bowl", (bowl, palette.cream))
    doc.node("vase on top", at=(at[0] + 0.35, 2.0, at[2] + 0.16), mesh=tall)
    doc.node("vase in shelf", at=(at[0] - 0.46, furniture.SHELF_BOARDS[1], at[2] + 0.16), mesh=bowl)
    doc.node("bowl in shelf", at=(at[0] + 0.3, furniture.SHELF_BOARDS[4], at[2] + 0.17), mesh=bowl)
    cabinet = (3.0, 0, 0.45)
    doc.node("sideboard", at=cabinet, mesh=doc.mesh("sideboard", (furniture.sideboard(), palette.wood)))
    doc.node("vase on sideboard", at=(2.78, 0.72, 0.95), mesh=tall)
    clay = doc.mesh("clay vase", (furniture.vase(furniture.ROUND_VASE), palette.clay))
    doc.node("clay vase", at=(2.8, 0.72, 0.12), mesh=clay)
    balls = joined(sphere(0.07, 24).moved(0, 0.07, 0).colored((0.70, 0.64, 0.52)),
                   torus(0.075, 0.022, 32, 12).moved(0, 0.022, 0.24).colored((0.50, 0.08, 0.05)))
    doc.node("ball and ring", at=(2.78, 0.72, 0.42), mesh=doc.mesh("ball and ring", (balls, palette.painted)))


def walls(doc, palette):
    def picture(name, width, height, number):
        wood, card = furniture.frame(width, height, number)
        return doc.mesh(name, (wood, palette.painted), (card, palette.paintings))

    big, tall, wide = (picture("picture dusk", 0.95, 0.65, 0), picture("picture discs", 0.5, 0.66, 1),
                       picture("picture waves", 0.6, 0.45, 2))
    left, right, front = pose.about((0, 1, 0), 90), pose.about((0, 1, 0), -90), pose.about((0, 1, 0), 180)
    doc.node("picture over sofa", at=(-2.999, 1.62, -0.35), turned=left, mesh=big)
    doc.node("picture by shelf", at=(-0.92, 1.55, -2.499), mesh=tall)
    doc.node("picture over sideboard", at=(2.999, 1.5, 0.45), turned=right, mesh=wide)
    doc.node("picture by door", at=(0.9, 1.55, 2.499), turned=front, mesh=tall)
    doc.node("picture at front", at=(1.75, 1.5, 2.499), turned=front, mesh=wide)
    doc.node("door", at=(-1.2, 0, 2.499), turned=front,
             mesh=doc.mesh("door", (furniture.door(), palette.painted)))


def orrery(doc, palette):
    """A lamp in a wire globe; three arms alike turn by a third of a circle, so that the loop has no seam."""
    at = (-1.3, 2.12, -0.45)
    lamp = joined(furniture.cage(), furniture.petals().moved(y=0.13),
                  rod((0, 0.13, 0), (0, 2.7 - at[1], 0), 0.006, 10),
                  cone(0.06, 0.05, 0.03, 24).moved(y=2.67 - at[1]))
    doc.node("orrery lamp", at=at, mesh=doc.mesh("orrery lamp", (lamp, palette.brass)))
    doc.node("light:orrery", at=at, light={"type": "point", "color": [1.0, 0.86, 0.66], "intensity": 8})
    pivot = doc.node("orrery pivot", at=at, turned=pose.about((0, 1, 0), 0))
    arm = doc.mesh("orrery arm", (furniture.orrery_arm(), palette.painted))
    for i in range(3):
        doc.node(f"orrery arm {i + 1}", parent=pivot, turned=pose.about((0, 1, 0), 120 * i), mesh=arm)
    doc.animate_rotation(pivot, [0, LOOP_S / 2, LOOP_S], [pose.about((0, 1, 0), 60 * i) for i in range(3)])
