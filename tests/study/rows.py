"""Rows: one dictionary for each measured mode, as in results.csv, with short names for the medians. Every table and
plot is made of rows."""
import csv
from typing import NamedTuple

# Columns that state what was measured. The columns of figures follow.
SAID = ["kind", "part", "axis", "x", "scene", "trace", "network", "network_words", "size", "mode", "words", "again",
        "frames", "every", "start_up_frames"]
# Short names for the medians that plots and tables use: name -> (group, figure).
SHORT = {"flip": ("error", "flip"), "ssim": ("error", "ssim"), "psnr": ("error", "psnr"),
         "mask_error": ("error", "mask_error"), "staleness": ("wire", "staleness"), "latency": ("wire", "latency"),
         "black": ("error", "black"), "other_surface": ("error", "other_surface"), "unknown": ("error", "unknown"),
         "bytes": ("wire", "down_bytes"), "bytes_up": ("wire", "up_bytes"), "answers": ("wire", "answers"),
         "client_ms": ("time", "client_frame"), "answer_ms": ("time", "server_frame")}
# Modes without a server: their errors are measured on one network only.
ALONE = ("local", "full")
# What one measurement is about, besides the mode and its settings.
CASE = ("size", "scene", "trace", "network")
EQUAL_PICTURES_DB = 99  # the PSNR that study_point states for equal pictures


class Metric(NamedTuple):
    error: str  # key of the error: smaller is better, 0 is exact
    shown: str  # key of the figure that tables show
    label: str
    head: str  # label with the unit


FLIP = Metric("flip", "flip", "FLIP", "FLIP")
METRICS = (FLIP, Metric("psnr_loss", "psnr", "PSNR", "PSNR, dB"), Metric("ssim_loss", "ssim", "SSIM", "SSIM"))


def mode_name(words):
    return words.split(",")[0]


def with_short_names(row):
    """Adds the medians under their short names, and the errors of METRICS. A figure that was not measured is None."""
    for short, (group, name) in SHORT.items():
        row[short] = row.get(f"{group}.{name}.median")
    row["psnr_loss"] = None if row["psnr"] is None else EQUAL_PICTURES_DB - row["psnr"]
    row["ssim_loss"] = None if row["ssim"] is None else 1 - row["ssim"]
    return row


def rounds_of(rows):
    """(scene, head, size, network, words) -> the row of the timing rounds."""
    return {tuple(r[k] for k in (*CASE, "words")): r for r in rows if r["part"] == "timing" and not r["again"]}


def timed(row, rounds):
    """The row with client_ms, and with server_ms and both_ms per shown frame. Its run times are those of its rounds, if
    there are any, or else its own."""
    measured = rounds.get(tuple(row[k] for k in (*CASE, "words")), row)
    answer_ms = measured["answer_ms"] or row["answer_ms"] or 0.0  # rounds may be too short for an answer to arrive
    answers = row["answers"] if row["answers"] is not None and row["kind"] == "error" else 1
    client_ms, server_ms = measured["client_ms"], answer_ms * answers
    both_ms = None if client_ms is None else client_ms + server_ms
    return row | {"client_ms": client_ms, "server_ms": server_ms, "both_ms": both_ms}


def with_times(rows):
    rounds = rounds_of(rows)
    return [timed(row, rounds) for row in rows]


def on_every_network(rows):
    """The rows of the modes. Those of modes without a server are repeated for every network, each with the run times of
    the rounds on that network."""
    modes = [r for r in rows if r["part"] == "mode"]
    networks, rounds = {r["network"]: r["network_words"] for r in modes}, rounds_of(rows)
    return [timed(row | {"network": network, "network_words": words}, rounds) if row["mode"] in ALONE else row
            for row in modes for network, words in networks.items()
            if row["mode"] in ALONE or row["network"] == network]


def number_in(text):
    """A number of results.csv. Returns None for an empty field."""
    if text == "":
        return None
    return int(text) if text.isdigit() else float(text)


def read_csv(path):
    """The rows of a results.csv, without pictures and single rounds. Raises ValueError if it is another file."""
    with open(path, newline="", encoding="utf-8") as file:
        reader = csv.DictReader(file)
        missing = [c for c in SAID if c not in (reader.fieldnames or [])]
        if missing:
            raise ValueError(f"{path} has no column '{missing[0]}'; it must be a results.csv of a study")
        rows = []
        for told in reader:
            row = {k: number_in(v) if "." in k or k in ("size", "again", "x", "frames", "every") else v
                   for k, v in told.items()}
            rows.append(with_short_names(row))
    return with_times(rows)
