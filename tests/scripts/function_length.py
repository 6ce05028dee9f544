"""Lists the functions of C++ and GLSL sources that are longer than a limit, and fails if there is one.

It counts the lines from the opening to the closing brace of each function body. A lambda counts as part of the function
around it. The program knows no grammar: a body is a pair of braces after a parameter list, outside of other bodies.
"""
import argparse
import re
import subprocess
import sys
from pathlib import Path

# Functions that may be longer for now: (file, name). An entry that is no longer needed is an error, too.
EXCEPTIONS = set()

ROOT = Path(__file__).resolve().parents[2]
SOURCES = re.compile(r"\.(cpp|h|comp|glsl|vert|frag)$")
TEXT = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\'', re.DOTALL)
# What may be between a parameter list and its body: qualifiers, a return type, member initialisers.
HEAD = re.compile(r"\)\s*(const|noexcept|override|final|mutable|->[^;]*|:[^:].*)?(\s*(const|noexcept|override|final|try))*$",
                  re.DOTALL)
OTHER = re.compile(r"^(struct|class|namespace|enum|union)\b|^(template\b.*)?(struct|class|union)\s+\w+\s*$")


def blank(match):
    """Replaces a comment or a literal by spaces, so that its braces do not count. Line breaks stay."""
    return "".join("\n" if c == "\n" else " " for c in match[0])


def code_of(source):
    """Returns the text with spaces in the place of comments, literals and lines of the preprocessor."""
    return re.sub(r"^[ \t]*#.*(\\\n.*)*", blank, TEXT.sub(blank, source), flags=re.MULTILINE)


def bodies(source):
    """Yields (start, end, head) of each function body in a source file's text: from its brace to after its last one."""
    source = code_of(source)
    open_braces, start_of_head, body = [], 0, None
    for match in re.finditer(r"[{};]", source):
        if match[0] == "{":
            head = source[start_of_head:match.start()].strip()
            if body is None and HEAD.search(head) and not OTHER.search(head):
                body = len(open_braces)
            open_braces.append((match.start(), head, start_of_head))
        elif match[0] == "}" and open_braces:
            start, head, head_start = open_braces.pop()
            if body == len(open_braces):
                body = None
                if re.match(r"\s*[,{]", source[match.end():]):  # a member initialiser with braces
                    start_of_head = head_start
                    continue
                yield start, match.end(), " ".join(head.split())
        start_of_head = match.end()


def functions(source):
    """Yields (line of the opening brace, number of lines, head) of each function body in a source file's text."""
    for start, end, head in bodies(source):
        yield source.count("\n", 0, start) + 1, source.count("\n", start, end) + 1, head


def read_arguments():
    parser = argparse.ArgumentParser(prog="function_length.py", description=__doc__)
    parser.add_argument("--limit", type=int, default=60, help="longest function in lines; default %(default)s")
    parser.add_argument("files", nargs="*", type=Path, help="default: every source file that git knows")
    return parser.parse_args()


def main():
    arguments = read_arguments()
    files = arguments.files
    if not files:
        listed = subprocess.run(["git", "-C", ROOT, "ls-files"], capture_output=True, text=True, check=True).stdout
        files = [ROOT / name for name in listed.splitlines() if SOURCES.search(name) and (ROOT / name).is_file()]
    count = failures = 0
    excused = set()
    for path in files:
        for line, length, head in functions(path.read_text(encoding="utf-8")):
            count += 1
            if length > arguments.limit:
                name = re.search(r"(\w+)\s*\(", head)[1]
                place = (str(path.resolve().relative_to(ROOT)), name) if path.resolve().is_relative_to(ROOT) else None
                if place in EXCEPTIONS:
                    excused.add(place)
                    continue
                failures += 1
                print(f"{path}:{line}: {length} lines: {head[-100:]}")
    if not arguments.files:
        for file, name in sorted(EXCEPTIONS - excused):
            failures += 1
            print(f"{file}: {name} needs no exception")
    print(f"{count} functions in {len(files)} files; {len(excused)} exceptions, {failures} faults")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
