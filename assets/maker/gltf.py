"""A glTF 2.0 document under construction: materials, meshes, nodes, lights, one camera and one animation."""

import base64
import json
import struct

FLOAT, USHORT, UINT, UBYTE = 5126, 5123, 5125, 5121
ARRAY, ELEMENTS = 34962, 34963
GRID = 1 << 20  # positions and animation lie on multiples of 2^-20 m: hides last-bit differences of libm


def on_grid(value):
    return round(value * GRID) / GRID + 0.0


class Document:
    def __init__(self, scene_name):
        self.buffer = bytearray()
        self.root = {
            "asset": {"version": "2.0", "generator": "farshade assets/make.py"},
            "scene": 0,
            "scenes": [{"name": scene_name, "nodes": []}],
            "nodes": [], "meshes": [], "materials": [], "accessors": [], "bufferViews": [],
        }
        self.triangles = {}  # by mesh

    def _append(self, kind, item):
        items = self.root.setdefault(kind, [])
        items.append(item)
        return len(items) - 1

    def _view(self, data, target=None):
        self.buffer += b"\0" * (-len(self.buffer) % 4)
        view = {"buffer": 0, "byteOffset": len(self.buffer), "byteLength": len(data)}
        if target:
            view["target"] = target
        self.buffer += data
        return self._append("bufferViews", view)

    def _accessor(self, rows, kind, component=FLOAT, target=None, bounds=False, **more):
        code = {FLOAT: "f", USHORT: "H", UINT: "I", UBYTE: "B"}[component]
        flat = [v for row in rows for v in row]
        if component == FLOAT:
            flat = list(map(on_grid, flat))
        accessor = {"bufferView": self._view(struct.pack(f"<{len(flat)}{code}", *flat), target),
                    "componentType": component, "count": len(rows), "type": kind, **more}
        if bounds:
            width = len(rows[0])
            as_float = struct.unpack(f"<{len(flat)}f", struct.pack(f"<{len(flat)}f", *flat))
            accessor["min"] = [min(as_float[k::width]) for k in range(width)]
            accessor["max"] = [max(as_float[k::width]) for k in range(width)]
        return self._append("accessors", accessor)

    def texture(self, png, name):
        image = self._append("images", {"name": name, "mimeType": "image/png", "bufferView": self._view(png)})
        sampler = self._append("samplers", {"wrapS": 10497, "wrapT": 10497})
        return self._append("textures", {"source": image, "sampler": sampler})

    def material(self, name, color=(1, 1, 1), texture=None, mask=False, double_sided=False):
        """`color` is linear."""
        surface = {"baseColorFactor": [*color, 1], "metallicFactor": 0, "roughnessFactor": 1}
        if texture is not None:
            surface["baseColorTexture"] = {"index": texture}
        material = {"name": name, "pbrMetallicRoughness": surface}
        if mask:
            material |= {"alphaMode": "MASK", "alphaCutoff": 0.5}
        if double_sided:
            material["doubleSided"] = True
        return self._append("materials", material)

    def mesh(self, name, *parts):
        """`parts` are pairs of shape and material. Texture coordinates are written if the
        material has a texture, vertex colours if one is not white."""
        primitives = []
        for shape, material in parts:
            attributes = {
                "POSITION": self._accessor(shape.positions, "VEC3", target=ARRAY, bounds=True),
                "NORMAL": self._accessor(shape.normals, "VEC3", target=ARRAY),
            }
            if "baseColorTexture" in self.root["materials"][material]["pbrMetallicRoughness"]:
                attributes["TEXCOORD_0"] = self._accessor(shape.uvs, "VEC2", target=ARRAY)
            if any(c != (1.0, 1.0, 1.0) for c in shape.colors):
                rows = [(*(round(255 * v) for v in c), 255) for c in shape.colors]
                attributes["COLOR_0"] = self._accessor(rows, "VEC4", UBYTE, ARRAY, normalized=True)
            index = USHORT if len(shape.positions) < 65535 else UINT
            indices = self._accessor([(i,) for t in shape.triangles for i in t], "SCALAR", index, ELEMENTS)
            primitives.append({"attributes": attributes, "indices": indices, "material": material})
        number = self._append("meshes", {"name": name, "primitives": primitives})
        self.triangles[number] = sum(len(shape.triangles) for shape, _ in parts)
        return number

    def node(self, name, parent=None, at=None, turned=None, mesh=None, light=None, camera=None):
        """`turned` is a quaternion (x, y, z, w); `light` and `camera` are their glTF objects."""
        node = {"name": name}
        if at is not None:
            node["translation"] = list(map(on_grid, at))
        if turned is not None:
            node["rotation"] = [round(v, 9) + 0.0 for v in turned]
        if mesh is not None:
            node["mesh"] = mesh
        if camera is not None:
            node["camera"] = self._append("cameras", camera)
        if light is not None:
            extension = "KHR_lights_punctual"
            lights = self.root.setdefault("extensions", {}).setdefault(extension, {"lights": []})["lights"]
            lights.append({"name": name, **light})
            node["extensions"] = {extension: {"light": len(lights) - 1}}
            self.root["extensionsUsed"] = [extension]
        number = self._append("nodes", node)
        siblings = (self.root["scenes"][0]["nodes"] if parent is None
                    else self.root["nodes"][parent].setdefault("children", []))
        siblings.append(number)
        return number

    def animate_rotation(self, node, times_s, quaternions):
        """The keys are interpolated linearly; quaternions are (x, y, z, w)."""
        animation = self.root.setdefault("animations", [{"name": "all", "channels": [], "samplers": []}])[0]
        animation["samplers"].append({
            "input": self._accessor([(t,) for t in times_s], "SCALAR", bounds=True),
            "output": self._accessor(quaternions, "VEC4"), "interpolation": "LINEAR"})
        animation["channels"].append({"sampler": len(animation["samplers"]) - 1,
                                      "target": {"node": node, "path": "rotation"}})

    def triangle_count(self):
        return sum(self.triangles[n["mesh"]] for n in self.root["nodes"] if "mesh" in n)

    def instance_count(self):
        return sum(len(self.root["meshes"][n["mesh"]]["primitives"])
                   for n in self.root["nodes"] if "mesh" in n)

    def as_gltf(self):
        uri = "data:application/octet-stream;base64," + base64.b64encode(self.buffer).decode()
        root = self.root | {"buffers": [{"uri": uri, "byteLength": len(self.buffer)}]}
        return (json.dumps(root, indent=1) + "\n").encode()

    def as_glb(self):
        self.buffer += b"\0" * (-len(self.buffer) % 4)
        root = self.root | {"buffers": [{"byteLength": len(self.buffer)}]}
        text = json.dumps(root, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        chunk = lambda kind, body: struct.pack("<I4s", len(body), kind) + body
        chunks = chunk(b"JSON", text) + chunk(b"BIN\0", bytes(self.buffer))
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks
