"""Shell completion of both programs, run by bash and, where it is installed, by zsh: it offers every option that --help
shows, the words of options that take words, and nothing of its own."""
import os
import re
import shutil
import subprocess
import unittest
from pathlib import Path

BUILD = Path(os.environ["FARSHADE_PROGRAMS"])
PROGRAMS = {"vr_client": BUILD / "vr_client/vr_client", "rt_server": BUILD / "rt_server/rt_server"}


def output_of(*command):
    return subprocess.run(command, capture_output=True, text=True, timeout=300, check=True).stdout


def help_of(program, *command):
    return output_of(PROGRAMS[program], *command, "--help")


def options_in(text):
    """The long options at the starts of lines of a help text."""
    names = set()
    for line in re.findall(r"^  (-\S+)", text, re.MULTILINE):
        names |= {name for name in line.split(",") if name.startswith("--")}
    return names


def commands_in(text):
    return re.findall(r"^  ([a-z]\S*)", text.partition("Subcommands:")[2].partition("Exit status:")[0], re.MULTILINE)


def completed(shell, program, *words):
    """What the shell offers for the last of `words`, as a set."""
    script = output_of(PROGRAMS[program], "--completion", shell)
    array = " ".join(f"'{word}'" for word in (program, *words))
    previous = words[-2] if len(words) > 1 else program
    call = f"_farshade_{program} {program} '{words[-1]}' '{previous}'; printf '%s\\n' \"${{COMPREPLY[@]}}\""
    if shell == "zsh":  # what bashcompinit sets before it calls the function
        script = script.partition("\n")[2]
        script = re.sub(r"^complete .*", "", script, flags=re.MULTILINE)
        prelude = "autoload -U +X bashcompinit && bashcompinit; emulate sh -o kshglob -o noshglob -o braceexpand;"
        script = "autoload -U +X compinit && compinit -D -u;" + prelude + script
    text = f"{script}\nCOMP_WORDS=({array}); COMP_CWORD={len(words)}; {call}"
    offered = set(output_of(shell, "-c", text).split())
    # The compgen of zsh offers all words and leaves it to zsh to keep those that begin like the last one.
    return {word for word in offered if shell == "bash" or word.startswith(words[-1])}


class Completion(unittest.TestCase):
    shells = [shell for shell in ("bash", "zsh") if shutil.which(shell)]

    def each(self):
        for shell in self.shells:
            for program in PROGRAMS:
                with self.subTest(shell=shell, program=program):
                    yield shell, program

    def test_offers_exactly_the_options_of_the_help(self):
        for shell, program in self.each():
            text = help_of(program)
            self.assertGreater(len(options_in(text)), 10, text)
            self.assertEqual(completed(shell, program, "--"), options_in(text))

    def test_offers_the_options_of_every_subcommand(self):
        for shell, program in self.each():
            commands = commands_in(help_of(program))
            self.assertIn("doctor", commands)
            self.assertLessEqual(set(commands), completed(shell, program, ""))
            for command in commands:
                self.assertEqual(completed(shell, program, command, "--"), options_in(help_of(program, command)))

    def test_offers_the_words_of_an_option(self):
        for shell in self.shells:
            with self.subTest(shell=shell):
                self.assertEqual(completed(shell, "vr_client", "--clock", ""), {"virtual", "real"})
                self.assertEqual(completed(shell, "vr_client", "--scene", "a", "--clock", "re"), {"real"})
                self.assertIn("hybrid", completed(shell, "vr_client", "--mode", ""))
        self.assertEqual(completed("bash", "vr_client", "--clock", "=", "re"), {"real"})
        self.assertEqual(completed("bash", "vr_client", "--clock", "="), {"virtual", "real"})
        if "zsh" in self.shells:
            self.assertEqual(completed("zsh", "vr_client", "--clock=re"), {"--clock=real"})

    def test_leaves_files_to_the_shell(self):
        for shell in self.shells:
            with self.subTest(shell=shell):
                self.assertEqual(completed(shell, "vr_client", "--scene", ""), set())
                self.assertEqual(completed(shell, "rt_server", "inspect", ""), set())

    def test_an_option_that_may_stand_alone_takes_its_words_after_the_sign(self):
        self.assertIn("--mode", completed("bash", "vr_client", "--plan", "--mo"))
        self.assertEqual(completed("bash", "vr_client", "--plan", "=", "e"), {"everything"})

    def test_another_shell_is_refused(self):
        done = subprocess.run([PROGRAMS["vr_client"], "--completion", "fish"], capture_output=True, text=True, timeout=300,
                              check=False)
        self.assertEqual(done.returncode, 2)
        self.assertIn("'fish' is not one of bash, zsh", done.stderr)


if __name__ == "__main__":
    unittest.main()
