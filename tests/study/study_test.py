"""Runs a small study. It can be killed and continued, it reports what it leaves out, and its page opens in Chromium.

Needs two environment variables: STUDY_POINT is the program, STUDY_OUT a folder for the results.
"""
import base64
import csv
import html
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PROGRAM, OUT = os.environ["STUDY_POINT"], Path(os.environ["STUDY_OUT"])
PATIENCE_S = 900


def heed_ctrl_c():
    """A program that was started in the background ignores Ctrl-C, and so would its children."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


def begin(out, *more, sweep=HERE / "quick.json"):
    return subprocess.Popen([sys.executable, HERE / "study.py", sweep, "--root", ROOT, "--program", PROGRAM,
                             "--out", out, *more], stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                            preexec_fn=heed_ctrl_c)


def run(out, *more, sweep=HERE / "quick.json"):
    child = begin(out, *more, sweep=sweep)
    told, said = child.communicate(timeout=PATIENCE_S)
    return child.returncode, told, said


def points_in(out):
    """The name and the time of the last change of every finished point."""
    return {p.name: p.stat().st_mtime_ns for p in (out / "points").glob("*.json")}


def wait_for_points(child, out, count):
    """Waits until `count` points are finished and the child works on the next one."""
    give_up = time.monotonic() + PATIENCE_S
    while len(points_in(out)) < count:
        if child.poll() is not None or time.monotonic() > give_up:
            child.kill()
            raise AssertionError(f"{count} points were not finished: {child.communicate()[1]}")
        time.sleep(0.02)


def error_columns(out):
    """The rows of results.csv without run times."""
    with open(out / "results.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return [{k: v for k, v in row.items() if not k.startswith("time.")} for row in rows]


def setUpModule():
    """Runs the whole quick sweep."""
    shutil.rmtree(OUT, ignore_errors=True)
    OUT.mkdir(parents=True)
    status, _, said = run(OUT / "whole")
    assert status == 0, said


class Study(unittest.TestCase):
    whole = OUT / "whole"

    def test_writes_a_row_with_figures_for_each_mode(self):
        rows = error_columns(self.whole)
        full = [r for r in rows if r["mode"] == "full" and r["kind"] == "error"]
        self.assertEqual([r["size"] for r in full], ["32", "48"], "a mode without a server is measured on one network")
        self.assertEqual(float(full[0]["error.flip.median"]), 0, "the reference has no error")
        self.assertEqual(float(full[0]["error.mask_error.median"]), 0)
        self.assertEqual(float(full[0]["error.psnr.median"]), 99)
        late = {r["words"]: r for r in rows if (r["network"], r["size"], r["kind"]) == ("25 ms", "32", "error")}
        self.assertGreater(float(late["hybrid,reprojection=off"]["error.mask_error.median"]),
                           float(late["hybrid"]["error.mask_error.median"]))
        self.assertGreater(float(late["hybrid"]["wire.latency.median"]), 50, "two directions of 25 ms")
        self.assertGreater(float(late["hybrid"]["wire.down_bytes.median"]), 100)

    def test_draws_with_levels_of_detail_unless_the_words_say_otherwise(self):
        def errors(words):
            told = subprocess.run(
                [PROGRAM, "--scene", ROOT / "assets/room.glb", "--trace", ROOT / "assets/walk.csv", "--size", "64",
                 "--frames", "6", "--every", "2", "--modes", words],
                capture_output=True, text=True, timeout=PATIENCE_S, check=True)
            return json.loads(told.stdout)["error"]
        by_default, full, coarse = errors("hybrid"), errors("hybrid,detail=0"), errors("hybrid,detail=16")
        self.assertEqual(by_default, errors("hybrid,detail=0.125"))
        self.assertNotEqual(by_default, full)
        self.assertGreater(coarse["flip"]["median"], 1.2 * full["flip"]["median"])

    def test_keeps_pictures_of_worst_frames(self):
        for point in (self.whole / "points").glob("*.json"):
            if json.loads(point.read_text())["settings"]["kind"] == "error":
                names = sorted(p.name for p in point.with_suffix(".pictures").iterdir())
                self.assertEqual(names, [f"{eye}_{what}.png" for eye in ("left", "right")
                                         for what in ("heat", "reference", "shown")])

    def test_reports_all_metrics_at_every_size(self):
        measured = [r for r in error_columns(self.whole) if r["kind"] == "error"]
        self.assertEqual({r["size"] for r in measured}, {"32", "48"})
        for row in measured:
            for metric in ("flip", "psnr", "ssim"):
                self.assertNotEqual(row[f"error.{metric}.median"], "", row["words"])

    def test_times_the_first_mode_twice_and_modes_without_a_server_on_every_network(self):
        with open(self.whole / "results.csv", newline="", encoding="utf-8") as file:
            timed = [r for r in csv.DictReader(file) if r["part"] == "timing"]
        self.assertEqual([(r["size"], r["network"], r["words"], r["again"]) for r in timed],
                         [(size, network, words, again) for size in ("32", "48") for network in ("none", "25 ms")
                          for words, again in (("hybrid", "0"), ("full", "0"), ("hybrid", "1"))])
        for row in timed:
            self.assertGreater(float(row["time.client_frame.median"]), 0)
            if row["words"] == "full":  # it waits for no answer: 4 frames in each of 2 rounds, or in 1 round
                self.assertEqual(row["time.client_frame.count"], {"32": "8", "48": "4"}[row["size"]])

    def test_prints_its_tables_and_compares_its_results(self):
        path = self.whole / "results.csv"
        script = ROOT / "scripts" / "study"

        def study(*words):
            return subprocess.run([script, *words], capture_output=True, text=True, timeout=PATIENCE_S, check=False)
        told = study("--tables", path)
        self.assertEqual(told.returncode, 0, told.stderr)
        for size in (32, 48):
            self.assertRegex(told.stdout, rf"{size} px, FLIP \(this one counts\): in [0-2] of 2 cells")
        same = study("--compare", path, path, "--psnr-loss", "0", "--flip", "1", "--mask-error", "1")
        self.assertEqual(same.returncode, 0, same.stdout + same.stderr)
        worse = study("--compare", path, path, "--words", "hybrid", "hybrid,reprojection=off", "--mask-error", "1.05")
        self.assertEqual(worse.returncode, 1, worse.stdout + worse.stderr)
        self.assertIn("DOES NOT HOLD in 1", worse.stdout)

    def test_an_interrupted_study_says_how_to_continue_and_continues_to_the_same_results(self):
        out, only = OUT / "interrupted", ("--only", "^(mode|ablation).* 32 px")
        count = len(run(out, *only, "--list")[1].splitlines())
        child = begin(out, *only)
        wait_for_points(child, out, 1)
        child.send_signal(signal.SIGINT)
        _, said = child.communicate(timeout=PATIENCE_S)
        self.assertEqual(child.returncode, 130, said)
        self.assertRegex(said, r"stopped; [1-9] of \d points are kept; repeat the command to continue")
        self.assertNotIn("Traceback", said)
        child = begin(out, *only)
        wait_for_points(child, out, len(points_in(out)) + 1)
        child.send_signal(signal.SIGKILL)
        child.communicate()
        kept = points_in(out)
        self.assertLess(len(kept), count, "it was killed too late")
        self.assertFalse((out / "results.csv").exists())
        status, _, said = run(out, *only)
        self.assertEqual(status, 0, said)
        self.assertIn(f"{len(kept)} of {count} points are finished already", said)
        after = points_in(out)
        self.assertEqual(len(after), count)
        self.assertEqual({name: after[name] for name in kept}, kept, "finished points were run again")
        whole = [r for r in error_columns(self.whole) if r["kind"] == "error" and r["size"] == "32"]
        mine = error_columns(out)
        self.assertEqual(mine, [{k: r[k] for k in mine[0]} for r in whole])

    def test_reports_missing_files_and_continues(self):
        sweep = json.loads((HERE / "quick.json").read_text())
        sweep["scenes"]["castle"] = "../shared/scenes/castle.glb"
        path = OUT / "castle.json"
        path.write_text(json.dumps(sweep))
        status, told, said = run(OUT / "castle", "--list", sweep=path)
        self.assertEqual(status, 0, said)
        self.assertIn("scene 'castle' is left out: there is no ../shared/scenes/castle.glb", said)
        self.assertNotIn("castle", told)
        self.assertIn("box over plane", told)

    def test_reports_a_failed_point_and_ends_with_status_1(self):
        sweep = json.loads((HERE / "quick.json").read_text())
        sweep["modes"] = ["full", "hybrid,every=0"]
        path = OUT / "wrong.json"
        path.write_text(json.dumps(sweep))
        status, _, said = run(OUT / "wrong", "--only", "^mode.* none, 32 px", sweep=path)
        self.assertEqual(status, 1, said)
        self.assertIn("mode hybrid has no 'every=0'", said)
        self.assertTrue((OUT / "wrong" / "report.html").exists(), "the other points are reported")


# Scripts added to each page: FIRST records errors; LAST chooses every metric and size, hovers over all points that are
# drawn, and tells the page of FRAMES, which keeps what it is told.
FIRST = """<script>window.seen = [];
addEventListener('error', e => seen.push(String(e.message)));
console.error = (...words) => seen.push(words.join(' '));</script>"""
LAST = """<script>{
const visible = what => [...document.querySelectorAll(what)].filter(p => p.getBoundingClientRect().width > 0);
const hover = p => { p.dispatchEvent(new MouseEvent('mouseover', {clientX: 9, clientY: 9}));
  const tip = document.getElementById('told');
  const text = tip.style.display === 'block' ? tip.textContent : '';
  p.dispatchEvent(new MouseEvent('mouseout'));
  return tip.style.display === 'none' ? text : 'the tip stays'; };
const tips = {}, plots = [];
const press = button => { button.checked = true; button.dispatchEvent(new Event('change')); };
for (const metric of document.querySelectorAll('input[name=metric]'))
  for (const size of document.querySelectorAll('input[name=size]')) {
    press(metric);
    press(size);
    for (const point of visible('.point')) tips[point.id] = hover(point);
    plots.push(visible('svg').filter(s => s.getBoundingClientRect().height > 100).length);
  }
parent.postMessage({name: window.name, verdict: {errors: seen, tips, plots,
  pictures: [...document.images].map(i => i.complete && i.naturalWidth)}}, '*');
}</script>"""
FRAMES = """<!DOCTYPE html><style>iframe { position: absolute; width: 100%; height: 100%; }</style><body><script>
const told = {};
addEventListener('message', e => {
  told[e.data.name] = e.data.verdict;
  document.body.dataset.verdicts = JSON.stringify(told);
});</script>"""


def verdicts_on(pages, folder):
    """Opens all pages (by name) in one Chromium. Returns the errors and what was drawn, for each name."""
    browser = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    assert browser, "there is no chromium: scripts/setup installs it"
    frames = FRAMES
    for name, page in pages.items():
        watched = page.replace("<head>", "<head>" + FIRST, 1).replace("</body>", LAST + "</body>", 1)
        (folder / f"{name}.html").write_text(watched, encoding="utf-8")
        frames += f'<iframe name="{name}" src="{name}.html"></iframe>'
    path = folder / "frames.html"
    path.write_text(frames, encoding="utf-8")
    shown = subprocess.run(
        [browser, "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--enable-logging=stderr",
         "--virtual-time-budget=5000", f"--user-data-dir={folder / 'browser'}", "--dump-dom", path.as_uri()],
        capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    found = re.search(r'data-verdicts="([^"]*)"', shown.stdout)
    told = json.loads(html.unescape(found[1])) if found else {}
    verdicts = {name: told.get(name, {"errors": ["the page's scripts did not finish"]}) for name in pages}
    for line in shown.stderr.splitlines():
        if ":CONSOLE" in line:
            for name in pages:
                if f"/{name}.html" in line or "source: file:" not in line:
                    verdicts[name]["errors"].append(line)
    return verdicts


# Faults for the page: a text and its replacement.
FAULTS = {"throws": ("JSON.parse(", "JSON.parze("),
          "complains": ("const tip =", "console.error('so'); const tip ="),
          "no-plots": ("<svg", "<gsv"),
          "no-hover": ("'mouseover'", "'mouseoven'"),
          "no-choice": ("addEventListener('change'", "addEventListener('chance'"),
          "no-pictures": ("data:image/png;base64,",
                          "data:image/png;base64," + base64.b64encode(b"no").decode() + ",")}


class Page(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.page = (OUT / "whole" / "report.html").read_text(encoding="utf-8")
        folder = OUT / "page"
        folder.mkdir(exist_ok=True)
        broken = {name: cls.page.replace(*change) for name, change in FAULTS.items()}
        cls.verdicts = verdicts_on({"page": cls.page, **broken}, folder)

    def test_has_no_external_parts(self):
        fetched = re.findall(r'(?:src|href|url)\s*[=(]\s*["\']?(?!data:|#|xlink)([a-z]+:[^"\')\s>]*)', self.page)
        self.assertEqual(fetched, [])

    def test_opens_and_draws_without_an_error(self):
        verdict = self.verdicts["page"]
        self.assertEqual(verdict["errors"], [])
        self.assertEqual(verdict["plots"], [9] * 6, "three metrics at two sizes")
        told = json.loads(re.search(r'id="points">(.*?)</script>', self.page, re.S)[1])
        self.assertEqual(verdict["tips"], {f"point-{i}": text for i, text in enumerate(told)},
                         "each point is drawn, and its tip has its description")
        self.assertTrue(verdict["pictures"] and all(verdict["pictures"]))

    def test_has_a_header_and_every_table(self):
        for word in ("machine", "compiler", "device", "driver", "libraries", "commit", "command"):
            self.assertTrue(f"<dt>{word}<dd>" in self.page, word)
        for title in ("Modes that are faster and better than hybrid", "Where hybrid loses", "End-to-end latency",
                      "Scaling", "Ablations", "Noise", "Run times", "All figures", "The worst frame of each mode"):
            self.assertTrue(f"<h2>{title}</h2>" in self.page, title)

    def test_detects_broken_pages(self):
        for name, (there, _) in FAULTS.items():
            self.assertTrue(there in self.page, name)
        verdicts = self.verdicts
        self.assertNotEqual(verdicts["throws"]["errors"], [], "a script that throws")
        self.assertNotEqual(verdicts["complains"]["errors"], [])
        self.assertEqual(verdicts["no-plots"]["plots"], [0] * 6, "no plots")
        self.assertEqual(set(verdicts["no-hover"]["tips"].values()), {""}, "no hover")
        unchosen = verdicts["no-choice"]["tips"]
        self.assertLess(len(unchosen), self.page.count('class="point"'), "the buttons do nothing")
        self.assertFalse(any(verdicts["no-pictures"]["pictures"]), "no pictures")


if __name__ == "__main__":
    unittest.main()
