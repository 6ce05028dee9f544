"""Tests the Python modules of the study with results known on paper."""
import contextlib
import io
import json
import math
import random
import re
import tempfile
import unittest
import warnings
from pathlib import Path

import compare
import plots
import results
import rivals
import rows
import scenes
import tables
from analysis import better_in_both, cost_at, exponent, grouped, less_in_both, pareto
from sweep import Sweep, arguments


class Pareto(unittest.TestCase):
    def test_is_the_lower_left_border(self):
        points = [(3, 1), (1, 5), (2, 5), (2, 2), (4, 1), (5, 0.5)]
        self.assertEqual(pareto(points), [1, 3, 0, 5])

    def test_of_no_points_is_empty_and_of_one_point_is_that_point(self):
        self.assertEqual(pareto([]), [])
        self.assertEqual(pareto([(0, 0)]), [0])

    def test_contains_both_of_two_equal_points(self):
        self.assertEqual(pareto([(1, 1), (1, 1), (2, 2)]), [0, 1])

    def test_agrees_with_the_definition(self):
        seed = random.randrange(2 ** 32)
        chance = random.Random(seed)
        points = [(chance.randrange(12), chance.randrange(12)) for _ in range(200)]
        undominated = [i for i, p in enumerate(points)
                       if not any(q[0] <= p[0] and q[1] <= p[1] and q != p for q in points)]
        self.assertEqual(sorted(pareto(points)), undominated, f"seed {seed}")


class Exponent(unittest.TestCase):
    def test_of_a_power_function_is_its_power_without_spread(self):
        fit = exponent([1, 2, 4, 8], [3 * x ** 1.5 for x in (1, 2, 4, 8)])
        self.assertAlmostEqual(fit["exponent"], 1.5)
        self.assertAlmostEqual(fit["factor"], 3)
        self.assertAlmostEqual(fit["interval"], 0)
        self.assertAlmostEqual(fit["spread"], 1)

    def test_has_the_textbook_interval(self):
        # log2 y = 0, 2, 1 over log2 x = 0, 1, 2: the slope is 1/2, the residuals are -1/2, 1, -1/2. So s^2 = 3/2, and
        # the standard error of the slope is sqrt(3/2 / 2). t of one degree of freedom is 12.706.
        fit = exponent([1, 2, 4], [1, 4, 2])
        self.assertAlmostEqual(fit["exponent"], 0.5)
        self.assertAlmostEqual(fit["interval"], 12.706 * math.sqrt(0.75))
        self.assertAlmostEqual(fit["spread"], 2)

    def test_of_two_points_has_no_interval(self):
        fit = exponent([1, 10], [1, 100])
        self.assertAlmostEqual(fit["exponent"], 2)
        self.assertIsNone(fit["interval"])

    def test_of_one_x_is_none(self):
        self.assertIsNone(exponent([2, 2], [1, 3]))
        self.assertIsNone(exponent([], []))


class CostAt(unittest.TestCase):
    CURVE = [(1, 0.4), (100, 0.2), (10_000, 0.1)]

    def test_at_a_point_of_the_curve_is_the_cost_of_the_point(self):
        for cost, error in self.CURVE:
            self.assertAlmostEqual(cost_at(self.CURVE, error)[0], cost)

    def test_halfway_between_two_points_is_their_geometric_mean(self):
        cost, how = cost_at(self.CURVE, 0.3)
        self.assertAlmostEqual(cost, 10)
        self.assertEqual(how, "between")
        self.assertAlmostEqual(cost_at(self.CURVE, 0.15)[0], 1000)

    def test_an_error_that_is_never_reached_has_no_cost(self):
        self.assertEqual(cost_at(self.CURVE, 0.05), (None, "never"))
        self.assertEqual(cost_at([], 0.5), (None, "never"))

    def test_an_error_that_the_cheapest_point_reaches_costs_at_most_that(self):
        self.assertEqual(cost_at(self.CURVE, 0.5), (1, "at most"))

    def test_points_behind_the_front_do_not_change_the_curve(self):
        self.assertAlmostEqual(cost_at([*self.CURVE, (50, 0.39), (200, 0.3)], 0.3)[0],
                               math.exp(math.log(50) + 9 / 19 * math.log(2)))

    def test_from_cost_0_on_the_curve_is_straight(self):
        self.assertAlmostEqual(cost_at([(0, 0.4), (8, 0.2)], 0.3)[0], 4)


