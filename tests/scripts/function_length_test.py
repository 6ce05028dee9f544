"""function_length.py on sources whose functions are known."""
import unittest

from function_length import functions

LONG = "  x += 1;\n" * 61


def lengths(source):
    return [(head, lines) for _, lines, head in functions(source)]


class Functions(unittest.TestCase):
    def test_counts_from_brace_to_brace(self):
        self.assertEqual(lengths("int f() { return 1; }\n"), [("int f()", 1)])
        self.assertEqual(lengths(f"void f(int x) {{\n{LONG}}}\n"), [("void f(int x)", 63)])

    def test_finds_the_main_function_of_a_shader(self):
        self.assertEqual(lengths(f"layout(location = 0) in vec3 p;\nvoid main() {{\n{LONG}}}\n")[0][1], 63)

    def test_finds_members_constructors_and_qualified_functions(self):
        source = ("struct A {\n  explicit A(int b) : b_{b}, c_(b) {\n  }\n  int f() const noexcept override {\n  return 1;\n  }\n"
                  "  int b_;\n};\nauto A::g() -> std::vector<int> {\n  return {};\n}\n")
        self.assertEqual([lines for _, lines in lengths(source)], [2, 3, 3])

    def test_finds_a_constructor_whose_last_initialiser_has_braces(self):
        source = "A::A(int b) : b_(b), c_{b}, d_{} {\n  f();\n}\n"
        self.assertEqual(lengths(source), [("A::A(int b) : b_(b), c_{b}, d_{}", 3)])

    def test_finds_both_parts_of_a_function_that_is_a_try_block(self):
        source = "int f() try {\n  return g();\n} catch (...) {\n  return 0;\n}\n"
        self.assertEqual(lengths(source), [("int f() try", 3), ("catch (...)", 3)])

    def test_counts_a_lambda_with_the_function_around_it(self):
        source = f"void f() {{\n  const auto g = [](int x) {{\n{LONG}  }};\n}}\n"
        self.assertEqual(lengths(source), [("void f()", 65)])

    def test_ignores_braces_in_comments_and_literals(self):
        source = 'void f() {\n  // }\n  /* } */\n  const char* s = "}";\n  const char c = \'}\';\n}\n'
        self.assertEqual(lengths(source), [("void f()", 6)])

    def test_ignores_types_namespaces_and_initialisers(self):
        self.assertEqual(lengths("namespace n {\nstruct A {\n  int x;\n};\nconst int list[] = {\n  1,\n};\n}\n"), [])


if __name__ == "__main__":
    unittest.main()
