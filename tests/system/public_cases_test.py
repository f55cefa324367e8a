#!/usr/bin/env python3
"""Inputs made after public reports, with their right values: where they are (PARLOC_CASES, else ../shared/cases), the
program is run on them as their README says. Usage: public_cases_test.py PROGRAM"""

import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
CASES = pathlib.Path(os.environ.get("PARLOC_CASES") or ROOT / "../shared/cases")
START = "1.2,1.0,-0.1316"
if not CASES.is_dir():
    print(f"skipped: {CASES} is not here (set PARLOC_CASES)")
    sys.exit(77)
PROGRAM = os.path.abspath(sys.argv.pop(1))


class Case(unittest.TestCase):
    def call(self, *arguments, code=0):
        result = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, timeout=300)
        self.assertEqual(result.returncode, code, result.stderr[-2000:])
        return result

    def run_case(self, folder, log, truth="truth.tum", start=START, command="run", config=None):
        """The metrics, and what was said on standard error."""
        at = CASES / folder
        with tempfile.TemporaryDirectory() as work:
            out = pathlib.Path(work) / "out"
            arguments = [command, "--log", at / log, "--truth", at / truth, "--out", out]
            if command == "run":
                arguments += ["--map", at / "map.yaml", "--init", start]
            if config:
                (pathlib.Path(work) / "c.yaml").write_text(config)
                arguments += ["--config", pathlib.Path(work) / "c.yaml"]
            result = self.call(*arguments)
            return json.loads((out / "metrics.json").read_text()), result.stdout + result.stderr


class Logs(Case):
    def test_angles_by_the_number_of_beams(self):
        for beams in (401, 541, 683):
            metrics, _ = self.run_case("flaser_angles", f"fl{beams}.log.gz")
            self.assertLess(metrics["position_rmse_m"], 0.01, beams)

    def test_parameters_of_the_laser(self):
        for log in ("with_params", "flipped"):
            metrics, _ = self.run_case("laser_params", f"{log}.log.gz")
            self.assertLess(metrics["position_rmse_m"], 0.01, log)

    def test_rounded_angle_step(self):
        metrics, _ = self.run_case("rounded_step", "d4_1081.log.gz")
        self.assertLess(math.degrees(metrics["heading_rmse_rad"]), 0.05)

    def test_a_converter_that_wrote_no_laser_pose_is_told(self):
        _, said = self.run_case("laser_pose_zero", "zero.log.gz")
        self.assertIn("lidars.robotlaser1.x, y and yaw", said)

    def test_a_trajectory_in_a_log(self):
        folder = CASES / "carmen_trajectory"
        self.call("evaluate", "--trajectory", folder / "t.log", "--relations", folder / "rel.txt")


class Drives(Case):
    def test_standing_ten_minutes(self):
        for name in ("g005", "g02"):
            metrics, _ = self.run_case("standstill", f"{name}.log.gz", f"{name}.tum")
            self.assertTrue(math.degrees(metrics["heading_max_rad"]) < 1.0 or metrics["health"]["end_state"] == "lost", name)
        metrics, _ = self.run_case("standstill", "run.log.gz")
        self.assertLess(metrics["position_max_m"], 0.05)

    def test_odometry_that_is_reset(self):
        metrics, said = self.run_case("odometry_reset", "run.log.gz", command="slam")
        self.assertLess(metrics["truth"]["position_rmse_m"], 0.03)
        self.assertIn("jump", said)
        metrics, _ = self.run_case("odometry_reset", "run.log.gz")
        self.assertEqual(metrics["health"]["end_state"], "tracking")

    def test_stamps_that_stand_still(self):
        metrics, said = self.run_case("stamps", "zero.log.gz", start="10.2,6.5,1.2")
        self.assertIn("stand still", said)
        self.assertEqual(metrics["health"]["end_state"], "tracking")
        metrics, _ = self.run_case("stamps", "dup.log.gz")
        self.assertLess(metrics["position_rmse_m"], 0.05)

    def test_fast_and_sparse_drives_do_not_jump(self):
        for folder in ("fast_car", "sparse_steps"):
            metrics, _ = self.run_case(folder, "run.log", "run.tum", start="1.5,1.244,0.0287")
            self.assertEqual(metrics["warnings"]["odometry_jumps"], 0, folder)

    def test_beams_that_saw_nothing_may_clear_their_way(self):
        free = []
        for config in ("", "slam: {clear_range: 3.0}\n"):
            with tempfile.TemporaryDirectory() as work:
                (pathlib.Path(work) / "c.yaml").write_text(config + "seed: 1\n")
                arguments = ["--log", CASES / "no_return/max.log.gz", "--out", work + "/out", "--config", work + "/c.yaml"]
                self.call("slam", *arguments, "--quiet")
                said = self.call("map", "info", work + "/out/map.yaml").stdout
                free += [int(line.split()[1]) for line in said.splitlines() if line.startswith("free")]
        self.assertGreater(free[1], 1.4 * free[0])


class Maps(Case):
    def test_yaml_files_that_nav2_loads(self):
        for path in sorted((CASES / "map_yaml").glob("*.yaml")):
            self.call("map", "info", path)

    def test_colours_are_averaged_before_rounding(self):
        said = self.call("map", "info", CASES / "map_colours/rgbmean.yaml").stdout
        unknown = [line for line in said.splitlines() if line.startswith("unknown")]
        self.assertEqual(unknown[0].split()[1], "0", said)

    def test_thresholds_that_leave_nothing_unknown_are_told(self):
        self.assertIn("nothing is unknown", self.call("map", "check", CASES / "free_thresh_025/map.yaml").stdout)


if __name__ == "__main__":
    unittest.main()