class BetterInBoth(unittest.TestCase):
    OWN = {"name": "own", "cost": 5, "error": 5}

    def better(self, *others):
        rows = [self.OWN] + [{"name": str(i), "cost": c, "error": e} for i, (c, e) in enumerate(others)]
        return [r["name"] for r in better_in_both(rows, self.OWN, "cost", "error")]

    def test_needs_cost_and_error(self):
        self.assertEqual(self.better((4, 4), (6, 1), (1, 6), (4, 2)), ["3", "0"])

    def test_equal_in_one_and_better_in_the_other_is_better(self):
        self.assertEqual(self.better((5, 4), (5, 5), (4, 5)), ["0", "2"])

    def test_a_figure_that_was_not_measured_is_not_better(self):
        self.assertEqual(self.better((None, 1), (1, None)), [])
        self.assertEqual(better_in_both([{"cost": 1, "error": 1}], {"cost": None, "error": 5}, "cost", "error"), [])

    def test_less_in_both_means_less_in_each_of_them(self):
        others = [{"cost": c, "error": e} for c, e in ((4, 4), (5, 4), (4, 5), (4, 6), (1, 3), (None, 1), (1, None))]
        self.assertEqual(less_in_both([self.OWN, *others], self.OWN, "cost", "error"), [others[4], others[0]])


class Arguments(unittest.TestCase):
    def test_name_the_place_of_the_head_if_the_sweep_does(self):
        point = {"kind": "error", "size": 64, "frames": 8, "skip_s": 0, "network_words": "none", "modes": ["full"],
                 "every": 2}
        self.assertNotIn("--stand", arguments(point, "a.glb", "b.csv", "out"))
        given = arguments(point | {"stand": [-3.4, 1.4, -4, 180]}, "a.glb", "b.csv", "out")
        self.assertEqual(given[given.index("--stand") + 1], "-3.4,1.4,-4,180")


class Grouped(unittest.TestCase):
    def test_keeps_the_order_of_the_first_rows(self):
        rows = [{"k": "b", "v": 1}, {"k": "a", "v": 2}, {"k": "b", "v": 3}]
        self.assertEqual(list(grouped(rows, "k").items()), [(("b",), [rows[0], rows[2]]), (("a",), [rows[1]])])


def row(words, flip, more=None, network="near"):
    """A row of a mode. Without other figures in `more`, PSNR and SSIM follow from FLIP, so that all metrics agree."""
    figures = dict.fromkeys(("mask_error", "client_ms", "server_ms", "both_ms", "bytes", "latency", "answers",
                             "answer_ms"))
    losses = dict.fromkeys(("psnr_loss", "ssim_loss", "psnr", "ssim")) if flip is None else {
        "psnr_loss": 100 * flip, "ssim_loss": flip, "psnr": 99 - 100 * flip, "ssim": 1 - flip}
    return {"part": "mode", "kind": "error", "again": 0, "scene": "room", "trace": "walk", "network": network,
            "network_words": network, "size": 64, "words": words, "mode": words.split(",")[0], "flip": flip, **losses,
            **figures, **(more or {})}


