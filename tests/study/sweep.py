"""A sweep: a JSON file that says what to measure, and the points that follow from it.

Paths in it are relative to the root of the source tree. Missing recordings and scenes are reported and left out.

  scenes     name: file, or {"file", "stand", "skip_s", "frames", "every"}. "stand" is where the head begins, if not
             at the file's camera: [x, y, z, heading in degrees]. The others replace the values of the sweep
  traces     head recordings: name: {"file", "skip_s"}
  networks   name: link model of each direction
  sizes      width and height of an eye in pixels; or {"px", "frames", "every", "modes", "timing"}, whose values after
             "px" replace those of the sweep and of the scenes, "timing" entry by entry
  frames, every    display frames of a point; every Nth of them is compared with its reference
  samples    optional: it is also compared with a reference of so many samples per side of a pixel, which has smooth edges
  modes      mode words (mode_words.h); entries with the same mode form one curve
  ablations  [{"modes", "sizes", "scenes", "networks", "traces"}, ..]: hybrid with other settings, such as without one
             of its parts, in every case, or in those listed
  timing     {"modes", "rounds", "seed", "frames"}: run times of the modes for each size, scene, head and network, in a
             random order in each round. Entries of modes and ablations that are not listed have the run times of their
             error runs
  scaling    {"modes", "size", "pixels", "lights", "triangles", "clients", "rounds", "seed", "frames", "warm_up"}
"""
import json
import re

import scenes
from rows import ALONE, mode_name

# The head for scaling scenes. It is part of the source tree.
SCALING_TRACE = {"name": "walk", "file": "assets/walk.csv", "skip_s": 0}


class Sweep:
    """`points` are settings: flat dictionaries in the order to run. Their `kind` is error, timing or clients."""

    def __init__(self, path, root, say):
        self.root = root
        with open(path, encoding="utf-8") as file:
            self.told = json.load(file)
        self.scenes = self._those_there("scenes", say)
        self.traces = self._those_there("traces", say)
        self.networks = self.told["networks"]
        self.sizes = [size if isinstance(size, dict) else {"px": size} for size in self.told["sizes"]]
        self.points = list(self._errors()) + list(self._timings()) + list(self._scaling())

    def _those_there(self, kind, say):
        found = {}
        for name, entry in self.told[kind].items():
            entry = entry if isinstance(entry, dict) else {"file": entry}
            if (self.root / entry["file"]).is_file():
                found[name] = entry
            else:
                say(f"{kind[:-1]} '{name}' is left out: there is no {entry['file']}")
        return found

    def _places(self):
        """Settings for each pair of scene and head recording."""
        for scene, of_scene in self.scenes.items():
            for trace, of_trace in self.traces.items():
                stand = {"stand": of_scene["stand"]} if "stand" in of_scene else {}
                yield {"scene": scene, "scene_file": of_scene["file"], **stand, "trace": trace,
                       "trace_file": of_trace["file"], "skip_s": of_scene.get("skip_s", of_trace.get("skip_s", 0))}

    def _cases(self):
        """Settings for each place, size and network, and the size's own values."""
        for place in self._places():
            for size in self.sizes:
                for network, words in self.networks.items():
                    yield {**place, "size": size["px"], "network": network, "network_words": words}, size

    def _errors(self):
        first = next(iter(self.networks))
        for case, of_size in self._cases():
            listed = of_size.get("modes", self.told["modes"])
            modes = [("mode", m) for m in listed if mode_name(m) not in ALONE or case["network"] == first]
            for more in self.told.get("ablations", []):
                if all(case[k] in more.get(f"{k}s", [case[k]]) for k in ("size", "scene", "trace", "network")):
                    modes += [("ablation", m) for m in more["modes"] if m not in listed]
            of_scene = self.scenes[case["scene"]]
            for part, mode in modes:
                yield {"kind": "error", "part": part, **case, "modes": [mode],
                       **{k: of_size.get(k, of_scene.get(k, self.told[k])) for k in ("frames", "every")},
                       **{k: self.told[k] for k in ("samples",) if k in self.told}}

    def _timings(self):
        if "timing" in self.told:
            for case, of_size in self._cases():
                yield {"kind": "timing", "part": "timing", **case, **self.told["timing"], **of_size.get("timing", {})}

    def _scaling(self):
        scaling = self.told.get("scaling", {})
        rest = {k: scaling[k] for k in ("modes", "rounds", "seed", "frames", "warm_up") if k in scaling}
        network, words = next(iter(self.networks.items()))
        for axis in ("pixels", "lights", "triangles", "clients"):
            for x in scaling.get(axis, []):
                size = x if axis == "pixels" else scaling["size"]
                scene = f"{axis}-{x}" if axis in ("lights", "triangles") else "triangles-4096"
                count = {"pixels": 2 * size * size, "triangles": scenes.triangles_in(x)}.get(axis, x)
                yield {"kind": "clients" if axis == "clients" else "timing", "part": "scaling", "axis": axis,
                       "x": count, "scene": scene, "scene_file": f"made:{scene}",
                       "trace": SCALING_TRACE["name"], "trace_file": SCALING_TRACE["file"],
                       "skip_s": SCALING_TRACE["skip_s"], "size": size, "network": network, "network_words": words,
                       **rest}

    def chosen(self, only):
        return [p for p in self.points if re.search(only, name_of(p))]


def name_of(point):
    """One line for people and for --only."""
    what = {"error": " ".join(point["modes"]), "timing": "all modes",
            "clients": f"{point.get('x')} clients"}[point["kind"]]
    return f"{point['part']}: {point['scene']}, {point['trace']}, {point['network']}, {point['size']} px, {what}"


def arguments(point, scene_file, trace_file, pictures):
    """The command line of study_point."""
    given = ["--scene", scene_file, "--trace", trace_file, "--size", point["size"], "--frames", point["frames"],
             "--skip", point["skip_s"], "--network", point["network_words"]]
    given += ["--stand", ",".join(map(str, point["stand"]))] if "stand" in point else []
    if point["kind"] == "error":
        given += ["--modes", *point["modes"], "--every", point["every"], "--pictures", pictures]
        given += ["--samples", point["samples"]] if "samples" in point else []
    elif point["kind"] == "clients":
        given += ["--modes", "hybrid,ask=whole", "--clients", point["x"], "--warm-up", point["warm_up"]]
    else:
        given += ["--timing", "--modes", *point["modes"], "--rounds", point["rounds"], "--seed", point["seed"]]
    return [str(a) for a in given]


def work_in(point):
    """The work of a point in an arbitrary unit, to predict the remaining time."""
    runs = point.get("rounds", 1) * (len(point["modes"]) + 1) if point["kind"] == "timing" else 1
    reference = (3 + point.get("samples", 1) ** 2) / point["every"] if point["kind"] == "error" else 0
    clients = point["x"] if point["kind"] == "clients" else 1
    return runs * point["frames"] * clients * (1 + reference) * (point["size"] ** 2 + 128 ** 2)
