"""Tests analysis.py, tables.py and scenes.standing with results known on paper."""
import json
import math
import random
import struct
import unittest

import scenes
import tables
from analysis import better_in_both, cost_at, exponent, grouped, pareto


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


class Standing(unittest.TestCase):
    def test_moves_only_the_camera(self):
        def parts(glb):
            magic, version, length, text, kind = struct.unpack_from("<4sIIII", glb)
            self.assertEqual((magic, version, length, kind), (b"glTF", 2, len(glb), 0x4E4F534A))
            self.assertEqual(text % 4, 0)
            return json.loads(glb[20:20 + text]), glb[20 + text:]
        before, bytes_before = parts(scenes.make("lights", 2))
        after, bytes_after = parts(scenes.standing(scenes.make("lights", 2), 1, 1.5, -2, 90))
        self.assertEqual(bytes_after, bytes_before)
        (camera,) = [n for n in after["nodes"] if "camera" in n]
        self.assertEqual(camera["translation"], [1, 1.5, -2])
        half = math.sqrt(0.5)  # to the left: -z becomes -x
        for actual, expected in zip(camera["rotation"], (0, half, 0, half)):
            self.assertAlmostEqual(actual, expected)
        others = [[n for n in d["nodes"] if "camera" not in n] for d in (before, after)]
        self.assertEqual(*others)

    def test_refuses_files_without_a_root_camera_and_files_that_are_no_glb(self):
        glb = scenes.make("lights", 1)
        for broken in (glb[:10], b"{}" + glb, glb.replace(b'"camera":', b'"camerb":')):
            with self.assertRaises(ValueError):
                scenes.standing(broken, 0, 0, 0, 0)


class Grouped(unittest.TestCase):
    def test_keeps_the_order_of_the_first_rows(self):
        rows = [{"k": "b", "v": 1}, {"k": "a", "v": 2}, {"k": "b", "v": 3}]
        self.assertEqual(list(grouped(rows, "k").items()), [(("b",), [rows[0], rows[2]]), (("a",), [rows[1]])])


def row(words, flip, more=None, network="near"):
    figures = dict.fromkeys(("mask_error", "client_ms", "server_ms", "both_ms", "bytes", "latency"))
    return {"part": "mode", "again": 0, "scene": "room", "trace": "walk", "network": network, "network_words": network,
            "size": 64, "words": words, "mode": words.split(",")[0], "flip": flip, **figures, **(more or {})}


class Tables(unittest.TestCase):
    def test_hybrid_loses_only_where_another_mode_is_better_in_cost_and_error(self):
        rows = [row("hybrid", 0.2, {"bytes": 100, "client_ms": 5}), row("remote,bitrate=1M", 0.3, {"bytes": 50}),
                row("delta,bitrate=1M", 0.1, {"bytes": 90, "client_ms": 6}), row("full", 0, {"bytes": 0, "client_ms": 1})]
        said = tables.where_hybrid_loses(rows)
        self.assertIn("In 1 of 2 comparisons", said)
        self.assertIn("delta,bitrate=1M", said)
        self.assertNotIn("remote", said)
        self.assertNotIn("full<td>", said)

    def test_state_that_hybrid_never_loses(self):
        said = tables.where_hybrid_loses([row("hybrid", 0.2, {"bytes": 1}), row("remote", 0.3, {"bytes": 50})])
        self.assertIn("In 0 of 1 comparisons", said)
        self.assertNotIn("<table>", said)

    def test_compare_costs_at_equal_error_and_state_where_there_is_none(self):
        curve = [("remote,bitrate=1M", 0.4, {"bytes": 1}), ("remote,bitrate=2M", 0.2, {"bytes": 100})]
        rows = [row("hybrid", 0.3, {"bytes": 20}), row("hybrid", 0.1, {"bytes": 20}, "far"),
                *(row(*point) for point in curve), *(row(*point, network="far") for point in curve)]
        said = tables.equal_error(rows, "remote", "bytes", "bytes")
        self.assertIn("the cost of hybrid is 2 to 2 times that of remote (median 2, 1 of 2 cases)", said)
        self.assertIn("never: at best FLIP 0.2", said)

    def test_show_modes_without_a_server_on_every_network(self):
        rows = [row("local", 0.1), row("hybrid", 0.2), row("hybrid", 0.3, network="far")]
        self.assertEqual([(r["words"], r["network"]) for r in tables.on_every_network(rows)],
                         [("local", "near"), ("local", "far"), ("hybrid", "near"), ("hybrid", "far")])

    def test_noise_is_the_difference_of_equal_settings(self):
        def timed(again, *client_ms):
            return row("hybrid", None, {"part": "timing", "again": again, "rounds": [
                {"client_frame": {"median": ms}} for ms in client_ms]})
        said = tables.noise([timed(0, 10, 11), timed(1, 11, 11), timed(0, 1, 1) | {"words": "full"}])
        self.assertIn('<td class="n">10.5<td class="n">11<td>9.1%<td>10.0%', said)

    def test_are_empty_without_rows(self):
        self.assertEqual(tables.all_of([], []), "")


if __name__ == "__main__":
    unittest.main()