class Rows(unittest.TestCase):
    def test_state_all_metrics_as_errors_that_are_0_for_equal_pictures(self):
        told = rows.with_short_names({"error.flip.median": 0.0, "error.psnr.median": 99.0, "error.ssim.median": 1.0})
        self.assertEqual([told[m.error] for m in rows.METRICS], [0, 0, 0])
        told = rows.with_short_names({"error.psnr.median": 30.0, "error.ssim.median": 0.75})
        self.assertEqual([told[m.error] for m in rows.METRICS], [None, 69, 0.25])

    def test_have_the_run_times_of_the_rounds_of_their_own_head_size_and_network(self):
        def timing(ms, **where):
            return row("hybrid", None,
                       {"part": "timing", "kind": "timing", "client_ms": ms, "answer_ms": 2 * ms} | where)
        own = row("hybrid", 0.1, {"client_ms": 7, "answer_ms": 8, "answers": 0.5})
        others = [timing(1, trace="run"), timing(2, size=32), timing(3, network="far"), timing(4, scene="hall"),
                  timing(5, again=1)]
        (told, *_) = rows.with_times([own, *others])
        self.assertEqual((told["client_ms"], told["server_ms"], told["both_ms"]), (7, 4, 11))
        (told, *_) = rows.with_times([own, *others, timing(10)])
        self.assertEqual((told["client_ms"], told["server_ms"], told["both_ms"]), (10, 10, 20))

    def test_of_modes_without_a_server_are_on_every_network_with_its_rounds(self):
        def timing(ms, network):
            return row("local", None, {"part": "timing", "kind": "timing", "client_ms": ms}, network)
        told = rows.on_every_network(rows.with_times([
            row("local", 0.1), row("hybrid", 0.2), row("hybrid", 0.3, network="far"), timing(5, "near"),
            timing(6, "far")]))
        self.assertEqual([(r["words"], r["network"], r["client_ms"]) for r in told],
                         [("local", "near", 5), ("local", "far", 6), ("hybrid", "near", None), ("hybrid", "far", None)])

    def test_are_the_same_when_they_are_read_back(self):
        def spread(value):
            return {"median": value, "p95": value, "p99": value, "count": 3}
        settings = {"kind": "error", "part": "mode", "scene": "a, b", "trace": "walk", "network": "none",
                    "network_words": "none", "size": 64, "frames": 12, "every": 4}
        figures = {"error": {"flip": spread(0.25), "psnr": spread(30.5), "ssim": spread(1)},
                   "wire": {"answers": spread(0.5)}, "time": {"client_frame": spread(4), "server_frame": spread(6.0)}}
        timing = settings | {"kind": "timing", "part": "timing"}
        written = rows.with_times([
            results.figures_row(settings, "hybrid,every=2", {}, figures),
            results.figures_row(timing, "hybrid,every=2", {}, {"time": {"client_frame": spread(9)}}),
            results.figures_row(settings, "full", {}, {"error": {"flip": spread(0)}})])
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "results.csv"
            path.write_text(results.as_csv(written), encoding="utf-8")
            read = rows.read_csv(path)
        keys = ("words", "mode", "scene", "size", "flip", "psnr_loss", "ssim_loss", "client_ms", "server_ms", "both_ms")
        self.assertEqual([[r.get(k) for k in keys] for r in read], [[r.get(k) for k in keys] for r in written])
        self.assertEqual((read[0]["client_ms"], read[0]["server_ms"]), (9, 3))

    def test_refuse_a_file_that_is_no_results_csv(self):
        with tempfile.NamedTemporaryFile("w", suffix=".csv") as file:
            file.write("kind,part\nerror,mode\n")
            file.flush()
            with self.assertRaisesRegex(ValueError, "has no column 'axis'"):
                rows.read_csv(file.name)


def disagreeing(words, flip, psnr_loss, ssim_loss, ms=1, **where):
    return row(words, flip, {"psnr_loss": psnr_loss, "ssim_loss": ssim_loss, "client_ms": ms, **where})


