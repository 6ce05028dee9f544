"""Plots as SVG. A mode has one colour in all plots. Each point has an id, with which the page finds its description.
"""
import html
import io
import math
import re
import textwrap

import matplotlib
import matplotlib.ticker

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from analysis import exponent, grouped, pareto  # noqa: E402
from rivals import REFERENCE  # noqa: E402
from rows import EQUAL_PICTURES_DB  # noqa: E402

# Okabe and Ito, "Color universal design", 2008: nearly everybody can distinguish these colours, also in print.
COLOURS = {"hybrid": "#d55e00", "client-positions": "#e69f00", "server-gbuffer": "#009e73", "remote": "#0072b2",
           "delta": "#56b4e9", "local": "#cc79a7", "full": "#000000"}
OTHER = "#777777"
MARKS = {"hybrid": "o", "client-positions": "s", "server-gbuffer": "D", "remote": "^", "delta": "v", "local": "P",
         "full": "X"}

FULL_PRESUMES = (
    "full presumes a client that can trace all rays of both eyes itself, with the scene's acceleration structure in "
    "its memory. In this study it traces with Embree on the CPU cores that all modes use. A headset does not have such "
    "a CPU.")
FULL_HAS_NO_SERVER = "full is not drawn: it needs no server."
# How plots draw the errors of METRICS: the label of the axis, and whether it is logarithmic. Lower is better for all.
AXES = {"flip": ("FLIP", True), "psnr_loss": ("PSNR, dB (downwards)", False), "ssim_loss": ("1 - SSIM", True)}

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


# Figures in the description of every point.
FIGURES = (("flip", "FLIP"), ("psnr", "PSNR, dB"), ("ssim", "SSIM"), ("mask_error", "mask error, %"))


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
    handles = [plt.Line2D([], [], color=COLOURS.get(m, OTHER), marker=MARKS.get(m, "o"), markersize=4.5,
                          linestyle="--" if m == REFERENCE else "-",
                          label=f"{m}: dashed line at its cost" if m == REFERENCE else m) for m in modes]
    handles.append(plt.Line2D([], [], color="#999999", linestyle=":", marker="o", markersize=8,
                              markerfacecolor="none", label=f"Pareto front without {REFERENCE}"))
    figure.legend(handles=handles, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncol=len(handles))


def front(axes, pairs):
    chosen = [pairs[i] for i in pareto(pairs)]
    axes.plot([p[0] for p in chosen], [p[1] for p in chosen], ":", color="#999999", linewidth=0.9, zorder=1)
    axes.plot([p[0] for p in chosen], [p[1] for p in chosen], "o", markersize=8.5, markerfacecolor="none",
              markeredgecolor="#999999", markeredgewidth=0.9, zorder=1, clip_on=False)


def cost_axis(axes, values):
    """Makes the x axis logarithmic if the values differ much. With a value of 0 it is linear from 0 to the smallest
    positive value."""
    least, most = min((v for v in values if v > 0), default=1), max(values)
    if min(values) > 0 and most > 3 * least:
        axes.set_xscale("log", subs=())
        axes.xaxis.set_major_locator(matplotlib.ticker.LogLocator(subs=(1, 2, 5)))
        axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    elif min(values) == 0 and most > 30 * least:
        threshold = 10 ** math.floor(math.log10(least))
        axes.set_xscale("symlog", linthresh=threshold, linscale=0.6)
        axes.set_xlim(left=-0.3 * threshold)


def exact_at(rows, error):
    """The height at which plots draw exact pictures, whose error is 0: below all other errors."""
    least = min((r[error] for r in rows if r[error] > 0), default=1)
    return least / 2.5 if AXES[error][1] else least - 4


