"""The report's tables. All sentences are computed from the rows. Without rows there is no table."""
import html
from statistics import median

import rivals
from analysis import better_in_both, cost_at, grouped
from rivals import SERVER, case_words
from rows import CASE, METRICS, on_every_network

COSTS = (("client_ms", "client, ms"), ("server_ms", "server, ms"), ("both_ms", "both, ms"),
         ("bytes", "bytes to the client per frame"))
ERRORS = (*((m.error, m.shown, m.head) for m in METRICS), ("mask_error", "mask_error", "mask error, %"))
LONG = 24  # longer tables are closed at first


def number(value, digits=3):
    if value is None:
        return "-"
    if abs(value) >= 10 ** digits:
        return f"{value:,.0f}"
    return f"{value:.{digits}g}"


def table(caption, heads, rows):
    """An HTML table; cells with numbers are aligned to the right."""
    if not rows:
        return ""

    def cell(value):
        if isinstance(value, str):
            return f"<td>{html.escape(value)}"
        return f'<td class="n">{number(value)}'
    body = "".join("<tr>" + "".join(map(cell, row)) for row in rows)
    told = f"<table><caption>{html.escape(caption)}</caption><tr>" + "".join(f"<th>{html.escape(h)}" for h in heads) + body
    if len(rows) <= LONG:
        return told + "</table>"
    return f"<details><summary>{len(rows)} lines: {html.escape(caption)}</summary>{told}</table></details>"


def sized(row):
    """The words of a case with its size in front."""
    return [str(row["size"]), *case_words(row)]


def equal_error(modes, other, cost, unit, metric):
    """The cost at which `other` has the same error as hybrid, interpolated over the settings of `other`."""
    lines, ratios = [], []
    for own in grouped(modes, *CASE).values():
        curve = [r for r in own if r["mode"] == other and r.get(cost) is not None and r[metric.error] is not None]
        for row in own:
            if row["words"] != SERVER or row[metric.error] is None or row.get(cost) is None or not curve:
                continue
            there, how = cost_at([(r[cost], r[metric.error]) for r in curve], row[metric.error])
            best = min(curve, key=lambda r: r[metric.error])[metric.shown]
            said = {"never": f"never: at best {metric.head} {number(best)}",
                    "at most": f"at most {number(there)}", "between": number(there)}[how]
            ratio = row[cost] / there if there else None
            if ratio is not None and how == "between":
                ratios.append(ratio)
            lines.append([*sized(row), row[metric.shown], row[cost], said,
                          f"at least {number(ratio)}" if ratio is not None and how == "at most" else ratio])
    told = table(f"Costs at the {metric.label} of hybrid, with {other} interpolated over its settings; {unit}.",
                 ["px", "scene", "head", "network", metric.head, "hybrid", other, f"hybrid / {other}"], lines)
    if ratios:
        told += (f"<p>At equal {metric.label}, the cost of hybrid is {number(min(ratios))} to {number(max(ratios))} times "
                 f"that of {other} (median {number(median(ratios))}, {len(ratios)} of {len(lines)} cases).</p>")
    elif lines:
        told += (f"<p>In none of {len(lines)} cases does the measured curve of {other} reach the {metric.label} of "
                 "hybrid.</p>")
    return told


def dominance(modes):
    """For each cell, the modes that have both less client time and less error than hybrid."""
    cells = rivals.dominance(modes)
    said = "".join(f"<p>{html.escape(sentence)}</p>" for sentence in rivals.dominance_sentences(cells))
    return said + table("Modes with both less client time and less error than hybrid, by each metric, with the settings "
                        "of the smallest error. The last column states the time of full if full has less time and less "
                        "FLIP.", rivals.DOMINANCE_HEADS, rivals.dominance_lines(cells))


def ranks(modes):
    """Where the metrics order two modes differently."""
    differences = rivals.rank_differences(modes)
    if not differences:
        return ""
    return table("Pairs of modes that FLIP, PSNR and SSIM order differently. A mode stands for its best settings by each "
                 "metric. The numbers are the cells in which the first mode has less error.", rivals.RANK_HEADS,
                 rivals.rank_lines(differences))


def latencies(modes):
    """The time from the request of the shown masks or picture to their display; medians over heads. Also the times of
    answering and drawing, which come on top."""
    networks = [network for (network,) in grouped(modes, "network")]

    def middle(rows, figure):
        values = [r[figure] for r in rows if r.get(figure) is not None]
        return median(values) if values else None
    lines = [[str(size), scene, words,
              *(middle([r for r in own if r["network"] == network], "latency") for network in networks),
              middle(own, "answer_ms") or 0.0, middle(own, "client_ms")]
             for (size, scene, words), own in grouped(modes, "size", "scene", "words").items()]
    return table("Milliseconds from the request of the masks or the picture to their display, medians for each network. They "
                 "contain only the network and whole frames, because servers take no virtual time. The last columns "
                 "state the time of an answer and of a client's frame; without pipelining, these are added.",
                 ["px", "scene", "mode", *networks, "answer", "frame"], lines)


def exponents(fits):
    lines = [[f["axis"], f["mode"], f["side"], f"{f['from']:,} to {f['to']:,}",
              f"{round(f['exponent'], 2) + 0:.2f}" + (f" ± {f['interval']:.2f}" if f["interval"] is not None else ""),
              f"{f['spread']:.2f}"] for f in fits]
    return table("The run time grows with this power. ± is the 95 % interval of the fit, spread the largest ratio between a "
                 "measured median and the fit.", ["of", "mode", "side", "from, to", "exponent", "spread"], lines)


