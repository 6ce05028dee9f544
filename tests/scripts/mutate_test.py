"""scripts/mutate --check on trees with known mistakes, and how mutations become switches of one build."""
import contextlib
import importlib.machinery
import importlib.util
import io
import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
MUTATE = ROOT / "scripts/mutate"
sys.path.insert(0, str(ROOT / "tests/mutations"))
from switches import HEADER, Switched, blamed  # pylint: disable=wrong-import-position

LOADER = importlib.machinery.SourceFileLoader("mutate", str(MUTATE))
mutate = importlib.util.module_from_spec(importlib.util.spec_from_loader("mutate", LOADER))
LOADER.exec_module(mutate)

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


def words(text):
    """The text with one space between words, because the line breaks of switches do not matter."""
    return " ".join(text.split())


class SwitchesInCpp(unittest.TestCase):
    """Mutations have the numbers 1, 2, ... in the order of the calls."""

    def switch(self, source, *changes, name="code.cpp"):
        return Switched(name, source, [(i + 1, find, replace) for i, (find, replace) in enumerate(changes)])

    def assert_becomes(self, source, expected, *changes):
        switched = self.switch(source, *changes)
        self.assertEqual(switched.alone, set())
        self.assertEqual(words(switched.text), words(HEADER + expected))

    def assert_alone(self, source, *changes):
        switched = self.switch(source, *changes)
        self.assertEqual(switched.alone, set(range(1, len(changes) + 1)))
        self.assertEqual(switched.text, source)

    def test_an_expression_in_a_function(self):
        self.assert_becomes("int f(int a, int b) { return a + b; }\n",
                            "int f(int a, int b) { if (farshade_mutant(1)) { return a - b; } else { return a + b; } }",
                            ("a + b", "a - b"))

    def test_two_mutations_of_one_function(self):
        self.assert_becomes("int f(int a) { return a + 1; }",
                            "int f(int a) { if (farshade_mutant(1)) { return a - 1; }"
                            " else if (farshade_mutant(2)) { return a + 2; } else { return a + 1; } }",
                            ("a + 1", "a - 1"), ("+ 1", "+ 2"))

    def test_functions_of_their_own_have_switches_of_their_own(self):
        self.assert_becomes("void f() { g(1); }\nvoid h() { g(2); }",
                            "void f() { if (farshade_mutant(2)) { g(3); } else { g(1); } }"
                            " void h() { if (farshade_mutant(1)) { g(4); } else { g(2); } }",
                            ("g(2)", "g(4)"), ("g(1)", "g(3)"))

    def test_a_deleted_statement(self):
        self.assert_becomes("void C::f() const { g();\n h(); }",
                            "void C::f() const { if (farshade_mutant(1)) { h(); } else { g(); h(); } }", ("g();\n", ""))

    def test_a_mutation_that_names_the_whole_function_is_one_of_its_body(self):
        self.assert_becomes("int f() { return 1; }",
                            "int f() { if (farshade_mutant(1)) { return 2; } else { return 1; } }",
                            ("int f() { return 1; }", "int f() { return 2; }"))

    def test_braces_in_literals_and_comments_do_not_count(self):
        self.assert_becomes("void f() { g('}', \"}\"); // }\n h(1); }",
                            "void f() { if (farshade_mutant(1)) { g('}', \"}\"); // }\n h(2); }"
                            " else { g('}', \"}\"); // }\n h(1); } }", ("h(1)", "h(2)"))

    def test_a_template(self):
        self.assert_becomes("template <class T> T f(T a) noexcept { return a + 1; }",
                            "template <class T> T f(T a) noexcept { if (farshade_mutant(1)) { return a; }"
                            " else { return a + 1; } }", (" + 1", ""))

    def test_a_member_function_in_its_class(self):
        self.assert_becomes("struct S { int f() const { return 1; } int a = 1; };",
                            "struct S { int f() const { if (farshade_mutant(1)) { return 2; } else { return 1; } }"
                            " int a = 1; };", ("return 1", "return 2"))

    def test_a_constructor_keeps_its_initialisers(self):
        self.assert_becomes("C::C(int a) : a_(a), b_{a} { f(1); }",
                            "C::C(int a) : a_(a), b_{a} { if (farshade_mutant(1)) { f(2); } else { f(1); } }",
                            ("f(1)", "f(2)"))

    def test_a_lambda_is_part_of_the_function_around_it(self):
        self.assert_becomes("int f() { return g([](int a) { return a; }); }",
                            "int f() { if (farshade_mutant(1)) { return g([](int a) { return -a; }); }"
                            " else { return g([](int a) { return a; }); } }", ("return a", "return -a"))

    def test_a_lambda_outside_of_functions(self):
        self.assert_becomes("const auto f = [](int a) { return a; };",
                            "const auto f = [](int a) { if (farshade_mutant(1)) { return -a; } else { return a; } };",
                            ("return a", "return -a"))

    def test_a_function_that_is_a_try_block(self):
        self.assert_becomes("int f() try { return 1; } catch (int a) { return a; }",
                            "int f() try { if (farshade_mutant(1)) { return 2; } else { return 1; } }"
                            " catch (int a) { if (farshade_mutant(2)) { return -a; } else { return a; } }",
                            ("return 1", "return 2"), ("return a", "return -a"))

    def test_a_constexpr_function_still_makes_constants(self):
        switched = self.switch("constexpr int f(int a) { return a; }", ("return a", "return -a"))
        self.assertIn("if (farshade_mutant_unless_constant(1))", switched.text)
        self.assertEqual(switched.constexpr, {1})

    def test_a_constant(self):
        self.assert_becomes("constexpr int kA = f(1, 2);\n",
                            "inline const int kA = farshade_mutant(1) ? ( f(1, 3) ) : ( f(1, 2));",
                            ("kA = f(1, 2)", "kA = f(1, 3)"))

    def test_two_mutations_of_a_constant_of_a_class(self):
        self.assert_becomes("struct S {\n static constexpr int kA = 1;\n};",
                            "struct S { static inline const int kA = farshade_mutant(1) ? ( 2 )"
                            " : farshade_mutant(2) ? ( 3 ) : ( 1); };", ("kA = 1", "kA = 2"), ("kA = 1;", "kA = 3;"))

    def test_one_of_several_constants_of_a_declaration(self):
        self.assert_becomes("constexpr int kA = 1, kB = 2;",
                            "inline const int kA = 1, kB = farshade_mutant(1) ? ( 3 ) : ( 2);", ("kB = 2", "kB = 3"))

    def test_what_is_neither_code_of_a_function_nor_a_constant_has_a_build_of_its_own(self):
        self.assert_alone("struct S { int a = 1; };", ("= 1", "= 2"))
        self.assert_alone("constexpr int kA[] = {1, 2};\nint b[3];", ("b[3]", "b[4]"))
        self.assert_alone("constexpr std::array kA{1, 2};", ("{1, 2}", "{2, 1}"))
        self.assert_alone("constexpr int f(int a);", ("int a", "int b"))
        self.assert_alone("int f(int a) { return a; }", ("int a", "int& a"))
        self.assert_alone("consteval int f() { return 1; }", ("return 1", "return 2"))
        self.assert_alone("void f() { g(); }\nvoid h() { g(1); }",
                          ("g(); }\nvoid h() { g(1)", "g(2); }\nvoid h() { g()"))

    def test_a_mutation_that_closes_the_function_has_a_build_of_its_own(self):
        self.assert_alone("void f() { g(); }", ("g();", "} void h() {"))
        self.assert_alone("void f() { g(); }", ("g();", "{ g();"))
        self.assert_alone("void f() { g(); }", ("g();", "g(;"))

    def test_refuses_a_text_that_does_not_occur_once(self):
        for find in ("g", "k", ""):
            with self.assertRaises(ValueError):
                self.switch("void f() { g(); g(); }", (find, "h"))