def error_axis(axes, rows, error, exact):
    """Sets the y axis for the errors of `rows`, with exact pictures at the bottom."""
    worst = max(r[error] for r in rows)
    if AXES[error][1]:
        axes.set_yscale("log", subs=())  # no minor ticks
        axes.set_ylim(exact, max(worst, 2 * exact) * 1.4)
        axes.yaxis.set_major_locator(matplotlib.ticker.FixedLocator(
            [digit * 10 ** power for power in range(-9, 1) for digit in (1, 3) if digit * 10.0 ** power > 1.2 * exact]))
        axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    else:  # the errors are EQUAL_PICTURES_DB - PSNR
        axes.set_ylim(exact, max(worst + 4, exact + 16))  # with a tick
        axes.yaxis.set_major_locator(matplotlib.ticker.FixedLocator(
            [loss for loss in range(EQUAL_PICTURES_DB, 0, -10) if loss > exact + 2]))
        axes.yaxis.set_major_formatter(lambda loss, _: f"{EQUAL_PICTURES_DB - loss:.0f}")


def error_against(name, rows, x, x_label, columns, points, metric):
    """A row of small plots for each scene and head, and a column for each value of `columns`. Lines join the rows of a
    mode. A dashed line marks the cost of REFERENCE. Returns None if there are no rows."""
    error = metric.error
    rows = [r for r in rows if r.get(x) is not None and r.get(error) is not None]
    if not rows:
        return None
    downs, acrosses = list(grouped(rows, "scene", "trace")), list(grouped(rows, columns)) if columns else [()]
    figure, grid = plt.subplots(len(downs), len(acrosses), squeeze=False, sharex=True, sharey="row",
                                figsize=(max(5.5, 2.6 * len(acrosses)), 2.0 * len(downs) + 0.8), layout="constrained")
    for i, down in enumerate(downs):
        of_row = [r for r in rows if (r["scene"], r["trace"]) == down]
        exact = exact_at(of_row, error)
        for j, across in enumerate(acrosses):
            axes = grid[i][j]
            cell = [r for r in of_row if not columns or r[columns] == across[0]]
            draw_cell(axes, cell, (x, x_label), columns, points, lambda row, exact=exact: row[error] or exact)
            if i == 0 and columns:
                axes.set_title(across[0])
            if j == 0:
                axes.set_ylabel(f"{down[0]}, {down[1]}\n{AXES[error][0]}")
                axes.text(-0.02, exact, "exact", transform=axes.get_yaxis_transform(), ha="right", va="center",
                          fontsize=7)
            if i == len(downs) - 1:
                axes.set_xlabel(x_label)
        error_axis(grid[i][0], of_row, error, exact)
        if columns:
            cost_axis(grid[i][0], [r[x] for r in rows])
    legend(figure, [m for (m,) in grouped(rows, "mode")])
    figure.supxlabel(textwrap.fill(FULL_PRESUMES, 120 if columns else 75), fontsize=7, color="#555555")
    return svg_of(figure, name, points)


def draw_cell(axes, rows, cost, columns, points, height_of):
    """Draws the points of one small plot, the lines between them, their Pareto front and the cost of REFERENCE."""
    x = cost[0]
    for own in grouped(rows, "mode" if columns else "words").values():
        axes.plot([r[x] for r in own], [height_of(r) for r in own], zorder=2, color=COLOURS.get(own[0]["mode"], OTHER))
        for row in own:
            mark(axes, row, row[x], height_of(row), points, words_of(row, cost, *FIGURES), clip_on=False)
            if row["mode"] == REFERENCE:
                axes.axvline(row[x], color=COLOURS[REFERENCE], linestyle="--", linewidth=0.8, alpha=0.5, zorder=0)
    others = [(r[x], height_of(r)) for r in rows if r["mode"] != REFERENCE]
    if others:  # matplotlib gives an empty line a place, which breaks the layout
        front(axes, others)


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
    figure.supxlabel(FULL_HAS_NO_SERVER if axis == "clients" else textwrap.fill(FULL_PRESUMES, 120), fontsize=7,
                     color="#555555")
    return svg_of(figure, name, points), fits
