#!/usr/bin/env python3
"""Makes a glTF scene with a walking figure: python3 tests/scenes/walker.py OUT.glb [--triangles N] [--room SCENE.glb].

The figure is one skinned mesh of tubes (trunk, head, arms, legs) on 11 joints, walks a circle once in eight seconds, and
its chest breathes by a morph target. With --room it walks in that scene, which must have no animation; --rigid shows the
same figure without a skin, so that both can be compared. For measurements; tests make their own small files.
"""

import argparse
import json
import math
import struct
import sys
from pathlib import Path

LOOP_S, KEYS = 8.0, 65
# name, parent, position from the parent, bone end from the joint, radius
BONES = [
    ("hips", None, (0, 0.95, 0), (0, 0.25, 0), 0.14), ("chest", 0, (0, 0.25, 0), (0, 0.30, 0), 0.15),
    ("head", 1, (0, 0.38, 0), (0, 0.22, 0), 0.10),
    ("arm left", 1, (-0.20, 0.27, 0), (0, -0.28, 0), 0.05), ("hand left", 3, (0, -0.28, 0), (0, -0.30, 0), 0.04),
    ("arm right", 1, (0.20, 0.27, 0), (0, -0.28, 0), 0.05), ("hand right", 5, (0, -0.28, 0), (0, -0.30, 0), 0.04),
    ("leg left", 0, (-0.09, 0, 0), (0, -0.45, 0), 0.075), ("foot left", 7, (0, -0.45, 0), (0, -0.48, 0.02), 0.06),
    ("leg right", 0, (0.09, 0, 0), (0, -0.45, 0), 0.075), ("foot right", 9, (0, -0.45, 0), (0, -0.48, 0.02), 0.06),
]


def bound(bone):
    """The joint's position in the bind pose."""
    _, parent, at, _, _ = BONES[bone]
    return at if parent is None else tuple(a + b for a, b in zip(bound(parent), at))


def about(axis, angle):
    return [math.sin(angle / 2) * a for a in axis] + [math.cos(angle / 2)]


def pose(bone, t):
    """The joint's rotation at time t: two steps a second."""
    phase = 2 * math.pi * t
    swing = {"leg left": 0.5 * math.sin(phase), "leg right": -0.5 * math.sin(phase),
             "foot left": 0.5 * max(0, -math.cos(phase)), "foot right": 0.5 * max(0, math.cos(phase)),
             "arm left": -0.5 * math.sin(phase), "arm right": 0.5 * math.sin(phase),
             "hand left": -0.4 - 0.2 * math.sin(phase), "hand right": -0.4 + 0.2 * math.sin(phase),
             "head": 0.1 * math.sin(2 * phase)}
    name = BONES[bone][0]
    if name in ("hips", "chest"):
        twist = 0.15 * math.sin(phase) * (1 if name == "hips" else -1)
        turn = -2 * math.pi * t / LOOP_S if name == "hips" else 0
        return about((0, 1, 0), twist + turn)
    return about((1, 0, 0), swing[name])


def figure(triangles):
    positions, normals, joints, weights, breath, faces = [], [], [], [], [], []
    around = max(6, round(math.sqrt(triangles / len(BONES) / 2)))
    rings = max(2, round(triangles / len(BONES) / 2 / around)) + 1
    for bone, (name, parent, _, end, radius) in enumerate(BONES):
        start, first = bound(bone), len(positions)
        for ring in range(rings):
            u = ring / (rings - 1)
            thick = radius * (0.35 + 0.65 * math.sqrt(max(0, 1 - (2 * u - 1) ** 6)))
            near = min(1.0, 0.5 + 2 * u) if parent is not None else 1.0
            for i in range(around):
                a = 2 * math.pi * i / around
                out = (math.cos(a), 0.0, math.sin(a))
                positions.append([s + u * e + thick * o for s, e, o in zip(start, end, out)])
                normals.append(out)
                joints.append([bone, parent or 0, 0, 0])
                weights.append([near, 1 - near, 0, 0])
                breath.append([0.02 * o for o in out] if name == "chest" else [0, 0, 0])
        for ring in range(rings - 1):
            for i in range(around):
                a, b = first + ring * around + i, first + ring * around + (i + 1) % around
                faces += [[a, a + around, b], [b, a + around, b + around]]
    return positions, normals, joints, weights, breath, faces


