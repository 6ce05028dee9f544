"""Scenes that differ in one number only: lights or triangles. They are made like the scenes of assets/.

A scene is a floor of 6 m with 16 spheres on it, seen from 4 m away. So the same pixels are covered for every number.
"""
import math
import sys
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "assets"))

from maker import pose  # noqa: E402
from maker.gltf import Document  # noqa: E402
from maker.shapes import quad, sphere  # noqa: E402

THINGS = 16
ORDINARY = {"lights": 3, "triangles": 4096}


def sides_for(triangles):
    """The sides s of each sphere for about this many triangles in the scene. A sphere has s * s - 2 * s."""
    return 2 * max(2, round((1 + math.sqrt(1 + triangles / THINGS)) / 2))


def triangles_in(triangles):
    """The exact number of triangles of the scene."""
    sides = sides_for(triangles)
    return THINGS * (sides * sides - 2 * sides) + 2


def make(axis, count):
    """The bytes of a .glb with `count` lights or about `count` triangles."""
    numbers = {**ORDINARY, axis: count}
    doc = Document(f"{count} {axis}")
    grey, red = doc.material("floor", (0.6, 0.6, 0.6)), doc.material("things", (0.6, 0.25, 0.12))
    doc.node("floor", mesh=doc.mesh("floor", (quad((-3, 0, 3), (6, 0, 0), (0, 0, -6)), grey)))
    thing = sphere(0.3, sides_for(numbers["triangles"]))
    for i in range(THINGS):  # each has its own mesh, so that the number of triangles in memory grows, too
        doc.node(f"thing {i}", at=(-1.8 + 1.2 * (i % 4), 0.4, -1.8 + 1.2 * (i // 4)),
                 mesh=doc.mesh(f"thing {i}", (thing, red)))
    for i in range(numbers["lights"]):
        angle = 2.4 * i  # about the golden angle, so that no two lights are in line
        radius = 0.5 + 1.5 * i / numbers["lights"]
        doc.node(f"light:{i}", at=(radius * math.cos(angle), 2.5 + 0.01 * i, radius * math.sin(angle)),
                 light={"type": "point", "color": [1, 1, 1], "intensity": 40 / numbers["lights"]})
    eye = (0, 2.2, 4)
    doc.node("camera:reference", at=eye, turned=pose.looking(eye, (0, 0.3, 0)),
             camera={"type": "perspective", "perspective": {"yfov": 1.0, "aspectRatio": 1, "znear": 0.01}})
    return doc.as_glb()
