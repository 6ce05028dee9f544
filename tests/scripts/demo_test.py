"""scripts/demo on scenes with and without lights that cast shadows. It uses the programs of FARSHADE_PROGRAMS."""
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "assets"))

from maker import pose  # noqa: E402
from maker.gltf import Document  # noqa: E402
from maker.shapes import quad  # noqa: E402


def scene(lights, intensity=30):
    """A floor, a camera, and point lights at the given places."""
    doc = Document("floor")
    doc.node("floor", mesh=doc.mesh("floor", (quad((-2, 0, 2), (4, 0, 0), (0, 0, -4)), doc.material("grey", (.6, .6, .6)))))
    for i, place in enumerate(lights):
        doc.node(f"light:{i}", at=place, light={"type": "point", "color": [1, 1, 1], "intensity": intensity})
    eye = (0, 2, 3)
    doc.node("camera:reference", at=eye, turned=pose.looking(eye, (0, 0, 0)),
             camera={"type": "perspective", "perspective": {"yfov": 1.0, "aspectRatio": 1, "znear": 0.01}})
    return doc.as_glb()


class Demo(unittest.TestCase):
    def demo(self, content, name="scene.glb", more=()):
        """Runs scripts/demo on a scene. Returns the finished process and the names of the files that it wrote."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / name
            path.write_bytes(content)
            done = subprocess.run([ROOT / "scripts/demo", "--no-build", "--scene", path, "--size", "64x64", "--frames", "3",
                                   "--out", Path(folder) / "out", *more], capture_output=True, text=True, timeout=100, check=False)
            return done, {p.name for p in (Path(folder) / "out").glob("*")}

    def assert_shown(self, *content):
        done, files = self.demo(*content)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("summary.csv", files)
        return done

    def test_shows_a_scene_without_lights(self):
        self.assertIn("has no lights: it gets a sun and a lamp", self.assert_shown(scene([])).stderr)

    def test_gives_its_lighting_to_both_programs(self):
        """If the programs lit the scene differently, the server would refuse the client."""
        more = ["--light", "point,at=0:1:0,candela=20", "--sun=90,30", "--ambient", "0.1", "--exposure=2"]
        done = self.assert_shown(scene([]), "scene.glb", more)
        self.assertNotIn("has no lights", done.stderr)
        self.assertNotIn("no server answers", done.stderr)

    def test_shows_a_scene_whose_only_light_is_dark(self):
        self.assert_shown(scene([(0, 1, 0)], intensity=0))

    def test_shows_a_scene_with_shadows(self):
        self.assert_shown((ROOT / "assets/box_over_plane.gltf").read_bytes(), "scene.gltf")

    def test_fails_with_the_server_on_a_file_that_is_no_scene(self):
        done, _ = self.demo(b"no scene")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("rt_server ended before it listened", done.stderr)


if __name__ == "__main__":
    unittest.main()
