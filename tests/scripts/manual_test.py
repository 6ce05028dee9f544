"""The man pages that the target `manual` makes: options, subcommands and exit statuses of --help are in them, and no path of
the builder."""
import os
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

from completion_test import PROGRAMS, commands_in, help_of, options_in

ROOT = Path(__file__).resolve().parents[2]


def plain(page):
    """The text of a man page without its markup."""
    for mark, text in (("\\-", "-"), ("\\fB", ""), ("\\fR", ""), ("\\fI", ""), ("\\&", ""), ("\\,", ""), ("\\/", ""), ("\\(aq", "'")):
        page = page.replace(mark, text)
    return page


@unittest.skipUnless(shutil.which("help2man"), "help2man is not installed")
class Manual(unittest.TestCase):
    def test_pages_have_all_that_the_help_has_and_no_path_of_the_builder(self):
        with tempfile.TemporaryDirectory() as folder:
            for name, program in PROGRAMS.items():
                with self.subTest(program=name):
                    subprocess.run(["cmake", "-D", f"HELP2MAN={shutil.which('help2man')}", "-D", f"PROGRAM={program}",
                                    "-D", f"NAME={name}", "-D", "SUMMARY=does it", "-D", "VERSION=1.2.3",
                                    "-D", f"FOLDER={folder}", "-P", str(ROOT / "cmake/make_manual.cmake")],
                                   check=True, timeout=300, cwd=folder, env={**os.environ, "XDG_CONFIG_HOME": "/builder"})
                    page = plain(Path(folder, f"{name}.1").read_text(encoding="utf-8"))
                    self.assertEqual({word for word in options_in(help_of(name)) if word not in page}, set())
                    self.assertIn("doctor", commands_in(help_of(name)))
                    for command in commands_in(help_of(name)):
                        own = plain(Path(folder, f"{name}-{command}.1").read_text(encoding="utf-8"))
                        self.assertEqual({word for word in options_in(help_of(name, command)) if word not in own}, set())
                        self.assertNotIn("/builder", own)
                    self.assertIn(f"{name} - does it", page)
                    self.assertIn("1.2.3", page)
                    self.assertRegex(page, r"Exit status:\"?\n(.*\n)*.*command line or the configuration file is wrong")
                    self.assertIn("~/.config/farshade", page)
                    self.assertNotIn("/builder", page)
                    self.assertIn(f"complete -o bashdefault -o default -F _farshade_{name}", Path(folder, name).read_text())


if __name__ == "__main__":
    unittest.main()
