"""Plots as SVG. A mode has one colour in all plots. Each point has an id, with which the page finds its description.
"""
import html
import io
import math
import re

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from analysis import exponent, grouped, pareto  # noqa: E402

# Okabe and Ito, "Color universal design", 2008: nearly everybody can distinguish these colours, also in print.
COLOURS = {"hybrid": "#d55e00", "client-positions": "#e69f00", "server-gbuffer": "#009e73", "remote": "#0072b2",
           "delta": "#56b4e9", "local": "#cc79a7", "full": "#000000"}
OTHER = "#777777"
REFERENCE = "full"  # has no error by definition
MARKS = {"hybrid": "o", "client-positions": "s", "server-gbuffer": "D", "remote": "^", "delta": "v", "local": "P",
         "full": "X"}

plt.rcParams.update({"svg.fonttype": "none", "font.family": "sans-serif", "font.size": 8, "axes.spines.top": False,
                     "axes.spines.right": False, "axes.grid": True, "grid.color": "#e4e4e4", "axes.axisbelow": True,
                     "lines.linewidth": 1.2, "axes.titlesize": 8, "legend.frameon": False})


class Points:
    """Numbers the points of all plots of a page and keeps the description of each."""

    def __init__(self):
        self.told = []

    def add(self, text):
        self.told.append(text)
        return f"point-{len(self.told) - 1}"


def words_of(row, *figures):
    said = [row["words"], f"{row['scene']}, {row['trace']}, {row['network']}, {row['size']} px"]
    return "\n".join(said + [f"{label}: {row[key]:.4g}" for key, label in figures if row.get(key) is not None])


def svg_of(figure, name, points):
    plt.rcParams["svg.hashsalt"] = name  # so that every run writes the same bytes
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None}, bbox_inches="tight")
    plt.close(figure)
    svg = text.getvalue()
    svg = svg[svg.index("<svg"):]
    # Several plots share a page, and its ids must be unique.
    svg = re.sub(r'(id="|xlink:href="#|url\(#)(?!point-)', rf"\g<1>{name}-", svg)

    def titled(match):
        told = points.told[int(match[1])]
        return f'<g id="point-{match[1]}" class="point"><title>{html.escape(told)}</title>'
    return re.sub(r'<g id="point-(\d+)">', titled, svg)


def mark(axes, row, x, y, points, told, **more):
    axes.plot([x], [y], MARKS.get(row["mode"], "o"), color=COLOURS.get(row["mode"], OTHER), markersize=4.5,
              gid=points.add(told), **more)


def legend(figure, modes):
    handles = [plt.Line2D([], [], color=COLOURS.get(m, OTHER), marker=MARKS.get(m, "o"), markersize=4.5, label=m)
               for m in modes]
    handles.append(plt.Line2D([], [], color="#999999", linestyle=":", marker="o", markersize=8,
                              markerfacecolor="none", label=f"Pareto front without {REFERENCE}"))
    figure.legend(handles=handles, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncol=len(handles))


def front(axes, pairs):
    chosen = [pairs[i] for i in pareto(pairs)]
    axes.plot([p[0] for p in chosen], [p[1] for p in chosen], ":", color="#999999", linewidth=0.9, zorder=1)
    axes.plot([p[0] for p in chosen], [p[1] for p in chosen], "o", markersize=8.5, markerfacecolor="none",
              markeredgecolor="#999999", markeredgewidth=0.9, zorder=1)


def log_from_zero(axes, values):
    """Makes the x axis logarithmic with a place for 0: it is linear up to the smallest positive value."""
    least = min((v for v in values if v > 0), default=1)
    axes.set_xscale("symlog", linthresh=10 ** math.floor(math.log10(least)), linscale=0.6)


def error_against(name, rows, x, x_label, columns, points, error=("flip", "FLIP")):
    """A row of small plots for each scene and head, and a column for each value of `columns`. Lines join the rows of a
    mode. Returns None if there are no rows."""
    rows = [r for r in rows if r.get(x) is not None and r.get(error[0]) is not None]
    if not rows:
        return None
    downs, acrosses = list(grouped(rows, "scene", "trace")), list(grouped(rows, columns)) if columns else [()]
    figure, grid = plt.subplots(len(downs), len(acrosses), squeeze=False, sharex=True, sharey="row",
                                figsize=(max(4.5, 2.6 * len(acrosses)), 2.0 * len(downs)), layout="constrained")
    for i, down in enumerate(downs):
        for j, across in enumerate(acrosses):
            axes = grid[i][j]
            cell = [r for r in rows if (r["scene"], r["trace"]) == down and (not columns or r[columns] == across[0])]
            for own in grouped(cell, "mode" if columns else "words").values():
                axes.plot([r[x] for r in own], [r[error[0]] for r in own], zorder=2,
                          color=COLOURS.get(own[0]["mode"], OTHER))
                for row in own:
                    mark(axes, row, row[x], row[error[0]], points,
                         words_of(row, (x, x_label), error, ("psnr", "PSNR, dB"), ("mask_error", "mask error, %")))
            front(axes, [(r[x], r[error[0]]) for r in cell if r["mode"] != REFERENCE])
            if i == 0 and columns:
                axes.set_title(across[0])
            if j == 0:
                axes.set_ylabel(f"{down[0]}, {down[1]}\n{error[1]}")
            if i == len(downs) - 1:
                axes.set_xlabel(x_label)
    values = [r[x] for r in rows]
    for axes in grid.flat:
        if columns and max(values) > 30 * min(values):
            log_from_zero(axes, values)
        elif columns and max(values) > 3 * min(values):
            axes.set_xscale("log")
        axes.set_ylim(bottom=min(0, axes.get_ylim()[0]))
    legend(figure, [m for (m,) in grouped(rows, "mode")])
    return svg_of(figure, name, points)


def scaling(name, rows, axis, label, points):
    """Plots client and server time over one number, with the fitted powers. Also returns the fits: one for each mode and
    side."""
    own = [r for r in rows if r["part"] == "scaling" and r["axis"] == axis and not r["again"]]
    if not own:
        return None, []
    figure, grid = plt.subplots(1, 2, figsize=(9, 3.2), layout="constrained")
    fits = []
    for axes, (key, side) in zip(grid, (("client_ms", "client"), ("server_ms", "server"))):
        for (words,), series in grouped(own, "words").items():
            series = [r for r in series if r.get(key)]
            if not series:
                continue
            for row in series:
                mark(axes, row, row["x"], row[key], points,
                     f"{words}\n{axis}: {row['x']:,}\n{side}: {row[key]:.4g} ms")
            fit = exponent([r["x"] for r in series], [r[key] for r in series])
            if fit is None:
                continue
            fits.append({"axis": axis, "mode": words, "side": side, "from": min(r["x"] for r in series),
                         "to": max(r["x"] for r in series), **fit})
            ends = [fits[-1]["from"], fits[-1]["to"]]
            axes.plot(ends, [fit["factor"] * x ** fit["exponent"] for x in ends], "--",
                      color=COLOURS.get(series[0]["mode"], OTHER), label=f"{words}: x^{round(fit['exponent'], 2) + 0:.2f}")
        axes.set(xscale="log", yscale="log", xlabel=label, ylabel=f"{side}, ms per frame")
        if axes.has_data():
            axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1), ncol=2)
        else:
            axes.set_visible(False)
    return svg_of(figure, name, points), fits