class SwitchesInGlsl(unittest.TestCase):
    def test_lines_stand_between_conditions(self):
        switched = Switched("a.glsl", "void f() {\n  a = 1;\n  b = 1;\n}\n",
                            [(4, "a = 1", "a = 2"), (7, "b = 1;\n", ""), (9, "a = 1;\n  b = 1", "a = 3;\n  b = 3")])
        self.assertEqual(switched.text, "void f() {\n"
                         "#if FARSHADE_MUTANT == 4\n  a = 2;\n  b = 1;\n}\n"
                         "#elif FARSHADE_MUTANT == 7\n  a = 1;\n  }\n"
                         "#elif FARSHADE_MUTANT == 9\n  a = 3;\n  b = 3;\n}\n"
                         "#else\n  a = 1;\n  b = 1;\n}\n#endif\n")


class ShaderCompiler(unittest.TestCase):
    """tests/mutations/glslang.py with a compiler that a shell script plays: its word is 10 times the mutation's number,
    but mutation 3 changes nothing and mutation 4 does not compile."""
    COMPILER = """#!/bin/sh
number=${1#-DFARSHADE_MUTANT=}
[ $number != 4 ] || { echo "ERROR: a.comp:2: wrong"; exit 1; }
[ $number != 3 ] || number=0
printf 'const uint32_t a_spv[] = {\\n0x%d0\\n};\\n' $number >"$5"
"""

    def compile(self, *numbers):
        """Returns (status, header, stderr) for a shader that includes a file with mutations."""
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder)
            (root / "a.comp").write_text('#include "b.glsl"\n#include <c>\nvoid main() {}\n')
            (root / "b.glsl").write_text("".join(f"#if FARSHADE_MUTANT == {n}\n#endif\n" for n in numbers))
            (root / "glslangValidator").write_text(self.COMPILER)
            (root / "glslangValidator").chmod(0o755)
            command = [sys.executable, "-B", ROOT / "tests/mutations/glslang.py", f"-I{root}", "-DX",
                       "-o", root / "a.h", "--vn", "a_spv", root / "a.comp"]
            done = subprocess.run(command, capture_output=True, text=True, check=False,
                                  env={**os.environ, "PATH": f"{folder}:{os.environ['PATH']}"})
            return done.returncode, (root / "a.h").read_text() if (root / "a.h").is_file() else "", done.stderr

    def test_the_header_has_the_words_of_each_mutation(self):
        status, header, _ = self.compile(1, 2)
        self.assertEqual(status, 0)
        for number in (0, 1, 2):
            self.assertIn(f"inline constexpr std::uint32_t a_spv_{number}[] = {{\n0x{number}0\n}};", header)
        words_of = "std::span<const std::uint32_t>(a_spv_{})"
        self.assertIn(f" a_spv = farshade_mutant(1) ? {words_of.format(1)} : farshade_mutant(2) ? {words_of.format(2)}"
                      f" : {words_of.format(0)};", header)

    def test_a_mutation_of_other_shaders_takes_no_room(self):
        self.assertNotIn("a_spv_3", self.compile(3)[1])

    def test_names_the_mutation_that_does_not_compile(self):
        status, header, stderr = self.compile(1, 4)
        self.assertEqual((status, header), (1, ""))
        self.assertEqual(blamed(stderr, {}), {4})