class Rivals(unittest.TestCase):
    ROWS = [disagreeing("hybrid", 0.2, 50, 0.2, 10), disagreeing("hybrid,every=2", 0.1, 40, 0.1, 5),
            disagreeing("remote", 0.1, 60, 0.3, 12), disagreeing("delta", 0.15, 60, 0.1, 9),
            disagreeing("local,maps=64", 0.3, 45, 0.3, 8), disagreeing("local,maps=128", 0.3, 44, 0.3, 9),
            disagreeing("local,maps=256", 0.3, 43, 0.3, 10), disagreeing("full", 0.1, 1, 0.3, 9.5)]

    def test_are_the_modes_with_less_client_time_and_less_error_than_hybrid(self):
        (cell,) = rivals.dominance(self.ROWS)
        self.assertEqual({m.label: [r["words"] for r in own] for m, own in cell["by"].items()},
                         {"FLIP": ["delta"], "PSNR": ["local,maps=128", "local,maps=64"], "SSIM": ["delta"]})
        self.assertEqual({m.label: len(own) for m, own in cell["full"].items()}, {"FLIP": 1, "PSNR": 1, "SSIM": 0})
        self.assertEqual(rivals.dominance_lines([cell]),
                         [["64", "room", "walk", "near", 10, "delta: 9 ms", "local,maps=128: 9 ms", "delta: 9 ms", 9.5]])

    def test_of_each_size_are_counted_without_and_with_full(self):
        far = [disagreeing("hybrid", 0.2, 50, 0.2, 10, network="far"), disagreeing("full", 0, 0, 0, 11, network="far"),
               disagreeing("delta", 0.3, 40, 0.2, 9, network="far")]
        quick = [disagreeing("hybrid", 0.2, 50, 0.2, 10, size=128), disagreeing("full", 0, 0, 0, 9, size=128)]
        cells = rivals.dominance([*self.ROWS, *far, *quick])
        end = "no other mode has both less client time and less error than hybrid; with full in"
        self.assertEqual(rivals.dominance_sentences(cells), [
            f"64 px, FLIP (this one counts): in 1 of 2 cells (50%) {end} 1 of 2 cells (50%).",
            f"64 px, PSNR: in 0 of 2 cells (0%) {end} 0 of 2 cells (0%).",
            f"64 px, SSIM: in 1 of 2 cells (50%) {end} 1 of 2 cells (50%).",
            *(f"128 px, {m}: in 1 of 1 cells (100%) {end} 0 of 1 cells (0%)."
              for m in ("FLIP (this one counts)", "PSNR", "SSIM"))])

    def test_do_not_count_cells_without_hybrid_or_without_another_mode(self):
        alone = [row("hybrid", 0.1, {"client_ms": 1}), row("hybrid,every=2", 0.1, {"client_ms": 1})]
        self.assertEqual(rivals.dominance([*alone, row("remote", 0.3), row("delta", None)]), [])
        self.assertEqual(len(rivals.dominance([*alone, row("remote", 0.3, {"client_ms": 2})])), 1)
        self.assertEqual(rivals.dominance([row("hybrid", None), row("local", 0.1, {"client_ms": 1})]), [])
        self.assertEqual(rivals.dominance([row("hybrid", 0.1)]), [], "no time")

    def test_rank_differently_where_two_metrics_order_two_modes_differently(self):
        agreeing = [disagreeing(words, e, e, e, network="far")
                    for words, e in (("remote", 1), ("hybrid", 2), ("delta", 3))]
        told = rivals.rank_differences([r for r in self.ROWS if r["mode"] in ("hybrid", "remote", "full")] + agreeing)
        self.assertEqual([(t["pair"], t["cells"], [t["first"][m] for m in rows.METRICS]) for t in told],
                         [(("hybrid", "remote"), 2, [0, 1, 1])], "the best hybrid equals remote by FLIP")
        self.assertEqual([r["network"] for r in told[0]["where"]], ["near"])
        self.assertEqual(rivals.rank_lines(told), [["64", "hybrid / remote", "2", "0", "1", "1", "room, walk: near"]])
        self.assertEqual(rivals.rank_differences(agreeing), [])

    def test_text_tables_have_columns_of_equal_width(self):
        self.assertEqual(rivals.as_text(["a", "long", "b"], [["xyz", 0.12345, "-"], ["", 7, "end"]]),
                         "a    long   b\nxyz  0.123  -\n     7      end")


def compared(before, after, *words):
    """Runs compare.py with two files of rows. Returns (exit status, what it printed)."""
    with tempfile.TemporaryDirectory() as folder:
        paths = [Path(folder) / name for name in ("before.csv", "after.csv")]
        for path, told in zip(paths, (before, after)):
            path.write_text(results.as_csv(told), encoding="utf-8")
        with contextlib.redirect_stdout(io.StringIO()) as printed, contextlib.redirect_stderr(printed):
            return compare.main([*map(str, paths), *words]), printed.getvalue()


