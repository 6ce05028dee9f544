"""scripts/setup with an apt-get and a dpkg-query that only write down how they are called."""
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

# Says how much disk is needed, as apt-get does.
APT_GET = """#!/bin/sh
echo "$@" >>"$CALLS"
case "$*" in
  *--assume-no*) echo "After this operation, 7 MB of additional disk space will be used."; exit 1 ;;
  *update*) exit "$UPDATE" ;;
esac
"""
# All packages are installed but those in $MISSING.
DPKG_QUERY = """#!/bin/sh
shift 2
for name; do case " $MISSING " in *" $name "*) ;; *) echo "installed $name" ;; esac; done
"""


class Setup(unittest.TestCase):
    def setup(self, missing, update=0):
        """Runs scripts/setup; returns its result and the calls of apt-get."""
        with tempfile.TemporaryDirectory() as folder:
            for name, text in {"apt-get": APT_GET, "dpkg-query": DPKG_QUERY, "sudo": '#!/bin/sh\nexec "$@"\n'}.items():
                (Path(folder) / name).write_text(text, encoding="utf-8")
                (Path(folder) / name).chmod(0o755)
            calls = Path(folder) / "calls"
            calls.touch()
            environment = os.environ | {"PATH": f"{folder}:{os.environ['PATH']}", "CALLS": str(calls), "MISSING": missing,
                                        "UPDATE": str(update)}
            result = subprocess.run([ROOT / "scripts/setup", "demo"], env=environment, capture_output=True, text=True, check=False)
            return result, calls.read_text(encoding="utf-8").splitlines()

    def test_does_nothing_when_nothing_is_missing(self):
        result, calls = self.setup("")
        self.assertEqual((result.returncode, result.stdout + result.stderr, calls), (0, "", []))

    def test_waits_for_the_lock_of_apt(self):
        result, calls = self.setup("cmake")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(len(calls), 3)
        for call in calls:
            self.assertIn("-o DPkg::Lock::Timeout=300", call)
        self.assertTrue(calls[-1].endswith(" cmake"), "only what is missing")

    def test_says_how_much_disk_it_needs(self):
        result, _ = self.setup("cmake")
        self.assertIn("7 MB of additional disk space", result.stderr)

    def test_installs_without_new_package_lists(self):
        result, calls = self.setup("cmake", update=100)
        self.assertEqual(result.returncode, 0)
        self.assertIn("apt-get update failed", result.stderr)
        self.assertIn(" install -q -y ", calls[-1])


if __name__ == "__main__":
    unittest.main()
