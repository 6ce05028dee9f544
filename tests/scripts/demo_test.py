"""scripts/demo and scripts/preview on scenes with and without lights that cast shadows, with own and other servers.
They use the programs of FARSHADE_PROGRAMS."""
import contextlib
import os
import signal
import subprocess
import sys
import tempfile
import time
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


@contextlib.contextmanager
def running_server(folder, *options):
    """An rt_server with a new key in `folder`. Gives its address and the key file."""
    program, key, ready = Path(os.environ["FARSHADE_PROGRAMS"]) / "rt_server/rt_server", folder / "a.key", folder / "ready"
    subprocess.run([program, "keygen", "a", "--key", key, "--ring", folder / "ring"], capture_output=True, check=True)
    with subprocess.Popen([program, *options, "--listen", "127.0.0.1:0", "--keys", folder / "ring", "--ready-file", ready],
                          stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as server:
        while not ready.exists():
            time.sleep(0.02)
        yield ready.read_text().split()[1], key
        server.terminate()


def servers_below(process):
    """The command lines of rt_server that the process group of `process` still runs."""
    done = subprocess.run(["pgrep", "-g", str(process.pid), "-fa", "rt_server"], capture_output=True, text=True, check=False)
    return done.stdout


class Demo(unittest.TestCase):
    def demo(self, content, name="scene.glb", more=()):
        """Runs scripts/demo on a scene. Returns the finished process and the names of the files that it wrote."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / name
            path.write_bytes(content)
            done = subprocess.run([ROOT / "scripts/demo", "--no-build", "--scene", path, "--size", "64x64", "--frames", "3",
                                   "--out", Path(folder) / "out", *more], capture_output=True, text=True, timeout=300, check=False)
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

    def test_every_option_of_the_client_has_one_value(self):
        """The scripts have defaults for some options, and CLI11 refuses an option that comes twice."""
        with tempfile.TemporaryDirectory() as folder:
            for script, more in (("demo", ["--mode", "full", "--frames=1"]), ("preview", ["--hand", "--mode=full"])):
                done = subprocess.run([ROOT / "scripts" / script, "--no-build", "--scene", ROOT / "assets/box_over_plane.gltf",
                                       "--out", folder, "--size=32x32", *more], env={**os.environ, "DISPLAY": ":9999"},
                                      capture_output=True, text=True, timeout=300, check=False)
                self.assertNotEqual(done.returncode, 2, done.stderr)
                self.assertNotIn("At Most", done.stderr)

    def test_connects_to_a_server_that_runs_and_starts_none(self):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            with running_server(folder, "--scene", ROOT / "assets/box_over_plane.gltf") as (address, key):
                command = [ROOT / "scripts/demo", "--no-build", "--server", address, "--key", key, "--size=32x32", "--frames=2",
                           "--out", folder / "out"]
                done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertIn("box_over_plane.gltf along walk.csv", done.stdout)
                refused = subprocess.run([*command, "--", "--sessions", "3"], capture_output=True, text=True, timeout=300, check=False)
                self.assertIn("no rt_server is started", refused.stderr)

    def test_passes_options_after_two_dashes_to_the_server(self):
        done, _ = self.demo((ROOT / "assets/box_over_plane.gltf").read_bytes(), "scene.gltf", ["--", "--sessions", "0"])
        self.assertEqual(done.returncode, 1)
        self.assertIn("--sessions", done.stderr)

    def test_ends_with_130_at_ctrl_c(self):
        with tempfile.TemporaryDirectory() as folder, subprocess.Popen(
                [ROOT / "scripts/demo", "--no-build", "--frames", "5000", "--size", "32x32", "--out", folder],
                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True) as demo:
            for line in demo.stderr:
                if line.startswith("frame "):
                    break
            os.killpg(demo.pid, signal.SIGINT)
            rest = demo.stderr.read()
            self.assertEqual(demo.wait(), 130, "before its 5,000 frames are shown")
            self.assertNotIn("log of rt_server", rest)
            self.assertEqual(servers_below(demo), "")

    def test_fails_with_the_server_on_a_file_that_is_no_scene(self):
        done, _ = self.demo(b"no scene")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("rt_server ended before it listened", done.stderr)


if __name__ == "__main__":
    unittest.main()
