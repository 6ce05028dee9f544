"""Puts mutations into source files so that one build holds all of them and a program's environment chooses one.

C++: the function body around a mutation becomes `{ if (farshade_mutant(7)) {mutated body} else {body} }`. A constant
outside of functions becomes one that is computed when the program starts: `farshade_mutant(7) ? (mutated) : (value)`.
GLSL: the lines around a mutation stand between #if and #endif; glslang.py compiles each shader once per mutation.
What fits neither (the size of an array, a table) needs a build of its own.
"""
import os
import re
import sys
from collections import defaultdict, namedtuple
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "scripts"))
from function_length import bodies, code_of  # pylint: disable=wrong-import-position

GLSL = re.compile(r"\.(glsl|comp|vert|frag)$")
HEADER = '#include "tests/mutations/mutant.h"\n'

# A part of a source file, and what kind of part: "body", "constexpr body", "constant" or "lines".
Place = namedtuple("Place", "start end kind")


class Switched:
    """The text of a file with its mutations, which are triples (number, find, replace)."""

    def __init__(self, name, source, mutations):
        self.text = ""
        self.lines = []                    # (first line, last line, numbers) of each variant in `text`
        self.constants = defaultdict(set)  # the numbers of the mutations of each constant, by its name
        self.constexpr = set()             # numbers that have no effect where the compiler computes a constant
        self.alone = set()                 # numbers that need a build of their own
        self._source, self._code = source, code_of(source)
        self._places = defaultdict(dict)   # place -> number -> (start, end, new text)
        self._keywords = {}                # start -> (end, new text) of the keywords of constants
        changes = {number: change(source, find, replace) for number, find, replace in mutations}
        if GLSL.search(name):
            self._place_lines(changes)
        else:
            self._place_cpp(changes)
        self._write()

    def _place_cpp(self, changes):
        functions = list(bodies(self._source))
        for number, (start, end, new) in changes.items():
            place = around(functions, start, end) or self._constant_around(number, start, end)
            if place and is_enclosed(self._source[place.start:start] + new + self._source[end:place.end], place.kind):
                self._places[place][number] = (start, end, new)
                if place.kind == "constexpr body":
                    self.constexpr.add(number)
            else:
                self.alone.add(number)

    def _constant_around(self, number, start, end):
        """Returns the value that the text from `start` to `end` is a part of, if that is a constant's."""
        begin = max(self._code.rfind(c, 0, start) for c in ";{}") + 1
        declared = re.compile(r"\s*((?:(?:inline|static)\s+)*)constexpr\b").match(self._code, begin)
        if not declared:
            return None
        value, depth = None, 0
        for at in range(declared.end(), len(self._code)):
            c = self._code[at]
            depth += (c in "([{") - (c in ")]}")
            if depth == 0 and c in ",;":
                if value is not None and value <= start and end <= at:
                    break
                if c == ";":
                    return None
                value = None
            elif depth == 0 and c == "=" and value is None:
                value = at + 1
        name = re.search(r"(\w+)\s*=$", self._code[begin:value])
        if not name:
            return None
        self.constants[name[1]].add(number)
        self._keywords[declared.start(1)] = (declared.end(), declared[1].replace("inline ", "") + "inline const")
        return Place(value, at, "constant")

    def _place_lines(self, changes):
        """Mutations of the same lines share a place."""
        spans = []
        for start, end, _ in sorted(changes.values()):
            first = self._source.rfind("\n", 0, start) + 1
            last = (self._source.find("\n", end) + 1) or len(self._source)
            if spans and first < spans[-1][1]:
                spans[-1][1] = max(last, spans[-1][1])
            else:
                spans.append([first, last])
        for number, (start, end, new) in changes.items():
            first, last = next(s for s in spans if s[0] <= start and end <= s[1])
            self._places[Place(first, last, "lines")][number] = (start, end, new)

    def _write(self):
        at = 0
        edits = [(start, *edit) for start, edit in self._keywords.items()]
        edits += [(place.start, place.end, place) for place in self._places]
        if any(place.kind != "lines" for place in self._places):
            self.text = HEADER
        for start, end, new in sorted(edits, key=lambda e: e[:2]):
            self.text += self._source[at:start]
            at = end
            if isinstance(new, str):
                self.text += new
            else:
                self._write_variants(new)
        self.text += self._source[at:]

    def _write_variants(self, place):
        before, between, last, after = {
            "body": ("{{ if (farshade_mutant({}))\n", "\nelse if (farshade_mutant({}))\n", "\nelse\n", " }"),
            "constexpr body": ("{{ if (farshade_mutant_unless_constant({}))\n",
                               "\nelse if (farshade_mutant_unless_constant({}))\n", "\nelse\n", " }"),
            "constant": (" farshade_mutant({}) ? (\n", "\n) : farshade_mutant({}) ? (\n", "\n) : (\n", ")"),
            "lines": ("#if FARSHADE_MUTANT == {}\n", "#elif FARSHADE_MUTANT == {}\n", "#else\n", "#endif\n"),
        }[place.kind]
        for number, (start, end, new) in self._places[place].items():
            self.text += before.format(number)
            before = between
            self._write_variant(self._source[place.start:start] + new + self._source[end:place.end], {number})
        self.text += last
        self._write_variant(self._source[place.start:place.end], set(self._places[place]))
        self.text += after

    def _write_variant(self, text, numbers):
        first = self.text.count("\n") + 1
        self.text += text
        self.lines.append((first, self.text.count("\n") + 1, numbers))


