"""scripts/mutate --check on trees with known mistakes."""
import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

MUTATE = Path(__file__).resolve().parents[2] / "scripts/mutate"
GOOD = {"name": "sum", "file": "code.cpp", "find": "a + b", "replace": "a - b", "run": [["unit_code", "Sum.*"]]}


class Check(unittest.TestCase):
    def check(self, *mutations, code="int f(int a, int b) { return a + b; }\n"):
        """Returns (status, stderr) of --check on a tree of one source file and one file of mutations."""
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder)
            (root / "tests/mutations").mkdir(parents=True)
            (root / "code.cpp").write_text(code)
            (root / "tests/mutations/area.json").write_text(json.dumps(mutations))
            done = subprocess.run([sys.executable, "-B", MUTATE, "--check", "--root", root], capture_output=True,
                                  text=True, check=False)
            return done.returncode, done.stderr

    def assert_refused(self, complaint, *mutations, **options):
        status, stderr = self.check(*mutations, **options)
        self.assertEqual(status, 1)
        self.assertIn(complaint, stderr)

    def test_accepts_a_text_that_occurs_once(self):
        self.assertEqual(self.check(GOOD), (0, ""))

    def test_refuses_a_text_that_is_gone(self):
        self.assert_refused("occurs 0 times", {**GOOD, "find": "a * b"})

    def test_refuses_an_empty_text(self):
        self.assert_refused("occurs 0 times", {**GOOD, "find": ""})

    def test_refuses_a_text_that_occurs_twice(self):
        self.assert_refused("occurs 2 times", GOOD, code="int c = a + b, d = a + b;\n")

    def test_refuses_a_file_that_is_gone(self):
        self.assert_refused("does not exist", {**GOOD, "file": "gone.cpp"})

    def test_refuses_a_replacement_that_changes_nothing(self):
        self.assert_refused("changes nothing", {**GOOD, "replace": "a + b"})

    def test_refuses_a_name_used_twice(self):
        self.assert_refused("the same name", GOOD, GOOD)

    def test_refuses_a_mutation_without_tests(self):
        self.assert_refused("run must be a list", {**GOOD, "run": []})

    def test_refuses_a_missing_field(self):
        self.assert_refused("exactly the fields", {k: v for k, v in GOOD.items() if k != "replace"})


if __name__ == "__main__":
    unittest.main()
