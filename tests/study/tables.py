"""The report's tables: what is said follows from the rows, and nothing is said of rows that are not there."""
import html
from statistics import median

from analysis import better_in_both, cost_at, grouped
from sweep import ALONE

CASE = ("scene", "trace", "network", "size")
SERVER = "hybrid"
COSTS = (("client_ms", "client, ms"), ("server_ms", "server, ms"), ("both_ms", "both, ms"),
         ("bytes", "bytes down a frame"))
ERRORS = (("flip", "FLIP"), ("mask_error", "mask error, %"))


def on_every_network(rows):
    """Modes that ask no server are measured on one network, and stand for themselves on all."""
    networks = {r["network"]: r["network_words"] for r in rows}
    return [row | {"network": network, "network_words": words} if row["mode"] in ALONE else row
            for row in rows for network, words in networks.items()
            if row["mode"] in ALONE or row["network"] == network]


def number(value, digits=3):
    if value is None:
        return "-"
    if abs(value) >= 10 ** digits:
        return f"{value:,.0f}"
    return f"{value:.{digits}g}"


def table(caption, heads, rows):
    """Cells that are numbers are set right."""
    if not rows:
        return ""

    def cell(value):
        if isinstance(value, str):
            return f"<td>{html.escape(value)}"
        return f'<td class="n">{number(value)}'
    body = "".join("<tr>" + "".join(map(cell, row)) for row in rows)
    return (f"<table><caption>{html.escape(caption)}</caption><tr>"
            + "".join(f"<th>{html.escape(h)}" for h in heads) + f"{body}</table>")


def case_words(row):
    return [row["scene"], row["trace"], row["network"]]


def equal_error(modes, other, cost, unit):
    """What `other` costs where it is as wrong as hybrid, by its curve over its settings."""
    lines, ratios = [], []
    for _, own in grouped(modes, *CASE).items():
        curve = [(r[cost], r["flip"]) for r in own
                 if r["mode"] == other and r.get(cost) is not None and r["flip"] is not None]
        for row in own:
            if row["words"] != SERVER or row["flip"] is None or row.get(cost) is None or not curve:
                continue
            there, how = cost_at(curve, row["flip"])
            said = {"never": f"never: at best FLIP {number(min(e for _, e in curve))}",
                    "at most": f"at most {number(there)}", "between": number(there)}[how]
            ratio = row[cost] / there if there else None
            if ratio is not None and how == "between":
                ratios.append(ratio)
            lines.append([*case_words(row), row["flip"], row[cost], said,
                          f"at least {number(ratio)}" if ratio is not None and how == "at most" else ratio])
    told = table(f"At the FLIP that hybrid has, {other} interpolated over its settings; {unit}.",
                 ["scene", "head", "network", "FLIP", "hybrid", other, f"hybrid / {other}"], lines)
    if ratios:
        told += (f"<p>Where both are equally wrong, hybrid takes {number(min(ratios))} to {number(max(ratios))} times "
                 f"what {other} takes ({number(median(ratios))} in the middle, {len(ratios)} of {len(lines)} cases).</p>")
    elif lines:
        told += f"<p>In none of {len(lines)} cases do the two meet within what was measured.</p>"
    return told


def latencies(modes):
    """Display time minus when what is shown was asked for, and what answering and drawing take on top; heads' middle."""
    networks = [network for (network,) in grouped(modes, "network")]

    def middle(rows, figure):
        values = [r[figure] for r in rows if r.get(figure) is not None]
        return median(values) if values else None
    lines = [[scene, words, *(middle([r for r in own if r["network"] == network], "latency") for network in networks),
              middle(own, "answer_ms") or 0.0, middle(own, "client_ms")]
             for (scene, words), own in grouped(modes, "scene", "words").items()]
    return table("Milliseconds from when the masks or the picture were asked for to their display, medians, by network: "
                 "network and whole frames alone, for servers take no virtual time. On this machine an answer and a "
                 "client's frame take what the last columns say; without pipelining that comes on top.",
                 ["scene", "mode", *networks, "answer", "frame"], lines)


def exponents(fits):
    lines = [[f["axis"], f["mode"], f["side"], f"{f['from']:,} to {f['to']:,}",
              f"{round(f['exponent'], 2) + 0:.2f}" + (f" ± {f['interval']:.2f}" if f["interval"] is not None else ""),
              f"{f['spread']:.2f}"] for f in fits]
    return table("Time goes with this power; ± is the 95 % interval of the fit, spread the largest ratio between a "
                 "measured median and the fit.", ["of", "mode", "side", "from, to", "exponent", "spread"], lines)


