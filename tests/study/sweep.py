"""A sweep: a JSON file that says what to measure, and the points that follow from it.

Paths in it are relative to the root of the source tree. Missing recordings and scenes are reported and left out.

  scenes     name: file, or {"file", "stand", "skip_s", "frames", "every"}. "stand" is where the head begins, if not
             at the file's camera: [x, y, z, heading in degrees]. The others replace the values of the sweep
  traces     head recordings: name: {"file", "skip_s"}
  networks   name: link model of each direction     sizes    width and height of an eye in pixels
  frames, every    display frames of a point; every Nth of them is compared with its reference
  modes      mode words (mode_words.h); entries with the same mode form one curve
  ablations  {"modes", "scenes", "networks", "traces"}: hybrid without one of its parts
  timing     {"modes", "rounds", "seed", "frames"}: run times of the modes, in a random order in each round
  scaling    {"modes", "size", "pixels", "lights", "triangles", "clients", "rounds", "seed", "frames", "warm_up"}
"""
import json
import re

import scenes

# Modes without a server: they are measured on one network only.
ALONE = ("local", "full")
# The head for scaling scenes. It is part of the source tree.
SCALING_TRACE = {"name": "walk", "file": "assets/walk.csv", "skip_s": 0}


def mode_name(words):
    return words.split(",")[0]


class Sweep:
    """`points` are settings: flat dictionaries in the order to run. Their `kind` is error, timing or clients."""

    def __init__(self, path, root, say):
        self.root = root
        with open(path, encoding="utf-8") as file:
            self.told = json.load(file)
        self.scenes = self._those_there("scenes", say)
        self.traces = self._those_there("traces", say)
        self.networks = self.told["networks"]
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

    def _errors(self):
        ablations = self.told.get("ablations", {"modes": []})
        first = next(iter(self.networks))
        for place in self._places():
            for size in self.told["sizes"]:
                for network, words in self.networks.items():
                    modes = [("mode", m) for m in self.told["modes"] if mode_name(m) not in ALONE or network == first]
                    here = place | {"network": network}
                    if all(here[k] in ablations.get(f"{k}s", [here[k]]) for k in ("scene", "trace", "network")):
                        modes += [("ablation", m) for m in ablations["modes"] if m not in self.told["modes"]]
                    for part, mode in modes:
                        yield {"kind": "error", "part": part, **place, "size": size, "network": network,
                               "network_words": words, "modes": [mode],
                               **{k: self.scenes[place["scene"]].get(k, self.told[k]) for k in ("frames", "every")}}

    def _timings(self):
        if "timing" not in self.told:
            return
        first, seen = next(iter(self.networks)), set()
        for place in self._places():
            if place["scene"] in seen:  # the head does not change run times much
                continue
            seen.add(place["scene"])
            for size in self.told["sizes"]:
                for network, words in self.networks.items():
                    modes = [m for m in self.told["timing"]["modes"] if mode_name(m) not in ALONE or network == first]
                    yield {"kind": "timing", "part": "timing", **place, "size": size, "network": network,
                           "network_words": words, **self.told["timing"], "modes": modes}

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
    if point["kind"] == "error":
        given += ["--modes", *point["modes"], "--every", point["every"], "--pictures", pictures]
    elif point["kind"] == "clients":
        given += ["--clients", point["x"], "--warm-up", point["warm_up"]]
    else:
        given += ["--timing", "--modes", *point["modes"], "--rounds", point["rounds"], "--seed", point["seed"]]
    return [str(a) for a in given]


def work_in(point):
    """The work of a point in an arbitrary unit, to predict the remaining time."""
    runs = point.get("rounds", 1) * (len(point["modes"]) + 1) if point["kind"] == "timing" else 1
    reference = 4 / point["every"] if point["kind"] == "error" else 0
    clients = point["x"] if point["kind"] == "clients" else 1
    return runs * point["frames"] * clients * (1 + reference) * (point["size"] ** 2 + 128 ** 2)
