"""Tries to read every file below a folder as a head recording with vr_client --export-trace. Prints a table in Markdown;
scripts/heads --help names the results."""
import argparse
import sys
import tempfile
from collections import Counter
from pathlib import Path

from scenes import BAD, attempt, failure


def tried(path, options):
    """(result, what the program says) of a file."""
    with tempfile.TemporaryDirectory() as folder:
        done = attempt([options.programs / "vr_client/vr_client", "--config", "", "--trace", path, "--export-trace",
                        Path(folder) / "head.tum", *options.more], options.timeout)
    wrong = failure(done)
    if wrong:
        return wrong
    lines = [line.removeprefix("vr_client: ").removeprefix(f"{path.name}: ") for line in done.stderr.splitlines()]
    return ("read with doubt" if len(lines) > 1 else "read"), "; ".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--programs", type=Path, required=True, help="the build folder")
    parser.add_argument("--timeout", type=float, default=60, help="seconds for each file")
    words = sys.argv[1:]
    end = words.index("--") if "--" in words else len(words)
    options = parser.parse_args(words[:end])
    options.more = words[end + 1:]  # options of vr_client
    files = sorted(path for path in options.folder.rglob("*") if path.is_file())
    if not files:
        sys.exit(f"heads: there is no file below {options.folder}")
    print("| file | result | what the program says |\n|---|---|---|")
    counts = Counter()
    for path in files:
        result, sentence = tried(path, options)
        counts[result] += 1
        sentence = sentence.replace(f"{options.folder}/", "").replace("|", "\\|")
        print(f"| {path.relative_to(options.folder)} | {result} | {sentence} |", flush=True)
    print(f"\n{len(files)} files: " + ", ".join(f"{count} {result}" for result, count in counts.most_common()))
    return 1 if BAD & set(counts) else 0


if __name__ == "__main__":
    sys.exit(main())