def ablations(rows):
    """Hybrid without one of its parts, beside hybrid whole."""
    parts = [r for r in rows if r["part"] == "ablation"]
    lines = []
    for case, own in grouped(parts, *CASE).items():
        whole = [r for r in rows if r["part"] == "mode" and r["words"] == SERVER and tuple(r[k] for k in CASE) == case]
        for row in whole + own:
            lines.append([*case_words(row), row["words"], row["flip"], row["mask_error"], row["psnr"], row["unknown"],
                          row["bytes"]])
    return table("Medians of the worse eye. `wait` shows a frame once its own masks are there: every frame comes later by "
                 "the way to the server and back, which is in no column.",
                 ["scene", "head", "network", "way", "FLIP", "mask error, %", "PSNR, dB", "unknown, %", "bytes"], lines)


def where_hybrid_loses(modes):
    """Every case in which another mode is better in error and in what it takes, both. `full` is the reference."""
    lines, cases, lost = [], 0, 0
    for _, own in grouped([r for r in modes if r["mode"] != "full"], *CASE).items():
        for row in own:
            if row["words"] != SERVER:
                continue
            for cost, cost_words in COSTS:
                for error, error_words in ERRORS:
                    others = [r for r in own if r["mode"] != SERVER]
                    comparable = [r for r in (row, *others) if r.get(error) is not None and r.get(cost) is not None]
                    if len(comparable) < 2 or comparable[0] is not row:
                        continue
                    cases += 1
                    better = better_in_both(others, row, cost, error)
                    lost += bool(better)
                    for (mode,), ways in grouped(better, "mode").items():
                        best = ways[0]
                        lines.append([*case_words(row), best["words"], error_words, row[error], best[error],
                                      cost_words, row[cost], best[cost]])
    if not cases:
        return ""
    return (f"<p>In {lost} of {cases} comparisons (scene, head, network, error, cost) another mode than full is at "
            "least as good in both error and cost, and better in one.</p>"
            + table("Of each such mode the way with the least error.",
                    ["scene", "head", "network", "better", "error", "hybrid", "it", "cost", "hybrid", "it"], lines))


def noise(rows):
    """The same way twice in every round: what differs is the machine."""
    lines = []
    timed = [r for r in rows if r["part"] == "timing"]
    for case, own in grouped(timed, *CASE).items():
        again = [r for r in own if r["again"]]
        first = [r for r in own if not r["again"] and again and r["words"] == again[0]["words"]]
        if not again or not first:
            continue
        for figure, label in (("client_frame", "client"), ("server_frame", "server")):
            pairs = [(a[figure]["median"], b[figure]["median"]) for a, b in zip(first[0]["rounds"], again[0]["rounds"])
                     if figure in a and figure in b]
            if pairs:
                both = [v for pair in pairs for v in pair]
                lines.append([case[0], case[2], again[0]["words"], label, median(a for a, _ in pairs),
                              median(b for _, b in pairs), f"{max(abs(a / b - 1) for a, b in pairs if b):.1%}",
                              f"{max(both) / min(both) - 1:.1%}" if min(both) > 0 else "-"])
    return table("The first way twice in every round. Differences between ways that are smaller than these mean "
                 "nothing.", ["scene", "network", "way", "side", "once, ms", "again, ms", "most within a round",
                              "most of all rounds"], lines)


def timings(rows):
    lines = [[r["scene"], r["network"], r["words"] + (" (again)" if r["again"] else ""),
              *(r.get(f"time.{f}.{q}") for f in ("client_frame", "server_frame") for q in ("median", "p95", "p99"))]
             for r in rows if r["part"] == "timing"]
    return table("Milliseconds a frame, over all rounds.",
                 ["scene", "network", "way", "client median", "p95", "p99", "server median", "p95", "p99"], lines)


def figures(modes):
    lines = [[*case_words(r), r["words"], r["flip"], r.get("error.flip.p95"), r["psnr"], r["ssim"], r["mask_error"],
              r["black"], r["staleness"] and round(r["staleness"], 3) + 0.0, r["bytes"], r["bytes_up"], r["client_ms"], r["server_ms"]]
             for r in modes]
    return table("Medians, and p95 where it says so; errors of the worse eye, bytes of a shown frame.",
                 ["scene", "head", "network", "way", "FLIP", "FLIP p95", "PSNR, dB", "SSIM", "mask error, %",
                  "black, %", "staleness, ms", "bytes down", "bytes up", "client, ms", "server, ms"], lines)


def all_of(rows, fits):
    modes = on_every_network([r for r in rows if r["part"] == "mode"])
    parts = [("Where hybrid loses", where_hybrid_loses(modes)),
             ("Bytes of hybrid and remote at equal FLIP", equal_error(modes, "remote", "bytes", "bytes down a frame")),
             ("Client time of hybrid and local at equal FLIP", equal_error(modes, "local", "client_ms", "ms a frame")),
             ("End-to-end latency", latencies(modes)), ("Scaling", exponents(fits)), ("Ablations", ablations(rows)),
             ("Noise", noise(rows)), ("Run times", timings(rows)), ("All figures", figures(modes))]
    return "\n".join(f"<section><h2>{html.escape(title)}</h2>{body}</section>" for title, body in parts if body)