def measured(words, psnr, mask_error, flip, client_ms, network="near"):
    figures = {"error.psnr": psnr, "error.mask_error": mask_error, "error.flip": flip, "time.client_frame": client_ms}
    return (dict.fromkeys(rows.SAID, "") | row(words, None, network=network)
            | {f"{k}.median": v for k, v in figures.items() if v is not None})


class Compare(unittest.TestCase):
    BEFORE = [measured("hybrid", 30, 1.0, 0.1, 100), measured("hybrid", 40, 2.0, 0.2, 100, "far"),
              measured("remote", 20, None, 0.3, 10), measured("local", 35, 1, 0.1, 50)]
    AFTER = [measured("hybrid", 29.5, 1.04, 0.2, 50), measured("hybrid", 38.9, 2.2, 0.1, 150, "far"),
             measured("remote", 21, None, 0.3, 10), measured("delta", 20, None, 0.3, 10)]

    def test_prints_the_worst_points_first(self):
        status, said = compared(self.BEFORE, self.AFTER)
        self.assertEqual(status, 0, "there is no limit")
        self.assertEqual(said.splitlines(), [
            "3 points are in both, 1 only before, 1 only after",
            "PSNR lost, dB: median 0.5, worst 1.1 of 3 points",
            "  1.1  64 px, room, walk, far, hybrid: 40 -> 38.9",
            "  0.5  64 px, room, walk, near, hybrid: 30 -> 29.5",
            "  -1  64 px, room, walk, near, remote: 20 -> 21",
            "mask error, after / before: median 1.07, worst 1.1 of 2 points",
            "  1.1  64 px, room, walk, far, hybrid: 2 -> 2.2",
            "  1.04  64 px, room, walk, near, hybrid: 1 -> 1.04",
            "FLIP, after / before: median 1, worst 2 of 3 points",
            "  2  64 px, room, walk, near, hybrid: 0.1 -> 0.2",
            "  1  64 px, room, walk, near, remote: 0.3 -> 0.3",
            "  0.5  64 px, room, walk, far, hybrid: 0.2 -> 0.1",
            "client time, after / before: median 1, worst 1.5 of 3 points",
            "  1.5  64 px, room, walk, far, hybrid: 100 -> 150",
            "  1  64 px, room, walk, near, remote: 10 -> 10",
            "  0.5  64 px, room, walk, near, hybrid: 100 -> 50"])

    def test_ends_with_status_1_if_a_limit_does_not_hold(self):
        for option, holds, fails in (("--psnr-loss", "1.11", "1"), ("--mask-error", "1.11", "1.05"),
                                     ("--flip", "2", "1.9"), ("--client-time", "1.5", "1.4")):
            status, said = compared(self.BEFORE, self.AFTER, option, holds)
            self.assertEqual((status, said.count(": holds")), (0, 1), said)
            status, said = compared(self.BEFORE, self.AFTER, option, fails)
            self.assertEqual((status, said.count("DOES NOT HOLD in 1")), (1, 1), said)

    def test_a_limit_of_a_figure_that_was_not_measured_does_not_hold(self):
        one = [measured("remote", 20, None, 0.3, 10)]
        status, said = compared(one, one, "--mask-error", "2")
        self.assertEqual(status, 1)
        self.assertIn("mask error, after / before: not measured in both; limit 2: DOES NOT HOLD", said)
        self.assertEqual(compared(one, one)[0], 0)

    def test_compares_two_settings_of_one_study(self):
        both = [measured("hybrid", 30, 1, 0.1, 10), measured("hybrid,every=2", 28, 1.5, 0.1, 10)]
        status, said = compared(both, both, "--words", "hybrid", "hybrid,every=2", "--psnr-loss", "1.5")
        self.assertEqual(status, 1)
        self.assertIn("1 points are in both, 0 only before, 0 only after", said)
        self.assertIn("  2  64 px, room, walk, near: 30 -> 28", said)
        self.assertIn("worst 1.5 of 1", said)

    def test_ratios_from_0_are_infinite_unless_nothing_changed(self):
        exact, wrong = [measured("full", 99, 0, 0, 10)], [measured("full", 50, 0.1, 0, 10)]
        self.assertIn("mask error, after / before: median 1, worst 1", compared(exact, exact)[1])
        self.assertEqual(compared(exact, wrong, "--mask-error", "1000")[0], 1)

    def test_says_what_it_cannot_compare(self):
        status, said = compared(self.BEFORE[:1], self.AFTER[2:])
        self.assertEqual((status, said), (2, "0 points are in both, 1 only before, 2 only after\n"))
        with contextlib.redirect_stderr(io.StringIO()) as said:
            self.assertEqual(compare.main(["/none.csv", "/none.csv"]), 2)
        self.assertIn("/none.csv", said.getvalue())


