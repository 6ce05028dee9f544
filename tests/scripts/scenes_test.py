"""scripts/scenes on a folder with one file of each kind. It uses the programs of FARSHADE_PROGRAMS."""
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def table(folder):
    """The exit status, the rows of the table without its head, and the last line."""
    done = subprocess.run([ROOT / "scripts/scenes", folder, "--no-build", "--size", "32x32"], capture_output=True, text=True,
                          timeout=300, check=False)
    lines = done.stdout.splitlines()
    return done.returncode, lines[2:-2], lines[-1:] or [done.stderr]


class Scenes(unittest.TestCase):
    def test_says_what_is_drawn_and_what_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            shutil.copy(ROOT / "assets/box_over_plane.gltf", folder)
            below = Path(folder) / "below"
            below.mkdir()
            (below / "broken.glb").write_bytes(b"no scene")
            status, rows, summary = table(folder)
            self.assertEqual(status, 0, summary)
            self.assertEqual(rows[1], "| box_over_plane.gltf | drawn |  |")
            self.assertIn("| below/broken.glb | refused | rt_server: broken.glb: neither a GLB", rows[0])
            self.assertEqual(summary, ["2 files: 1 refused, 1 drawn"])

    def test_refuses_a_folder_without_scenes(self):
        with tempfile.TemporaryDirectory() as folder:
            status, _, summary = table(folder)
            self.assertNotEqual(status, 0)
            self.assertIn("there is no .glb or .gltf file", summary[0])


if __name__ == "__main__":
    unittest.main()
