#!/usr/bin/env python3
"""The fit of tools/studies/calibrate_health.py on samples of a known curve, its scores by hand, and what it refuses."""

import contextlib
import io
import pathlib
import random
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools/studies"))
import calibrate_health as tool


def drawn(offset, slope, count, seed=1):
    """Outcomes of a known curve at log-odds from -1 to 2."""
    rng = random.Random(seed)
    logs = [rng.uniform(-1.0, 2.0) for _ in range(count)]
    return [(e, int(rng.random() < tool.sigmoid(offset + slope * e))) for e in logs]


class CalibrateHealth(unittest.TestCase):
    def test_finds_the_curve_that_outcomes_were_drawn_from(self):
        # 20,000 draws: standard errors about 0.04 and 0.08; four of them.
        offset, slope = tool.fit(drawn(-2.0, 4.0, 20000))
        self.assertAlmostEqual(offset, -2.0, delta=0.16)
        self.assertAlmostEqual(slope, 4.0, delta=0.32)

    def test_scores_by_hand(self):
        # sigmoid(0) = 0.5: said 0.5, 0.5, 0.25 of right, wrong, wrong.
        samples = [tool.Sample("a", right, 0.0, worth) for right, worth in ((1, 1.0), (0, 1.0), (0, 0.5))]
        result = tool.judge(samples, 0.0, 1.0)
        self.assertAlmostEqual(result["brier"], (0.25 + 0.25 + 0.0625) / 3)
        self.assertAlmostEqual(result["auc"], 0.75)  # one tie, one won
        self.assertEqual(result["bins"][5], (2, 0.5, 0.5))
        self.assertEqual(result["bins"][2], (1, 0.25, 0.0))
        self.assertAlmostEqual(result["error"], 0.25 / 3)  # of the bin of one; the other is right in the mean
        self.assertIsNone(tool.auc_of([(0.3, 1)]))

    def test_refuses_what_no_curve_fits(self):
        for points in ([(0.0, 1), (1.0, 1)], [(0.5, 0), (0.5, 1)], [(-1.0, 0), (-0.5, 0), (0.5, 1), (1.0, 1)]):
            with self.assertRaises(tool.Failure):
                tool.fit(points)

    def call(self, text, *more):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "samples.csv"
            path.write_text(text)
            out, err = io.StringIO(), io.StringIO()
            with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
                code = tool.main([str(path), *more])
            return code, out.getvalue(), err.getvalue()

    def rows(self, offset, slope, seed=1):
        """What a program with the constants 0 and 1 writes, of places worth 0.99."""
        return [(k % 7, right, e, 0.99 * tool.sigmoid(e)) for k, (e, right) in enumerate(drawn(offset, slope, 2000, seed))]

    def test_reads_files_and_prints_both(self):
        text = "seed,right,log_odds,probability\n" + "".join(",".join(map(str, row)) + "\n" for row in self.rows(-1.0, 3.0))
        code, out, err = self.call(text, "--offset", "0", "--slope", "1")
        self.assertEqual((code, err), (0, ""))
        self.assertIn("before  kOffset = 0.000, kSlope = 1.000", out)
        self.assertIn("trials that were left out", out)
        self.assertEqual(self.call("seed,right\n1,1\n")[0], 2)
        code, _, err = self.call("seed,right,log_odds,probability\n1,2,0.5,1\n")
        self.assertEqual(code, 2)
        self.assertIn("samples.csv:2", err)
        self.assertEqual(err.count("\n"), 1)
        self.assertEqual(self.call("seed,right,log_odds,probability\n1,1,0.5,0.1\n")[0], 3)

    def test_leaves_each_family_out_once(self):
        text = "family,run,seed,right,log_odds,probability\n"
        for k, family in enumerate(("clutter", "doors")):
            text += "".join(f"{family},loop," + ",".join(map(str, row)) + "\n" for row in self.rows(-1.0 - k, 3.0, k))
        text += "clutter,bare,1,0,7,nan\n"  # without the closed loop there is no probability
        code, out, err = self.call(text, "--offset", "0", "--slope", "1")
        self.assertEqual((code, err), (0, ""))
        rows = [line.split() for line in out.splitlines() if line.startswith(("clutter", "doors"))]
        left_out = {row[0]: float(row[1]) for row in rows}
        self.assertAlmostEqual(left_out["clutter"], -2.0, delta=0.6)  # the other's constants
        self.assertAlmostEqual(left_out["doors"], -1.0, delta=0.6)
        self.assertIn("fitted to 4000 of 4000 samples", out)

    def test_knows_the_constants_of_the_library(self):
        offset, slope = tool.constants_in_use()
        self.assertLess(abs(offset), 10)
        self.assertGreater(slope, 0)


if __name__ == "__main__":
    unittest.main()
