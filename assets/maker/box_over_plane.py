"""A box above a plane under two lights: the shadows are rectangles that anyone can work out on paper.

Box: x and z in [-0.5, 0.5], y in [1, 1.5]. Plane: y = 0, x and z in [-4, 4].
Point light at (0.25, 4, 0): a point at height y falls to x' = 0.25 + (x - 0.25) * 4 / (4 - y). The light
stands over the box, so its top face (y = 1.5, factor 1.6) makes the outline: x in [-0.95, 0.65],
z in [-0.8, 0.8].
Directional light along (1, -1, 0): x' = x + y, so x in [0.5, 2], z in [-0.5, 0.5].
"""

from . import pose
from .gltf import Document
from .shapes import box, quad


def make():
    doc = Document("box over plane")
    plane = doc.material("plane", (0.7, 0.7, 0.7))
    card = doc.material("box", (0.6, 0.25, 0.12))
    doc.node("plane", mesh=doc.mesh("plane", (quad((-4, 0, 4), (8, 0, 0), (0, 0, -8)), plane)))
    doc.node("box", at=(0, 1.25, 0), mesh=doc.mesh("box", (box(1, 0.5, 1), card)))
    doc.node("light:point", at=(0.25, 4, 0), light={"type": "point", "color": [1, 1, 1], "intensity": 30})
    doc.node("light:directional", turned=pose.looking((0, 0, 0), (1, -1, 0)),
             light={"type": "directional", "color": [1, 1, 1], "intensity": 1.2})
    eye = (0.6, 2.6, 4.2)
    doc.node("camera:reference", at=eye, turned=pose.looking(eye, (0.4, 0.3, 0)),
             camera={"type": "perspective", "perspective": {"yfov": 1.0, "aspectRatio": 1, "znear": 0.01}})
    return doc.as_gltf()
