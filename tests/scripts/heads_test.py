"""scripts/heads on a folder with one file of each kind. It uses the programs of FARSHADE_PROGRAMS."""
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def table(folder, *options):
    """The exit status, the rows of the table without its head, and the last line."""
    done = subprocess.run([ROOT / "scripts/heads", folder, "--no-build", *options], capture_output=True, text=True,
                          timeout=300, check=False)
    lines = done.stdout.splitlines()
    return done.returncode, lines[2:-2], lines[-1:] or [done.stderr]


class Heads(unittest.TestCase):
    def test_says_what_is_read_doubted_and_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            shutil.copy(ROOT / "assets/walk.csv", folder)
            (Path(folder) / "kitti.txt").write_text("1 0 0 0 0 1 0 0 0 0 1 0\n" * 9)
            (Path(folder) / "lost.txt").write_text("0.1 0 0 0 0 0 0 1\n0.2 nan 0 0 0 0 0 1\n0.3 0 0 0 0 0 0 1\n0.4 0 0 0 0 0 0 1\n")
            (Path(folder) / "ros.txt").write_text("".join(f"{i / 72:.6f} {i / 72:.6f} 0 1.6 0 0 0 1\n" for i in range(73)))
            status, rows, summary = table(folder)
            self.assertEqual(status, 0, summary)
            self.assertIn("| kitti.txt | refused | vr_client: kitti.txt:1: rows of 12 columns", rows[0])
            self.assertIn("| lost.txt | read with doubt | TUM columns, 3 samples in 0.3 s", rows[1])
            self.assertIn("left out 1 of 4 rows (25.0 %): 1 without a pose (the first is lost.txt:2:", rows[1])
            self.assertIn("| ros.txt | read with doubt | TUM columns, 73 samples in 1.0 s", rows[2])
            self.assertIn("--trace-axes ros", rows[2])
            self.assertIn("| walk.csv | read | named columns, 1441 samples", rows[3])
            self.assertEqual(sorted(summary[0].removeprefix("4 files: ").split(", ")),
                             ["1 read", "1 refused", "2 read with doubt"])

    def test_gives_options_to_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "ros.txt").write_text("".join(f"{i / 72:.6f} {i / 72:.6f} 0 1.6 0 0 0 1\n" for i in range(73)))
            status, rows, summary = table(folder, "--", "--trace-axes", "ros")
            self.assertEqual(status, 0, summary)
            self.assertIn("| ros.txt | read | ", rows[0])
            self.assertIn("axes ros (given)", rows[0])


if __name__ == "__main__":
    unittest.main()