class BlamedMutations(unittest.TestCase):
    """Which mutations cause the errors of a compiler."""
    FILES = {"a/code.cpp": Switched("a/code.cpp", "constexpr int kA = 1;\nvoid f() {\n  g(1);\n  h(1);\n}\n",
                                    [(1, "kA = 1", "kA = 2"), (2, "g(1)", "g(2)"), (3, "h(1)", "h(2)")])}

    def line(self, text):
        return self.FILES["a/code.cpp"].text[:self.FILES["a/code.cpp"].text.index(text)].count("\n") + 1

    def blamed(self, line):
        return blamed(f"In file\n/tree/a/code.cpp:{line}:3: error: wrong\n", self.FILES)

    def test_the_one_with_the_line(self):
        self.assertEqual(self.blamed(self.line("g(2)")), {2})
        self.assertEqual(self.blamed(self.line("h(2)")), {3})

    def test_all_of_a_function_if_the_line_is_none_of_theirs(self):
        text = self.FILES["a/code.cpp"].text
        self.assertEqual(self.blamed(text[:text.rindex("g(1)")].count("\n") + 1), {2, 3})

    def test_a_constant_that_is_named(self):
        self.assertEqual(blamed("/tree/b.cpp:2:1: error: the value of 'farshade::kA' is not usable", self.FILES), {1})

    def test_the_number_that_a_shader_compiler_is_told(self):
        self.assertEqual(blamed("mutant 3: ERROR: a.glsl:2: wrong", self.FILES), {3})

    def test_nobody_for_other_files(self):
        self.assertEqual(blamed("/tree/b.cpp:2:1: error: wrong", self.FILES), set())


