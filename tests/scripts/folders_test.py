"""scripts/folders in a small repository."""
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FILES = {
    "stereo/base/a.h": "// comment\n#pragma once\n\n/* more\n   of it */\nint a();  // two\n",
    "stereo/net/b.h": '#include "stereo/base/a.h"\n',
    "rt_server/main.cpp": '#include "stereo/base/a.h"\n#include "stereo/net/b.h"\n#include <vector>\nint main() {}\n',
    "tests/c.cpp": '#include "rt_server/main.cpp"\n',
}


class Folders(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = Path(scratch.name)
        for name, text in FILES.items():
            file = self.folder / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)
        (self.folder / "scripts").mkdir()
        shutil.copy(ROOT / "scripts/folders", self.folder / "scripts")
        for command in (["init", "-q"], ["add", "."],
                        ["-c", "user.name=a", "-c", "user.email=a", "commit", "-qm", "all"]):
            subprocess.run(["git", *command], cwd=self.folder, check=True)

    def printed(self, *options):
        done = subprocess.run([self.folder / "scripts/folders", *options], capture_output=True, text=True, check=True)
        return done.stdout.splitlines()

    def test_counts_lines_and_leaves_out_what_others_bring_along(self):
        self.assertEqual(self.printed()[2:], [
            "| rt_server | 1 | 4 | stereo/net |",
            "| stereo/base | 1 | 2 |  |",
            "| stereo/net | 1 | 1 | stereo/base |",
            "| all | 3 | 7 | |"])

    def test_draws_the_graph(self):
        self.assertIn("  rt_server --> stereo_net", self.printed("--mermaid"))

    def test_reads_any_commit(self):
        (self.folder / "stereo/base/a.h").write_text("")
        self.assertEqual(self.printed("HEAD")[-1], "| all | 3 | 7 | |", "what is not committed does not count")


if __name__ == "__main__":
    unittest.main()
