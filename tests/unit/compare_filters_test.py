#!/usr/bin/env python3
"""tools/compare_filters.py: which bars it calls kept, and the page that it writes of its results."""

import copy
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools"))
import compare_filters  # noqa: E402


def pair(mean):
    return {"mean": mean, "deviation": 0.001}


def row(name, position, heading, lost=0, particles=0):
    return {"filter": name, "kind": name.split("@")[0].split(":")[0], "runs": 20, "lost": lost, "particles": particles,
            "position_rmse_m": pair(position), "position_mae_m": pair(position), "position_max_m": pair(position),
            "heading_rmse_rad": pair(heading), "heading_mae_rad": pair(heading), "nees": pair(3.0),
            "kept_position_rmse_m": {"mean": None, "deviation": None} if lost == 20 else pair(position)}


PUBLISHED = {"rows": [{"filter": "ekf", "particles": 0, "position_rmse_m": 0.05, "heading_rmse_rad": 0.02},
                      {"filter": "edh", "particles": 100, "position_rmse_m": 0.04, "heading_rmse_rad": 0.02}]}


def result(*rows, unmapped=None):
    return {"plan": {"unmapped_hits": unmapped}, "published": PUBLISHED, "filters": list(rows)}


GOOD = {"house": {"1e-4": result(row("ekf:wide_field", 0.05, 0.02), row("edh@100", 0.019, 0.009, particles=100))}}


class Bars(unittest.TestCase):
    def test_published_figures_themselves_are_good_enough(self):
        self.assertTrue(all(holds for _, _, holds in compare_filters.judged(GOOD)))
        self.assertEqual(len(compare_filters.judged(GOOD)), 3)

    def test_a_worse_heading_misses(self):
        bad = copy.deepcopy(GOOD)
        bad["house"]["1e-4"]["filters"][0]["heading_rmse_rad"] = pair(0.0201)
        self.assertEqual([holds for _, _, holds in compare_filters.judged(bad)], [True, False, True])

    def test_the_best_must_not_be_lost(self):
        bad = copy.deepcopy(GOOD)
        bad["house"]["1e-4"]["filters"][1]["lost"] = 1
        self.assertEqual([holds for _, _, holds in compare_filters.judged(bad)], [True, True, False])

    def test_speed_is_that_of_the_median_step(self):
        times = {"filters": [{"filter": "edh@100", "step_median_ms": 0.041, "step_p99_ms": 1, "real_time_factor": 9000},
                             {"filter": "mcl", "step_median_ms": 0.2, "step_p99_ms": 1, "real_time_factor": 10}]}
        self.assertEqual([holds for _, _, holds in compare_filters.judged({"speed": {"times": times}})], [False, True])


class Page(unittest.TestCase):
    def test_says_where_each_filter_breaks(self):
        text = compare_filters.troubles_text({
            "none": result(row("ekf", 0.02, 0.01), row("mcl", 0.02, 0.01)),
            "1 m": result(row("ekf", 4.0, 1.0, lost=20), row("mcl", 0.02, 0.01, lost=3)),
            "clutter 5 %": result(row("ekf", 0.02, 0.01), row("mcl", 0.02, 0.01), unmapped=0.05)})
        self.assertIn("| ekf | 0 | 20 | 0 |", text)
        self.assertIn("| ekf | 1 m | nothing |", text)
        self.assertIn("| mcl | nothing | 1 m (3) |", text)
        self.assertIn("clutter 5 %: 5.0 %", text)

    def test_published_figures_stand_beside(self):
        text = compare_filters.house_text(GOOD["house"])
        self.assertIn("| edh@100 | 0 of 20 | 0.0190 +- 0.0010 |", text)
        self.assertIn("| 0.0400 / 0.0200 |", text)


if __name__ == "__main__":
    unittest.main()