def ablations(rows):
    """Hybrid with all parts, and without one part each."""
    parts = [r for r in rows if r["part"] == "ablation"]
    lines = []
    for case, own in grouped(parts, *CASE).items():
        whole = [r for r in rows if r["part"] == "mode" and r["words"] == SERVER and tuple(r[k] for k in CASE) == case]
        for row in whole + own:
            lines.append([*sized(row), row["words"], row["flip"], row["psnr"], row["ssim"], row["mask_error"],
                          row["unknown"], row["bytes"]])
    return table("Medians of the worse eye. `wait` shows a frame when its own masks have arrived, so every frame is shown a "
                 "round trip later; no column contains this delay.",
                 ["px", "scene", "head", "network", "settings", "FLIP", "PSNR, dB", "SSIM", "mask error, %", "unknown, %",
                  "bytes"], lines)


def where_hybrid_loses(modes):
    """Every case in which another mode is better in error and in cost. `full` is the reference and does not count."""
    lines, cases, lost = [], 0, 0
    for _, own in grouped([r for r in modes if r["mode"] != "full"], *CASE).items():
        for row in own:
            if row["words"] != SERVER:
                continue
            for cost, cost_words in COSTS:
                for error, shown, error_words in ERRORS:
                    others = [r for r in own if r["mode"] != SERVER]
                    comparable = [r for r in (row, *others) if r.get(error) is not None and r.get(cost) is not None]
                    if len(comparable) < 2 or comparable[0] is not row:
                        continue
                    cases += 1
                    better = better_in_both(others, row, cost, error)
                    lost += bool(better)
                    for (mode,), candidates in grouped(better, "mode").items():
                        best = candidates[0]
                        lines.append([*sized(row), best["words"], error_words, row[shown], best[shown],
                                      cost_words, row[cost], best[cost]])
    if not cases:
        return ""
    return (f"<p>In {lost} of {cases} comparisons (size, scene, head, network, error, cost) another mode than full is at "
            "least as good in both error and cost, and better in one.</p>"
            + table("For each of these modes, the settings with the smallest error.",
                    ["px", "scene", "head", "network", "better mode", "error", "hybrid", "other", "cost", "hybrid",
                     "other"], lines))


def noise(rows):
    """Run times of the same settings, measured twice in every round: the difference is the noise of the machine."""
    lines = []
    timed = [r for r in rows if r["part"] == "timing"]
    for own in grouped(timed, *CASE).values():
        again = [r for r in own if r["again"]]
        first = [r for r in own if not r["again"] and again and r["words"] == again[0]["words"]]
        if not again or not first:
            continue
        for figure, label in (("client_frame", "client"), ("server_frame", "server")):
            pairs = [(a[figure]["median"], b[figure]["median"]) for a, b in zip(first[0]["rounds"], again[0]["rounds"])
                     if figure in a and figure in b]
            if pairs:
                both = [v for pair in pairs for v in pair]
                lines.append([*sized(own[0]), again[0]["words"], label, median(a for a, _ in pairs),
                              median(b for _, b in pairs), f"{max(abs(a / b - 1) for a, b in pairs if b):.1%}",
                              f"{max(both) / min(both) - 1:.1%}" if min(both) > 0 else "-"])
    return table("The first settings, measured twice in every round. Smaller differences between other settings are "
                 "noise.", ["px", "scene", "head", "network", "settings", "side", "once, ms", "again, ms", "largest within a round",
                            "largest of all rounds"], lines)


def timings(rows):
    lines = [[*sized(r), r["words"] + (" (again)" if r["again"] else ""),
              *(r.get(f"time.{f}.{q}") for f in ("client_frame", "server_frame") for q in ("median", "p95", "p99"))]
             for r in rows if r["part"] == "timing"]
    return table("Milliseconds per frame, over all rounds.",
                 ["px", "scene", "head", "network", "settings", "client median", "p95", "p99", "server median", "p95",
                  "p99"], lines)


def figures(modes):
    lines = [[*sized(r), r["words"], r["flip"], r.get("error.flip.p95"), r["psnr"], r["ssim"], r["mask_error"],
              r["black"], r["other_surface"], r["staleness"] and round(r["staleness"], 3) + 0.0, r["bytes"], r["bytes_up"], r["client_ms"],
              r["server_ms"]] for r in modes]
    return table("Medians, except columns named p95. Errors of the worse eye, bytes per shown frame.",
                 ["px", "scene", "head", "network", "settings", "FLIP", "FLIP p95", "PSNR, dB", "SSIM", "mask error, %",
                  "black, %", "other surface, %", "staleness, ms", "bytes down", "bytes up", "client, ms", "server, ms"], lines)


def all_of(rows, fits):
    modes = on_every_network(rows)

    def at_equal_error(*which):
        return "".join(equal_error(modes, *which, metric) for metric in METRICS)
    parts = [("Modes that are faster and better than hybrid", dominance(modes)),
             ("Where the metrics disagree", ranks(modes)),
             ("Where hybrid loses", where_hybrid_loses(modes)),
             ("Bytes of hybrid and remote at equal error",
              at_equal_error("remote", "bytes", "bytes to the client per frame")),
             ("Client time of hybrid and local at equal error", at_equal_error("local", "client_ms", "ms per frame")),
             ("End-to-end latency", latencies(modes)), ("Scaling", exponents(fits)), ("Ablations", ablations(rows)),
             ("Noise", noise(rows)), ("Run times", timings(rows)), ("All figures", figures(modes))]
    return "\n".join(f"<section><h2>{html.escape(title)}</h2>{body}</section>" for title, body in parts if body)
