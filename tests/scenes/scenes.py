"""Tries every glTF file below a folder with the programs of users: rt_server inspect loads it, vr_client draws one frame
with traced shadows. Prints a table in Markdown; scripts/scenes --help names the results."""
import argparse
import json
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

BAD = {"crashed", "timed out"}


def attempt(command, timeout_s):
    """Returns the finished process, or None after the timeout."""
    try:
        return subprocess.run([str(word) for word in command], capture_output=True, text=True, errors="replace",
                              timeout=timeout_s, check=False)
    except subprocess.TimeoutExpired:
        return None


def failure(done):
    """(result, sentence) of a process that did not end well; None for one that did."""
    if done is None:
        return "timed out", ""
    if done.returncode == 0:
        return None
    lines = done.stderr.strip().splitlines() or [""]
    if done.returncode < 0:
        return "crashed", f"signal {-done.returncode}: {lines[-1]}"
    return "refused", lines[-1]


def shade(pictures):
    """"all black" or "all white" if the pictures are; None otherwise."""
    from PIL import Image  # not needed for --help
    extremes = [Image.open(picture).convert("L").getextrema() for picture in pictures]
    if all(high <= 3 for _, high in extremes):
        return "all black"
    return "all white" if all(low >= 252 for low, _ in extremes) else None


def drawn(path, options):
    """(result, sentence) of a file that loads."""
    with tempfile.TemporaryDirectory() as folder:
        done = attempt([options.programs / "vr_client/vr_client", "--config", "", "--scene", path, "--trace", options.trace,
                        "--mode", "full", "--frames", 1, "--pictures", 1, "--size", options.size, "--out", folder], options.timeout)
        wrong = failure(done)
        if wrong:
            return wrong
        return shade(Path(folder).glob("frame_0001_*.png")), ""


def tried(path, options):
    """(result, sentence) of a file."""
    done = attempt([options.programs / "rt_server/rt_server", "--config", "", "inspect", "--json", path], options.timeout)
    wrong = failure(done)
    if wrong:
        return wrong
    prefix = path.name + ": "  # of what the file has and is not drawn; other notes tell what was chosen
    warnings = [note.removeprefix(prefix) for note in json.loads(done.stdout)["notes"] if note.startswith(prefix)]
    result, sentence = drawn(path, options)
    told = "drawn with warnings" if warnings else "drawn"
    if any(warning.startswith("repaired: ") for warning in warnings):
        told = "repaired"
    return result or told, sentence or "; ".join(warnings)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--programs", type=Path, required=True, help="the build folder")
    parser.add_argument("--trace", type=Path, required=True, help="a head recording")
    parser.add_argument("--timeout", type=float, default=60, help="seconds for each program")
    parser.add_argument("--size", default="128x128", help="pixels of each eye")
    options = parser.parse_args()
    files = sorted(p for p in options.folder.rglob("*") if p.suffix.lower() in (".glb", ".gltf") and p.is_file())
    if not files:
        sys.exit(f"scenes: there is no .glb or .gltf file below {options.folder}")
    print("| file | result | what the programs say |\n|---|---|---|")
    counts = Counter()
    for path in files:
        result, sentence = tried(path, options)
        counts[result] += 1
        name = str(path.relative_to(options.folder))
        sentence = sentence.replace(str(path), path.name).replace(f"{options.folder}/", "").replace("|", "\\|")
        print(f"| {name} | {result} | {sentence} |", flush=True)
    print(f"\n{len(files)} files: " + ", ".join(f"{count} {result}" for result, count in counts.most_common()))
    return 1 if BAD & set(counts) else 0


if __name__ == "__main__":
    sys.exit(main())
