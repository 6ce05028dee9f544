"""Compares two results.csv point by point: before and after a change, or one setting with another. Exit status 1 if a
limit does not hold. Errors are those of the worse eye, times those of the client; all are medians."""
import argparse
import math
import sys
from pathlib import Path
from statistics import median
from typing import NamedTuple

from rows import CASE, read_csv


class Difference(NamedTuple):
    figure: str  # key of a row
    label: str
    option: str
    of: object  # (before, after) -> number; the larger, the worse


def lost(before, after):
    return before - after


def ratio(before, after):
    """after / before. Equal values have the ratio 1, also 0 and 0."""
    if before == after:
        return 1.0
    return after / before if before else math.inf


DIFFERENCES = (Difference("psnr", "PSNR lost, dB", "--psnr-loss", lost),
               Difference("mask_error", "mask error, after / before", "--mask-error", ratio),
               Difference("flip", "FLIP, after / before", "--flip", ratio),
               Difference("client_ms", "client time, after / before", "--client-time", ratio))
SHOWN = 5  # worst points of each figure


def points_of(rows, words=None):
    """Point -> row. With `words`, only the points with these settings, which are then no part of the key."""
    named = [r for r in rows if r["kind"] == "error" and words in (None, r["words"])]
    return {tuple(r[k] for k in CASE) + (() if words else (r["words"],)): r for r in named}


def differences(before, after, difference):
    """[(difference, point, before, after)] of the points that have the figure in both, the worst first."""
    found = []
    for point in before.keys() & after.keys():
        values = before[point][difference.figure], after[point][difference.figure]
        if None not in values:
            found.append((difference.of(*values), point, *values))
    return sorted(found, key=lambda f: (-f[0], f[1]))


def words_of(point):
    size, *rest = point
    return ", ".join([f"{size} px", *rest])


def judge(difference, found, limit):
    """Prints the worst points. Returns False if there is a limit that does not hold for every point, or that no point
    can be compared with."""
    holds = limit is None or bool(found and found[0][0] <= limit)
    verdict = "" if limit is None else f"; limit {limit:g}: {'holds' if holds else 'DOES NOT HOLD'}"
    if not found:
        print(f"{difference.label}: not measured in both{verdict}")
        return holds
    beyond = sum(f[0] > limit for f in found) if limit is not None else 0
    middle = median(f[0] for f in found)
    print(f"{difference.label}: median {middle:.4g}, worst {found[0][0]:.4g} of {len(found)} points" + verdict
          + (f" in {beyond}" if beyond else ""))
    for value, point, old, new in found[:SHOWN]:
        print(f"  {value:.4g}  {words_of(point)}: {old:.4g} -> {new:.4g}")
    return holds


def read_arguments(words):
    parser = argparse.ArgumentParser(prog="scripts/study --compare", description=__doc__)
    parser.add_argument("before", type=Path, help="results.csv")
    parser.add_argument("after", type=Path, help="results.csv; may be the same file")
    parser.add_argument("--words", nargs=2, metavar=("BEFORE", "AFTER"), default=(None, None),
                        help="compare only these settings: the first of `before` with the second of `after`")
    for difference in DIFFERENCES:
        parser.add_argument(difference.option, type=float, metavar="LIMIT", help=f"largest {difference.label}")
    return parser.parse_args(words)


def main(words):
    given = read_arguments(words)
    try:
        before, after = (points_of(read_csv(path), named)
                         for path, named in zip((given.before, given.after), given.words))
    except (OSError, ValueError) as wrong:
        print(f"study: {wrong}", file=sys.stderr)
        return 2
    common = before.keys() & after.keys()
    print(f"{len(common)} points are in both, {len(before) - len(common)} only before, "
          f"{len(after) - len(common)} only after")
    if not common:
        return 2
    limits = [getattr(given, d.option[2:].replace("-", "_")) for d in DIFFERENCES]
    held = [judge(d, differences(before, after, d), limit) for d, limit in zip(DIFFERENCES, limits)]
    return 0 if all(held) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
