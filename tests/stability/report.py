"""Makes one HTML page of stability.csv: the verdicts, and the figures of each sweep as curves with their bounds."""
import argparse
import csv
import html
import math
from collections import defaultdict

# The figures that are plotted for each sweep, in this order.
PLOTTED = ["false shadow traced", "false light traced", "false shadow shown", "false light shown",
           "reprojection largest", "surface largest", "picture off", "predictor turn", "client frame"]
WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 300, 190, 56, 10, 24, 34
STYLE = """
body { font: 14px/1.4 system-ui, sans-serif; margin: 2em auto; max-width: 1320px; color: #222; }
table { border-collapse: collapse; } td, th { padding: 2px 10px 2px 0; text-align: left; vertical-align: top; }
td.n { text-align: right; font-variant-numeric: tabular-nums; } .bad { color: #b00; font-weight: bold; }
svg { margin: 4px; background: #fafafa; } text { font: 10px system-ui, sans-serif; fill: #444; }
"""


class Axis:
    """Maps values to pixels. Logarithmic if positive values span more than a factor of 30; 0 is then at the end."""

    def __init__(self, values, low_px, high_px):
        positive = [v for v in values if v > 0]
        self.floor = min(positive, default=1)
        self.log = bool(positive) and max(positive) > 30 * self.floor
        at = [self._of(v) for v in values]
        self.low, self.high = min(at), max(at)
        if self.high == self.low:
            self.high += 1
        self.has_zero = self.log and min(values) <= 0
        self.low_px, self.high_px = low_px, high_px

    def _of(self, value):
        return math.log10(max(value, self.floor / 10)) if self.log else value

    def px(self, value):
        return self.low_px + (self._of(value) - self.low) / (self.high - self.low) * (self.high_px - self.low_px)

    def ticks(self):
        if self.log:
            first, last = math.ceil(self.low - 1e-9), math.floor(self.high + 1e-9)
            if self.has_zero:
                first += 1
            step = max(1, math.ceil((last - first) / 5))
            ticks = [10.0 ** e for e in range(first, last + 1, step)]
            return [0] + ticks if self.has_zero else ticks
        return [self.low + (self.high - self.low) * i / 4 for i in range(5)]


def plot(title, unit, points):
    """An SVG plot. `points` are (x, value, bound or None, good), sorted by x."""
    bounds = [b for _, _, b, _ in points if b is not None]
    x_axis = Axis([p[0] for p in points], LEFT, WIDTH - RIGHT)
    y_axis = Axis([p[1] for p in points] + bounds + [0], HEIGHT - BOTTOM, TOP)
    parts = [f'<svg width="{WIDTH}" height="{HEIGHT}" role="img"><text x="{LEFT}" y="14" font-weight="bold">'
             f'{html.escape(title)}{", " + html.escape(unit) if unit else ""}</text>']
    for tick in x_axis.ticks():
        x = x_axis.px(tick)
        parts.append(f'<line x1="{x:.1f}" x2="{x:.1f}" y1="{TOP}" y2="{HEIGHT - BOTTOM}" stroke="#ddd"/>'
                     f'<text x="{x:.1f}" y="{HEIGHT - BOTTOM + 14}" text-anchor="middle">{tick:.3g}</text>')
    for tick in y_axis.ticks():
        y = y_axis.px(tick)
        parts.append(f'<line x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{y:.1f}" y2="{y:.1f}" stroke="#ddd"/>'
                     f'<text x="{LEFT - 4}" y="{y + 3:.1f}" text-anchor="end">{tick:.3g}</text>')
    if bounds:
        line = " ".join(f"{x_axis.px(x):.1f},{y_axis.px(b):.1f}" for x, _, b, _ in points if b is not None)
        parts.append(f'<polyline points="{line}" fill="none" stroke="#c33" stroke-dasharray="5 3"/>')
    line = " ".join(f"{x_axis.px(x):.1f},{y_axis.px(v):.1f}" for x, v, _, _ in points)
    parts.append(f'<polyline points="{line}" fill="none" stroke="#246" stroke-width="1.5"/>')
    for x, value, _, good in points:
        parts.append(f'<circle cx="{x_axis.px(x):.1f}" cy="{y_axis.px(value):.1f}" r="2.5" '
                     f'fill="{"#246" if good else "#c00"}"/>')
    return "".join(parts) + "</svg>"


def strain(row):
    if not row["bound"]:
        return -1
    value, bound = float(row["value"]), float(row["bound"])
    if math.isnan(value):
        return math.inf
    return value / bound if bound > 0 else (math.inf if value > 0 else 0)


def main(source, target):
    with open(source, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    cases = defaultdict(list)
    for row in rows:
        cases[row["case"]].append(row)
    bad = [name for name, own in cases.items() if any(row["verdict"] != "ok" for row in own)]
    page = ["<!doctype html><meta charset='utf-8'><title>Stability</title><style>", STYLE, "</style>",
            f"<h1>Stability</h1><p>{len(cases)} cases, {len(bad)} beyond a bound. Bounds are dashed red.</p>"]

    sweeps = defaultdict(lambda: defaultdict(list))
    for row in rows:
        if row["sweep"] and row["figure"] in PLOTTED and math.isfinite(float(row["value"])):
            bound = float(row["bound"]) if row["bound"] else None
            sweeps[row["sweep"]][row["figure"]].append(
                (float(row["x"]), float(row["value"]), bound, row["verdict"] == "ok", row["unit"],
                 row["extreme"].split(" = ")[0]))
    for sweep, figures in sweeps.items():
        title = next(iter(figures.values()))[0][5]
        page.append(f"<h2>{html.escape(title)}</h2>")
        for figure in PLOTTED:
            if figure in figures:
                points = sorted(figures[figure])
                page.append(plot(figure, points[0][4], [p[:4] for p in points]))

    page.append("<h2>Cases</h2><table><tr><th>case<th>what is extreme<th>figure closest to its bound<th>value<th>bound<th>")
    for name, own in cases.items():
        worst = max(own, key=strain)
        mark = "<td class=bad>BROKEN" if name in bad else "<td>ok"
        page.append(f"<tr><td>{html.escape(name)}<td>{html.escape(worst['extreme'])}<td>{worst['figure']}, "
                    f"{worst['unit']}<td class=n>{worst['value']}<td class=n>{worst['bound']}{mark}")
    page.append("</table>")
    with open(target, "w", encoding="utf-8") as file:
        file.write("\n".join(page))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("table", help="stability.csv of scripts/stability")
    parser.add_argument("page", help="the HTML file to write")
    arguments = parser.parse_args()
    main(arguments.table, arguments.page)
