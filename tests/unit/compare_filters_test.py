#!/usr/bin/env python3
"""tools/studies/compare_filters.py: which bars it calls kept, and the page that it writes of its results."""

import json
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools/studies"))
import compare_filters  # noqa: E402


def pair(mean):
    return {"mean": mean, "deviation": None if mean is None else 0.001}


def row(name, position, heading, lost=0, particles=0):
    if lost == 20:  # nothing to make a mean of
        position = heading = None
    return {"filter": name, "kind": name.split("@")[0].split(":")[0], "runs": 20, "lost": lost, "particles": particles,
            "position_rmse_m": pair(position), "position_mae_m": pair(position), "position_max_m": pair(position),
            "heading_rmse_rad": pair(heading), "heading_mae_rad": pair(heading), "nees": pair(3.0), "away": 0.015,
            "lost_s": pair(92.0 if lost else None)}


def published(name, kind, particles, position, heading, step_ms):
    return {"name": name, "filter": kind, "particles": particles, "position_rmse_m": position, "heading_rmse_rad": heading,
            "step_ms": step_ms}


PUBLISHED = {"rows": [published("EKF", "ekf", 0, 0.05, 0.02, 6.2), published("EDH, 100", "edh", 100, 0.04, 0.02, None)]}


def result(*rows, unmapped=None):
    return {"plan": {"unmapped_hits": unmapped, "first_seed": 21, "seeds": 20}, "published": PUBLISHED, "filters": list(rows)}


def house(ekf, edh):
    return {"house": {"1e-4": result(ekf, edh)}}


EKF, EDH = row("ekf", 0.05, 0.02), row("edh@100", 0.019, 0.009, particles=100)  # at the published figures, and under them


class Bars(unittest.TestCase):
    def test_which_bars_are_kept(self):
        # The means are of the runs that are left: good ones say nothing of a filter that lost the others.
        for name, ekf, edh, kept in (
                ("published figures themselves are good enough", EKF, EDH, [True, True, True]),
                ("a worse heading misses", row("ekf", 0.05, 0.0201), EDH, [True, False, True]),
                ("a lost run misses", EKF, {**EDH, "lost": 1}, [False, True, False]),
                ("a filter that lost all runs misses", EKF, row("edh@100", None, None, lost=20, particles=100),
                 [False, True, False])):
            with self.subTest(name):
                bars = compare_filters.judged(house(ekf, edh))
                self.assertEqual([holds for _, _, holds in bars], kept)
        self.assertEqual(bars[0][1], "20 lost, - m, - rad")

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
        text = compare_filters.house_text(house(EKF, EDH)["house"])
        self.assertIn("| edh@100 | 0 of 20 | 1.5 % | 0.0190 +- 0.0010 |", text)
        self.assertIn("| 0.0400 / 0.0200 |", text)
        self.assertIn("seeds 21 to 40", text)

    def test_lost_runs_are_counted_and_in_no_mean(self):
        text = compare_filters.followup_text(result(row("ekf", None, None, lost=20),
                                                    row("edh@100", 0.02, 0.01, lost=3, particles=100)))
        self.assertIn("| ekf | 20 of 20, after 92 s | 1.5 % | - | - | - |", text)
        self.assertIn("| edh@100 | 3 of 20, after 92 s | 1.5 % | 0.0200 +- 0.0010 |", text)
        self.assertIn("| EKF | 0.0500 | 0.0200 | 6.20 |", text)
        self.assertIn("| EDH, 100 | 0.0400 | 0.0200 | - |", text)

    def test_cost_of_many_particles(self):
        times = [{"filter": name, "step_median_ms": ms, "step_p99_ms": ms, "real_time_factor": 1}
                 for name, ms in (("edh@100000", 4.0), ("edh@1000000", 41.0))]
        self.assertIn("10.2 times as long", compare_filters.speed_text({"times": {"filters": times}}))

    def test_an_earlier_format_is_dropped(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "compare.json"
            new = compare_filters.earlier_parts(path)
            path.write_text(json.dumps({"house": {}}))
            self.assertEqual(compare_filters.earlier_parts(path), new)
            path.write_text(json.dumps({**new, "house": {}}))
            self.assertIn("house", compare_filters.earlier_parts(path))


if __name__ == "__main__":
    unittest.main()