def sweep_of(**told):
    base = {"scenes": {"a": "a.glb", "b": {"file": "b.glb", "frames": 7}}, "traces": {"w": "w.csv", "v": "v.csv"},
            "networks": {"near": "none", "far": "delay=9ms"}, "sizes": [32], "frames": 12, "every": 4,
            "modes": ["hybrid", "full"]}
    with tempfile.TemporaryDirectory() as folder:
        for name in ("a.glb", "b.glb", "w.csv", "v.csv"):
            (Path(folder) / name).touch()
        path = Path(folder) / "sweep.json"
        path.write_text(json.dumps(base | told), encoding="utf-8")
        return Sweep(path, Path(folder), print)


class Sweeps(unittest.TestCase):
    def test_measure_every_size_with_its_own_values(self):
        points = sweep_of(sizes=[32, {"px": 64, "frames": 5, "modes": ["hybrid"]}]).points
        told = {(p["size"], p["scene"]): (p["frames"], p["every"]) for p in points}
        self.assertEqual(told, {(32, "a"): (12, 4), (32, "b"): (7, 4), (64, "a"): (5, 4), (64, "b"): (5, 4)})
        self.assertEqual({(p["size"], *p["modes"]) for p in points}, {(32, "hybrid"), (32, "full"), (64, "hybrid")})

    def test_time_every_head_on_every_network(self):
        points = sweep_of(sizes=[32, {"px": 64, "timing": {"frames": 2}}],
                          timing={"modes": ["hybrid", "full"], "rounds": 3, "seed": 1, "frames": 9}).points
        timed = [p for p in points if p["kind"] == "timing"]
        self.assertEqual(len({(p["size"], p["scene"], p["trace"], p["network"]) for p in timed}), 16)
        self.assertEqual(len(timed), 16)
        self.assertEqual({(p["size"], p["frames"], p["rounds"], *p["modes"]) for p in timed},
                         {(32, 9, 3, "hybrid", "full"), (64, 2, 3, "hybrid", "full")})

    def test_measure_other_settings_of_hybrid_in_every_case_or_in_those_listed(self):
        points = sweep_of(sizes=[32, 64], ablations=[
            {"modes": ["hybrid,every=2"]}, {"modes": ["hybrid"]},
            {"modes": ["hybrid,every=4"], "sizes": [64], "networks": ["far"], "traces": ["w"]}]).points
        own = [p for p in points if p["part"] == "ablation"]
        self.assertEqual(sum(p["modes"] == ["hybrid,every=2"] for p in own), 16)
        listed = [p for p in own if p["modes"] == ["hybrid,every=4"]]
        self.assertEqual([(p["size"], p["scene"], p["trace"], p["network"]) for p in listed],
                         [(64, "a", "w", "far"), (64, "b", "w", "far")])
        self.assertEqual(len(own), 18, "what is listed as a mode is no ablation")


