#!/usr/bin/env python3
"""Compiles a shader with all its mutations into one header. scripts/mutate lets CMake call it in the place of glslang.

The sources hold the mutations between #if FARSHADE_MUTANT == NUMBER and #endif. In the header, the words of the shader
are those of the mutation that is on when the program starts.
"""
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

GLSLANG = shutil.which("glslangValidator") or shutil.which("glslang")
INCLUDES = '#pragma once\n#include <cstdint>\n#include <span>\n#include "tests/mutations/mutant.h"\n'


def numbers_in(path, root):
    """Returns the numbers of the mutations of a shader and of what it includes."""
    text = path.read_text(encoding="utf-8")
    numbers = {int(n) for n in re.findall(r"^#(?:el)?if FARSHADE_MUTANT == (\d+)$", text, re.MULTILINE)}
    for name in re.findall(r'^\s*#include "(.*)"', text, re.MULTILINE):
        if (root / name).is_file():
            numbers |= numbers_in(root / name, root)
    return numbers


def words(arguments, number):
    """Returns the body of the array of words, or the compiler's complaint as an exception."""
    with tempfile.NamedTemporaryFile(suffix=".h") as file:
        arguments = [file.name if before == "-o" else a for before, a in zip(["", *arguments], arguments)]
        done = subprocess.run([GLSLANG, f"-DFARSHADE_MUTANT={number}", *arguments], capture_output=True, text=True,
                              check=False)
        if done.returncode:
            raise ValueError("\n".join(f"mutant {number}: {line}" for line in done.stdout.splitlines()))
        return re.search(r"\{.*\}", Path(file.name).read_text(encoding="utf-8"), re.DOTALL)[0]


def main():
    arguments = sys.argv[1:]
    header, symbol = (arguments[arguments.index(option) + 1] for option in ("-o", "--vn"))
    root = Path(next(a[2:] for a in arguments if a.startswith("-I")))
    array, chosen, bodies = "", "", {}
    try:
        for number in (0, *sorted(numbers_in(Path(arguments[-1]), root))):
            body = words(arguments, number)
            if body not in bodies.values():
                bodies[number] = body
    except ValueError as error:
        sys.exit(str(error))
    for number, body in bodies.items():
        array += f"inline constexpr std::uint32_t {symbol}_{number}[] = {body};\n"
        if number:
            chosen += f"farshade_mutant({number}) ? std::span<const std::uint32_t>({symbol}_{number}) : "
    chosen += f"std::span<const std::uint32_t>({symbol}_0)"
    Path(header).write_text(f"{INCLUDES}{array}inline const std::span<const std::uint32_t> {symbol} = {chosen};\n",
                            encoding="utf-8")


if __name__ == "__main__":
    main()