def change(source, find, replace):
    """Returns (start, end, new text) of what is different after `find`, which occurs once, becomes `replace`."""
    if not find or source.count(find) != 1:
        raise ValueError(f"the text to find occurs {source.count(find) if find else 0} times, not once: {find}")
    equal = len(os.path.commonprefix([find, replace]))
    equal_end = len(os.path.commonprefix([find[equal:][::-1], replace[equal:][::-1]]))
    start = source.index(find)
    return start + equal, start + len(find) - equal_end, replace[equal:len(replace) - equal_end]


def around(functions, start, end):
    """Returns the function body that the text from `start` to `end` is a part of."""
    for first, last, head in functions:
        if first < start and end < last:
            if re.search(r"\bconsteval\b", head):
                return None
            return Place(first, last, "constexpr body" if re.search(r"\bconstexpr\b", head) else "body")
    return None


def is_enclosed(text, kind):
    """Whether the brackets of a body or value match, so that what follows it stays what it was."""
    code = code_of(text).strip() if kind != "constant" else f"({code_of(text)})"
    opening, open_brackets = {")": "(", "]": "[", "}": "{"}, []
    for at, c in enumerate(code):
        if c in opening.values():
            open_brackets.append(c)
        elif c in opening and (not open_brackets or open_brackets.pop() != opening[c]):
            return False
        if not open_brackets:
            return at + 1 == len(code)
    return False


def blamed(output, files):
    """Returns the numbers of the mutations that a compiler's output complains about. `files` are Switched by name.

    A constant that is computed when the program starts causes errors where it is used, and those name it."""
    names = set(re.findall(r"'(?:\w+::)*(\w+)'", output))
    constants = [(name, numbers) for file in files.values() for name, numbers in file.constants.items()]
    numbers = {number for name, of_name in constants if name in names for number in of_name}
    numbers |= {int(n) for n in re.findall(r"^mutant (\d+):", output, re.MULTILINE)}  # from glslang.py
    if numbers:
        return numbers
    for path, line in re.findall(r"^(\S+?):(\d+):\d+: (?:fatal )?error:", output, re.MULTILINE):
        file = next((file for name, file in files.items() if path.endswith(f"/{name}")), None)
        for first, last, of_lines in file.lines if file else ():
            if first <= int(line) <= last:
                numbers |= of_lines
    return numbers
