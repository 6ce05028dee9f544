"""Makes rows from finished points and writes results.csv, results.json, plots and report.html."""
import csv
import io
import json
import os

import report
from rows import SAID, mode_name, with_short_names, with_times


def figures_row(settings, words, result, figures):
    row = {k: settings.get(k, "") for k in SAID} | {
        "mode": mode_name(words), "words": words, "again": 0, "start_up_frames": result.get("start_up_frames", "")}
    for group, named in figures.items():
        for name, spread in named.items():
            for of, value in spread.items():
                row[f"{group}.{name}.{of}"] = value
    return with_short_names(row)


def rows_of(points):
    """`points` are pairs of settings and the path of the result. Returns a row for each mode."""
    rows = []
    for settings, path in points:
        result = json.loads(path.read_text(encoding="utf-8"))["result"]
        if settings["kind"] == "timing":
            for entry in result:
                row = figures_row(settings, entry["mode"], {}, entry["figures"])
                row["again"] = int(entry["again"])
                # A round has no times if no answer came, as with too many positions for a network with losses.
                row["rounds"] = [r["time"] for r in entry["rounds"] if "time" in r]
                rows.append(row)
        elif settings["kind"] == "clients":
            rows.append(figures_row(settings, "hybrid", result, result))
        else:
            groups = {k: v for k, v in result.items() if k in ("error", "wire", "time")}
            row = figures_row(settings, settings["modes"][0], result, groups)
            row["pictures"] = path.with_suffix(".pictures")
            rows.append(row)
    return with_times(rows)


def as_csv(rows):
    figures = sorted({k for row in rows for k in row if "." in k})
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(SAID + figures)
    for row in rows:
        writer.writerow([row.get(k, "") for k in SAID + figures])
    return text.getvalue()


def write_whole(path, text):
    beside = path.with_name(path.name + ".tmp")
    beside.write_text(text, encoding="utf-8")
    os.replace(beside, path)


def write(out, header, points):
    """Writes all files. Returns the rows."""
    rows = rows_of(points)
    write_whole(out / "results.csv", as_csv(rows))
    kept = [{"settings": s, **json.loads(p.read_text(encoding="utf-8"))} for s, p in points]
    write_whole(out / "results.json", json.dumps({"header": header, "points": kept}, indent=1) + "\n")
    plots, page = report.make(header, rows)
    (out / "plots").mkdir(exist_ok=True)
    for name, svg in plots.items():
        write_whole(out / "plots" / f"{name}.svg", svg)
    write_whole(out / "report.html", page)
    return rows
