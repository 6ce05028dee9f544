"""Runs a sweep point by point and writes its report. A finished point is a file in OUT/points. Its name is a hash of
everything that the point depends on: settings, program, scene and recording. A finished point is not run again.
"""
import argparse
import hashlib
import json
import os
import platform
import re
import shlex
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

sys.dont_write_bytecode = True

import results  # noqa: E402
import rivals  # noqa: E402
import scenes  # noqa: E402
from rows import on_every_network  # noqa: E402
from sweep import Sweep, arguments, name_of, work_in  # noqa: E402


def say(text):
    print(f"study: {text}", file=sys.stderr, flush=True)


def clock(seconds):
    return f"{int(seconds) // 60}:{int(seconds) % 60:02d} min"


def hash_of_file(path, known={}):
    if path not in known:
        known[path] = hashlib.sha256(Path(path).read_bytes()).hexdigest()
    return known[path]


def write_whole(path, text):
    """Writes atomically: readers see the old file or the whole new one."""
    beside = path.with_name(path.name + ".tmp")
    beside.write_text(text, encoding="utf-8")
    os.replace(beside, path)


class Study:
    def __init__(self, sweep, root, program, out):
        self.sweep, self.root, self.program, self.out = sweep, root, program, out
        self.points, self.made = out / "points", out / "scenes"
        for folder in (self.points, self.made):
            folder.mkdir(parents=True, exist_ok=True)
        self.program_hash = hash_of_file(program)

    def scene_file(self, point):
        """The path of the point's scene. Makes scenes for scaling at first use."""
        if point["scene_file"].startswith("made:"):
            axis, count = point["scene_file"].removeprefix("made:").split("-")
            return self.made_scene(f"{axis}-{count}", lambda: scenes.make(axis, int(count)))
        return self.root / point["scene_file"]

    def made_scene(self, name, make):
        path = self.made / f"{name}.glb"
        if not path.exists():
            beside = path.with_suffix(".tmp")
            beside.write_bytes(make())
            os.replace(beside, path)
        return path

    def place_of(self, point):
        """The path of the point's result."""
        depends_on = {"settings": point, "program": self.program_hash, "scene": hash_of_file(self.scene_file(point)),
                      "trace": hash_of_file(self.root / point["trace_file"])}
        key = hashlib.sha256(json.dumps(depends_on, sort_keys=True).encode()).hexdigest()[:24]
        return self.points / f"{key}.json"

    def run(self, point, place):
        """Measures one point and writes its result. Returns the error message, or None."""
        pictures = place.with_suffix(".pictures.tmp")
        shutil.rmtree(pictures, ignore_errors=True)
        pictures.mkdir()
        begun = time.monotonic()
        child = subprocess.Popen(
            [self.program, *arguments(point, self.scene_file(point), self.root / point["trace_file"], pictures)],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        try:
            told, complaint = child.communicate()
        except BaseException:
            child.kill()
            child.wait()
            shutil.rmtree(pictures, ignore_errors=True)
            raise
        if child.returncode != 0:
            shutil.rmtree(pictures, ignore_errors=True)
            return complaint.strip() or f"ended with status {child.returncode}"
        kept = place.with_suffix(".pictures")
        shutil.rmtree(kept, ignore_errors=True)
        os.replace(pictures, kept)
        write_whole(place, json.dumps({"settings": point, "result": json.loads(told),
                                       "took_s": round(time.monotonic() - begun, 3)}, indent=1) + "\n")
        return None

    def run_all(self, points):
        """Returns (point, path) of all finished points, and the number of points that failed."""
        places = [(p, self.place_of(p)) for p in points]
        todo = [(p, where) for p, where in places if not where.exists()]
        if len(todo) < len(places):
            say(f"{len(places) - len(todo)} of {len(places)} points are finished already")
        begun, done, left, failed = time.monotonic(), 0.0, sum(work_in(p) for p, _ in todo), 0
        for i, (point, place) in enumerate(todo):
            spent = time.monotonic() - begun
            rest = f", about {clock(spent / done * left)} left" if done else ""
            say(f"{len(places) - len(todo) + i + 1} of {len(places)}, {clock(spent)}{rest}: {name_of(point)}")
            wrong = self.run(point, place)
            done, left = done + work_in(point), left - work_in(point)
            if wrong:
                failed += 1
                say(f"failed and is left out: {wrong.splitlines()[-1]}")
        return [(p, where) for p, where in places if where.exists()], failed


def libraries(program):
    """Versions of the main libraries, from the names of the files that the program is linked to."""
    linked = subprocess.run(["ldd", program], capture_output=True, text=True, check=False).stdout
    found = {}
    for name in ("embree3", "embree4", "tbb", "lz4", "sodium", "avcodec", "x264", "vulkan"):
        at = re.search(rf"=> (\S*/lib{name}\.so\S*)", linked)
        if at:
            found[name] = Path(at[1]).resolve().name.split(".so.")[-1]
    return found


def header(study, command):
    """Describes machine, versions and command of the measurement."""
    cpu = re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text(encoding="utf-8"))
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2 ** 30
    versions = json.loads(subprocess.run([study.program, "--versions"], capture_output=True, text=True,
                                         check=True).stdout)

    def git(*words):
        if shutil.which("git") is None:  # the sources may have come as an archive
            return ""
        return subprocess.run(["git", "-C", study.root, *words], capture_output=True, text=True,
                              check=False).stdout.strip()
    commit = git("rev-parse", "HEAD") or "unknown"
    if git("status", "--porcelain", "--untracked-files=no"):
        commit += ", changed"
    return {"machine": f"{cpu[1] if cpu else platform.machine()}, {os.cpu_count()} cores, {memory:.0f} GiB, "
                       f"{platform.system()} {platform.release()}",
            **versions, "libraries": ", ".join(f"{k} {v}" for k, v in libraries(study.program).items()),
            "commit": commit, "program": study.program_hash[:16], "command": command,
            "date": time.strftime("%Y-%m-%d", time.gmtime())}


def read_arguments():
    parser = argparse.ArgumentParser(prog="scripts/study", description=__doc__)
    parser.add_argument("sweep", type=Path, help="JSON file, see tests/study/sweep.py")
    parser.add_argument("--root", type=Path, required=True, help="root of the source tree")
    parser.add_argument("--program", type=Path, required=True, help="study_point")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--only", default="", help="regular expression: only the points of --list that it matches")
    parser.add_argument("--list", action="store_true", help="list the points and stop")
    parser.add_argument("--command", default=shlex.join(sys.argv), help="the command line that the report states")
    return parser.parse_args()


def main():
    given = read_arguments()
    sweep = Sweep(given.sweep, given.root, say)
    points = sweep.chosen(given.only)
    if given.list:
        print("\n".join(name_of(p) for p in points))
        return 0
    if not points:
        say("there is nothing to measure")
        return 2
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    study = Study(sweep, given.root, given.program.resolve(), given.out)
    try:
        there, failed = study.run_all(points)
        rows = results.write(given.out, header(study, given.command), there)
    except KeyboardInterrupt:
        kept = sum(study.place_of(p).exists() for p in points)
        say(f"stopped; {kept} of {len(points)} points are kept; repeat the command to continue")
        return 130
    for sentence in rivals.dominance_sentences(rivals.dominance(on_every_network(rows))):
        say(sentence)
    say(f"{given.out}/report.html, results.csv, results.json, plots/")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