class Plots(unittest.TestCase):
    def drawn(self, told, metric):
        points = plots.Points()
        return plots.error_against("p", told, "client_ms", "ms", "network", points, metric), points.told

    def test_show_full_for_every_metric_and_say_what_it_presumes(self):
        told = [row("hybrid", 0.2, {"client_ms": 5}), row("full", 0, {"client_ms": 7})]
        for metric in rows.METRICS:
            svg, points = self.drawn(told, metric)
            self.assertEqual([p.split("\n")[0] for p in points], ["hybrid", "full"])
            for text in ("full presumes a client", "full: dashed line at its cost", ">exact<"):
                self.assertIn(text, svg)
            lines = re.findall("stroke-dasharray[^>]*stroke: #000000; stroke-opacity: 0.5", svg)
            self.assertEqual(len(lines), 1, "at its cost")

    def test_draw_exact_pictures_below_all_others(self):
        told = [row("a", 0.02), row("b", 0.5), row("c", 0)]
        self.assertLess(plots.exact_at(told, "flip"), 0.02)
        self.assertGreater(plots.exact_at(told, "flip"), 0)
        self.assertEqual(plots.exact_at(told, "psnr_loss"), -2)

    def test_of_full_alone_have_a_layout(self):
        with warnings.catch_warnings():
            warnings.simplefilter("error", UserWarning)
            told = [row("full", 0, {"client_ms": 1}), row("full", 0, {"client_ms": 1}, "far")]
            self.assertIsNotNone(self.drawn(told, rows.FLIP)[0])

    def test_are_left_out_without_figures(self):
        self.assertIsNone(self.drawn([row("hybrid", 0.1)], rows.FLIP)[0])


class Tables(unittest.TestCase):
    def test_hybrid_loses_only_where_another_mode_is_better_in_cost_and_error(self):
        told = [row("hybrid", 0.2, {"bytes": 100, "client_ms": 5}), row("remote,bitrate=1M", 0.3, {"bytes": 50}),
                row("delta,bitrate=1M", 0.1, {"bytes": 90, "client_ms": 6}), row("full", 0, {"bytes": 0, "client_ms": 1})]
        said = tables.where_hybrid_loses(told)
        self.assertIn("In 3 of 6 comparisons", said, "three metrics; bytes and client time")
        self.assertIn("delta,bitrate=1M", said)
        self.assertNotIn("remote", said)
        self.assertNotIn("full<td>", said)

    def test_state_that_hybrid_never_loses(self):
        said = tables.where_hybrid_loses([row("hybrid", 0.2, {"bytes": 1}), row("remote", 0.3, {"bytes": 50})])
        self.assertIn("In 0 of 3 comparisons", said)
        self.assertNotIn("<table>", said)

    def test_compare_costs_at_equal_error_and_state_where_there_is_none(self):
        curve = [("remote,bitrate=1M", 0.4, {"bytes": 1}), ("remote,bitrate=2M", 0.2, {"bytes": 100})]
        told = [row("hybrid", 0.3, {"bytes": 20}), row("hybrid", 0.1, {"bytes": 20}, "far"),
                *(row(*point) for point in curve), *(row(*point, network="far") for point in curve)]
        said = tables.equal_error(told, "remote", "bytes", "bytes", rows.FLIP)
        self.assertIn("the cost of hybrid is 2 to 2 times that of remote (median 2, 1 of 2 cases)", said)
        self.assertIn("never: at best FLIP 0.2", said)
        said = tables.equal_error(told, "remote", "bytes", "bytes", rows.METRICS[1])
        self.assertIn("At equal PSNR, the cost of hybrid is 2 to 2", said)
        self.assertIn("never: at best PSNR, dB 79", said)

    def test_noise_is_the_difference_of_equal_settings(self):
        def timed(again, *client_ms):
            return row("hybrid", None, {"part": "timing", "again": again, "rounds": [
                {"client_frame": {"median": ms}} for ms in client_ms]})
        said = tables.noise([timed(0, 10, 11), timed(1, 11, 11), timed(0, 1, 1) | {"words": "full"}])
        self.assertIn('<td class="n">10.5<td class="n">11<td>9.1%<td>10.0%', said)

    def test_long_tables_are_closed_at_first(self):
        lines = [["x", 1]] * tables.LONG
        self.assertTrue(tables.table("many", ["a", "b"], lines).startswith("<table>"))
        self.assertTrue(tables.table("many", ["a", "b"], [*lines, ["x", 1]]).startswith("<details><summary>25 lines: many"))

    def test_are_empty_without_rows(self):
        self.assertEqual(tables.all_of([], []), "")


if __name__ == "__main__":
    unittest.main()