class Choice(unittest.TestCase):
    MUTATIONS = [{**GOOD, "area": area, "name": str(i), "number": i} for area in "ab" for i in range(50)]

    def choose(self, *arguments):
        with contextlib.redirect_stdout(io.StringIO()):
            return mutate.choose(self.MUTATIONS, *arguments)

    def test_a_seed_repeats_a_random_choice(self):
        chosen = self.choose("", 20, 7)
        self.assertEqual(len({mutate.name_of(m) for m in chosen}), 20)
        self.assertEqual(chosen, self.choose("", 20, 7))
        self.assertNotEqual(chosen, self.choose("", 20, 8))

    def test_a_random_choice_is_one_of_the_area(self):
        self.assertEqual({m["area"] for m in self.choose("b", 20, 7)}, {"b"})

    def test_there_are_no_more_than_all(self):
        self.assertEqual(self.choose("a", 51, 7), self.MUTATIONS[:50])

    def test_refuses_an_area_that_is_not_there(self):
        with self.assertRaises(SystemExit):
            self.choose("c", None, 7)


class Complaint(unittest.TestCase):
    """What the output of a test program says about a mutation."""

    def complaint(self, status, output):
        return mutate.complaint("unit_code", "Sum.*", status, output)

    def test_none_about_tests_that_pass(self):
        self.assertIsNone(self.complaint(0, "[==========] 2 tests from 1 test suite ran. (0 ms total)\n"))

    def test_names_the_test_that_fails(self):
        self.assertEqual(self.complaint(1, "[  FAILED  ] Sum.OfTwo (0 ms)\n[  FAILED  ] 1 test\n"), "Sum.OfTwo")

    def test_names_the_signal_of_a_crash(self):
        self.assertIn("status -6", self.complaint(-6, "terminate called\n"))

    def test_a_filter_without_tests(self):
        self.assertIn("no test", self.complaint(0, "[==========] 0 tests from 0 test suites ran. (0 ms total)\n"))

    def test_tests_that_are_all_skipped(self):
        ran = "[==========] 2 tests from 1 test suite ran. (0 ms total)\n[  SKIPPED ] {} tests.\n"
        self.assertIn("skips", self.complaint(0, ran.format(2)))
        self.assertIsNone(self.complaint(0, ran.format(1)))


class Limits(unittest.TestCase):
    """Runs of a program that a shell script plays."""

    def run_program(self, script, limit_s, mutant=0):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "unit_code"
            path.write_text(f"#!/bin/sh\n{script}\n")
            path.chmod(0o755)
            copy = mutate.Copy(Path(folder), 1)
            copy.programs["unit_code"] = path
            return copy.run("unit_code", "Sum.*", limit_s, mutant)

    def test_a_program_that_hangs_is_ended(self):
        self.assertIn("did not end within", self.run_program("exec sleep 1000", 0.1))

    def test_a_program_sees_its_mutant_and_so_does_one_that_it_starts(self):
        passed = "echo '1 test from 1 test suite ran.'"
        self.assertIsNone(self.run_program(f"sh -c '[ $FARSHADE_MUTANT = 7 ]' && {passed}", 60, 7))
        self.assertIn("status 1", self.run_program(f"sh -c '[ $FARSHADE_MUTANT = 7 ]' && {passed}", 60, 8))

    def test_an_abort_is_a_failure(self):
        self.assertIn("status -6", self.run_program("kill -ABRT $$", 60))


if __name__ == "__main__":
    unittest.main()