class File:
    def __init__(self, room):
        self.root, self.data = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}]}, bytearray()
        if room:
            content = room.read_bytes()
            size = struct.unpack("<I", content[12:16])[0]
            self.root, self.data = json.loads(content[20:20 + size]), bytearray(content[28 + size:])

    def add(self, kind, item):
        self.root.setdefault(kind, []).append(item)
        return len(self.root[kind]) - 1

    def accessor(self, rows, kind, code="f", **more):
        self.data += b"\0" * (-len(self.data) % 4)
        flat = [v for row in rows for v in row]
        packed = struct.pack(f"<{len(flat)}{code}", *flat)
        view = self.add("bufferViews", {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(packed)})
        self.data += packed
        component = {"f": 5126, "H": 5123, "I": 5125}[code]
        return self.add("accessors", {"bufferView": view, "componentType": component, "count": len(rows),
                                      "type": kind, **more})

    def glb(self):
        self.data += b"\0" * (-len(self.data) % 4)
        text = json.dumps(self.root | {"buffers": [{"byteLength": len(self.data)}]}).encode()
        text += b" " * (-len(text) % 4)
        chunk = lambda kind, body: struct.pack("<I4s", len(body), kind) + body
        chunks = chunk(b"JSON", text) + chunk(b"BIN\0", bytes(self.data))
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def animate(file, first, mesh_node):
    times = [LOOP_S * i / (KEYS - 1) for i in range(KEYS)]
    keys = file.accessor([[t] for t in times], "SCALAR", min=[0], max=[LOOP_S])
    animation = {"channels": [], "samplers": []}

    def channel(node, path, rows, kind):
        animation["samplers"].append({"input": keys, "output": file.accessor(rows, kind)})
        animation["channels"].append({"sampler": len(animation["samplers"]) - 1, "target": {"node": node, "path": path}})

    for bone in range(len(BONES)):
        if mesh_node is not None or bone == 0:
            channel(first + bone, "rotation", [pose(bone, t) for t in times], "VEC4")
    circle = [(0.9 * math.cos(2 * math.pi * t / LOOP_S), 0.95, 0.9 * math.sin(2 * math.pi * t / LOOP_S)) for t in times]
    channel(first, "translation", circle, "VEC3")
    if mesh_node is not None:
        channel(mesh_node, "weights", [[0.5 - 0.5 * math.cos(math.pi * t)] for t in times], "SCALAR")
    file.add("animations", animation)


def make(triangles, room, rigid):
    file = File(room)
    file.root.pop("animations", None)
    positions, normals, joints, weights, breath, faces = figure(triangles)
    lows, highs = ([f(p[k] for p in positions) for k in range(3)] for f in (min, max))
    hips = bound(0)
    if rigid:
        positions = [[a - b for a, b in zip(p, hips)] for p in positions]
        lows, highs = ([f(p[k] for p in positions) for k in range(3)] for f in (min, max))
    primitive = {"attributes": {"POSITION": file.accessor(positions, "VEC3", min=lows, max=highs),
                                "NORMAL": file.accessor(normals, "VEC3")},
                 "indices": file.accessor([[i] for f in faces for i in f], "SCALAR", "I"),
                 "material": file.add("materials", {"name": "figure", "doubleSided": True,
                                                    "pbrMetallicRoughness": {"baseColorFactor": [0.55, 0.35, 0.25, 1]}})}
    mesh = {"name": "figure", "primitives": [primitive]}
    first = len(file.root.get("nodes", []))
    for bone, (name, parent, at, _, _) in enumerate(BONES):
        file.add("nodes", {"name": name, "translation": list(at)})
        if parent is not None:
            file.root["nodes"][first + parent].setdefault("children", []).append(first + bone)
    roots = file.root["scenes"][0]["nodes"]
    roots.append(first)
    if rigid:
        file.root["nodes"][first]["mesh"] = file.add("meshes", mesh)
    else:
        primitive["attributes"] |= {"JOINTS_0": file.accessor(joints, "VEC4", "H"),
                                    "WEIGHTS_0": file.accessor(weights, "VEC4")}
        primitive["targets"] = [{"POSITION": file.accessor(breath, "VEC3", min=[-1] * 3, max=[1] * 3)}]
        inverse = [[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, *(-v for v in bound(b)), 1] for b in range(len(BONES))]
        skin = file.add("skins", {"joints": list(range(first, first + len(BONES))),
                                  "inverseBindMatrices": file.accessor(inverse, "MAT4")})
        roots.append(file.add("nodes", {"name": "figure", "mesh": file.add("meshes", mesh), "skin": skin}))
    animate(file, first, None if rigid else roots[-1])
    return file.glb(), len(faces)


def main():
    parser = argparse.ArgumentParser(prog="tests/scenes/walker.py", description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("--triangles", type=int, default=20000, help="of the figure, about; default 20000")
    parser.add_argument("--room", type=Path, help="a GLB in which the figure walks")
    parser.add_argument("--rigid", action="store_true", help="the figure has no skin and does not bend")
    arguments = parser.parse_args()
    content, triangles = make(arguments.triangles, arguments.room, arguments.rigid)
    arguments.out.write_bytes(content)
    print(f"{arguments.out}: {len(content):,} bytes, a figure of {triangles:,} triangles")


if __name__ == "__main__":
    sys.exit(main())
