"""tests/support/run_cases with programs that behave like gtest: each failed case is named, whatever happens to the others."""
import subprocess
import tempfile
import unittest
from pathlib import Path

RUN_CASES = Path(__file__).resolve().parents[1] / "support/run_cases"

# Runs the cases of its list that --gtest_filter allows, like gtest. A case is NAME:OUTCOME; outcomes are pass, fail,
# crash, skip, and shared: it fails unless it runs alone.
PROGRAM = """#!/usr/bin/env bash
filter='' status=0
for option; do [[ $option != --gtest_filter=* ]] || filter=${option#*=}; done
for case in CASES; do
  name=${case%:*}
  if [[ $filter == -* ]]; then [[ :${filter#-}: != *:$name:* ]] || continue
  elif [[ $filter ]]; then [[ $filter == "$name" ]] || continue
  fi
  echo "[ RUN      ] $name"
  case ${case#*:} in
    fail) status=1; echo "[  FAILED  ] $name, where GetParam() = 3 (1 ms)" ;;
    shared) if [[ $filter != "$name" ]]; then status=1; echo "[  FAILED  ] $name (1 ms)"; fi ;;
    crash) exit 134 ;;
    skip) printf '%s\\n' 'a_test.cpp:3: Skipped' 'no device' '' "[  SKIPPED ] $name (0 ms)" ;;
    *) echo "[       OK ] $name (0 ms)" ;;
  esac
done
echo "[==========] 4 tests from 1 test suite ran. (1 ms total)"
((status)) && echo "[  FAILED  ] 2 tests, listed below:"
exit $status
"""


def run_cases(*cases):
    """Returns (status, lines that name failures, whole output)."""
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / "program"
        program.write_text(PROGRAM.replace("CASES", " ".join(cases)), encoding="utf-8")
        program.chmod(0o755)
        done = subprocess.run([RUN_CASES, program], capture_output=True, text=True, timeout=60, check=False)
        return done.returncode, [line for line in done.stdout.splitlines() if line.startswith("FAILED")], done.stdout


class RunCases(unittest.TestCase):
    def test_passes_if_all_cases_pass(self):
        self.assertEqual(run_cases("A.One:pass", "A.Two:pass")[:2], (0, []))

    def test_names_each_failed_case_and_how_it_ends_alone(self):
        self.assertEqual(run_cases("A.One:pass", "A.Two/1:fail", "A.Three:shared")[:2],
                         (1, ["FAILED among others, passes alone: A.Three", "FAILED, also alone: A.Two/1"]))

    def test_runs_the_cases_after_a_crash(self):
        status, failures, output = run_cases("A.One:crash", "A.Two:pass", "A.Three:crash", "A.Four:fail", "A.Five:pass")
        self.assertEqual((status, failures), (1, ["FAILED, also alone: A.One", "FAILED, also alone: A.Three",
                                                  "FAILED, also alone: A.Four"]))
        self.assertIn("[       OK ] A.Five", output)

    def test_fails_if_the_program_does_not_start(self):
        done = subprocess.run([RUN_CASES, "/does/not/exist"], capture_output=True, text=True, timeout=60, check=False)
        self.assertEqual(done.returncode, 1)

    def test_prints_why_a_case_was_skipped(self):
        status, _, output = run_cases("A.One:pass", "A.Two:skip")
        self.assertEqual(status, 0)
        self.assertIn("[ RUN      ] A.Two\na_test.cpp:3: Skipped\nno device\n", output)


if __name__ == "__main__":
    unittest.main()
