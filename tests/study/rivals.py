"""Compares hybrid with the other modes in each cell: one size, scene, head and network. As a program it prints the
tables of a results.csv."""
import argparse
import sys
from pathlib import Path

from analysis import comparable, grouped, less_in_both
from rows import CASE, FLIP, METRICS, on_every_network, read_csv

SERVER = "hybrid"
REFERENCE = "full"  # needs no server and has no error
COST = "client_ms"
DOMINANCE_HEADS = ["px", "scene", "head", "network", "hybrid, ms", *(f"by {m.label}" for m in METRICS),
                   f"{REFERENCE}, ms"]
RANK_HEADS = ["px", "modes", "cells", *(f"first is better by {m.label}" for m in METRICS), "the metrics disagree in"]


def dominance(modes):
    """[{"row", "by": {metric: rows of other modes}, "full": {metric: rows of full}}] for each cell in which hybrid and
    another mode were measured. The rows have both less client time and less error than hybrid. Variants of hybrid with other settings
    are not other modes."""
    cells = []
    for own in grouped(modes, *CASE).values():
        for row in own:
            if row["words"] != SERVER or any(row[f] is None for f in (COST, *(m.error for m in METRICS))):
                continue
            others = [r for r in comparable(own, row, COST, FLIP.error) if r["mode"] != SERVER]
            if not others:
                continue
            rivals = [r for r in others if r["mode"] != REFERENCE]
            full = [r for r in others if r["mode"] == REFERENCE]
            cells.append({"row": row, "full": {m: less_in_both(full, row, COST, m.error) for m in METRICS},
                          "by": {m: less_in_both(rivals, row, COST, m.error) for m in METRICS}})
    return cells


def dominance_lines(cells):
    """A table row for each cell. It names the settings with the smallest error, or "-" if hybrid is not beaten. The last
    column is about full, by FLIP."""
    def named(rows):
        return f"{rows[0]['words']}: {rows[0][COST]:.3g} ms" if rows else "-"
    return [[str(c["row"]["size"]), *case_words(c["row"]), c["row"][COST], *(named(c["by"][m]) for m in METRICS),
             c["full"][FLIP][0][COST] if c["full"][FLIP] else "-"] for c in cells]


def dominance_sentences(cells):
    """One sentence for each size and metric. The first metric is the one that counts."""
    said = []
    for (size,), own in grouped([c | {"size": c["row"]["size"]} for c in cells], "size").items():
        for metric in METRICS:
            alone = sum(not c["by"][metric] for c in own)
            both = sum(not c["by"][metric] and not c["full"][metric] for c in own)
            counts = " (this one counts)" if metric is FLIP else ""
            said.append(f"{size} px, {metric.label}{counts}: in {share(alone, own)} no other mode has both less client "
                        f"time and less error than hybrid; with {REFERENCE} in {share(both, own)}.")
    return said


def share(count, cells):
    return f"{count} of {len(cells)} cells ({count / len(cells):.0%})"


def rank_differences(modes):
    """[{"size", "pair", "cells", "first": {metric: count}, "where": [row]}]: the pairs of modes that two metrics order
    differently in at least one cell. A mode stands for its best settings by the metric. `first` counts the cells in
    which the first mode of the pair has less error."""
    pairs, names = {}, [mode for (mode,) in grouped(modes, "mode")]
    for own in grouped([r for r in modes if r["mode"] != REFERENCE], *CASE).values():
        best = [(name, [smallest([r for r in own if r["mode"] == name], m.error) for m in METRICS]) for name in names]
        best = [(mode, errors) for mode, errors in best if None not in errors]
        for i, (one, errors) in enumerate(best):
            for other, others in best[i + 1:]:
                orders = [(a > b) - (a < b) for a, b in zip(errors, others)]
                pairs.setdefault((own[0]["size"], one, other), []).append((own[0], orders))
    return [{"size": size, "pair": (one, other), "cells": len(cells),
             "first": {m: sum(orders[i] < 0 for _, orders in cells) for i, m in enumerate(METRICS)},
             "where": [row for row, orders in cells if len(set(orders)) > 1]}
            for (size, one, other), cells in pairs.items() if any(len(set(orders)) > 1 for _, orders in cells)]


def smallest(rows, figure):
    return min((r[figure] for r in rows if r[figure] is not None), default=None)


def rank_lines(differences):
    def places(rows):
        return "; ".join(f"{scene}, {trace}: " + ", ".join(r["network"] for r in own)
                         for (scene, trace), own in grouped(rows, "scene", "trace").items())
    return [[str(d["size"]), " / ".join(d["pair"]), str(d["cells"]), *(str(d["first"][m]) for m in METRICS),
             places(d["where"])] for d in differences]


def case_words(row):
    return [row["scene"], row["trace"], row["network"]]


def as_text(heads, lines):
    """The table in columns of equal width."""
    cells = [heads] + [[c if isinstance(c, str) else f"{c:.3g}" for c in line] for line in lines]
    widths = [max(len(row[i]) for row in cells) for i in range(len(heads))]
    return "\n".join("  ".join(c.ljust(w) for c, w in zip(row, widths)).rstrip() for row in cells)


def main():
    parser = argparse.ArgumentParser(prog="scripts/study --tables", description=__doc__)
    parser.add_argument("results", type=Path, help="results.csv")
    try:
        modes = on_every_network(read_csv(parser.parse_args().results))
    except (OSError, ValueError) as wrong:
        sys.exit(f"study: {wrong}")
    cells, differences = dominance(modes), rank_differences(modes)
    print("Modes with both less client time and less error than hybrid, with their smallest error:\n")
    print(as_text(DOMINANCE_HEADS, dominance_lines(cells)), *dominance_sentences(cells), sep="\n")
    print("\nPairs of modes that FLIP, PSNR and SSIM order differently:\n")
    print(as_text(RANK_HEADS, rank_lines(differences)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
