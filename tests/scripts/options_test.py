"""The options of all scripts: --help prints usage, and an unknown option is refused before anything happens."""
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BASH_SCRIPTS = ["bench", "demo", "format", "gpu-bundle", "heads", "networks", "prediction", "preview", "reprojection", "scenes", "setup", "soak",
                "stability", "study", "test"]
# These three pass the options that they do not know to a program.
PASSING_ON = {"demo", "networks", "preview"}
OTHER_BASH_SCRIPTS = ["tests/gpu/bare_root", "tests/gpu/check"]
PYTHON_PROGRAMS = ["assets/make.py", "scripts/build-times", "scripts/folders", "scripts/frame-path", "scripts/mutate", "tests/scenes/heads.py", "tests/scenes/scenes.py", "tests/scripts/function_length.py", "tests/stability/report.py",
                   "tests/study/compare.py", "tests/study/rivals.py", "tests/study/study.py"]


def run(*command):
    """Runs a command in an empty folder. Returns the finished process and the files that it left there."""
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300, check=False,
                              stdin=subprocess.DEVNULL)
        return done, [p.name for p in Path(folder).iterdir()]


class Options(unittest.TestCase):
    def test_the_lists_here_name_every_script(self):
        names = {p.name for p in (ROOT / "scripts").iterdir() if p.suffix == "" and p.is_file()}
        self.assertEqual(names, {*BASH_SCRIPTS, "build-times", "folders", "frame-path", "mutate"})

    def test_help_prints_usage_and_writes_nothing(self):
        commands = [[f"{ROOT}/scripts/{name}"] for name in BASH_SCRIPTS] + [
            [f"{ROOT}/{name}"] for name in OTHER_BASH_SCRIPTS] + [
            [sys.executable, "-B", f"{ROOT}/{name}"] for name in PYTHON_PROGRAMS]
        for command in commands:
            with self.subTest(command=command[-1]):
                done, written = run(*command, "--help")
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertIn("usage: ", done.stdout)
                self.assertEqual(written, [])

    def test_an_unknown_option_is_named_in_the_error(self):
        for name in BASH_SCRIPTS:
            if name in PASSING_ON:
                continue
            with self.subTest(script=name):
                done, written = run(f"{ROOT}/scripts/{name}", "--unheard-of")
                self.assertEqual(done.returncode, 2, done.stderr)
                self.assertIn("--unheard-of", done.stderr)
                self.assertEqual(written, [])

    def test_python_programs_refuse_an_unknown_option(self):
        for name in PYTHON_PROGRAMS:
            with self.subTest(program=name):
                done, written = run(sys.executable, "-B", f"{ROOT}/{name}", "--unheard-of")
                self.assertEqual(done.returncode, 2, done.stderr)
                self.assertIn("usage: ", done.stderr)
                self.assertEqual(written, [])

    def test_check_says_that_it_cannot_run_if_it_cannot_write(self):
        with tempfile.TemporaryDirectory() as bundle:
            shutil.copy(ROOT / "tests/gpu/check", bundle)
            (Path(bundle) / "bin").mkdir()
            for name in ("bin/vr_client", "a_file"):  # the check looks only whether the client is there
                (Path(bundle) / name).touch(mode=0o755)
            for folder in (f"{bundle}/a_file/below", f"{bundle}/a_file", "/proc/no/folder"):
                with self.subTest(folder=folder):
                    done, _ = run(f"{bundle}/check", folder)
                    self.assertEqual(done.returncode, 3, done.stderr)
                    self.assertIn(f"cannot write to {folder}", done.stderr)


if __name__ == "__main__":
    unittest.main()
