#!/usr/bin/env python3
"""tools/studies/mrpt_files.py, read back with the reader of MRPT's recordings, so that it knows MRPT's form and not only ours;
grids.py and logs.py; and what compare_mrpt.py refuses. Needs no MRPT."""

import math
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools/studies"))
import grids
import logs
import mrpt_files as mrpt
import mrpt_objects
import mrpt_setup
import runs
from measuring import Failure

DATASETS = pathlib.Path("/usr/share/mrpt/datasets")


def read_gridmap(s, version):
    assert version == 3 and s.take("B") == 8
    width, height, *limits_m = s.take("II4f")
    resolution_m = s.take("f")
    cells = s.take(f"{width * height}b")
    s.take("fBffBHf")
    method, sigma_m, z_hit, z_random, range_max_m, field_every, cap_m = s.take("i4fIf")
    s.take("B")
    s.take("fIf")
    _, ray_every, ray_sigma_m = s.take("Bif")
    s.take("if")
    s.take_list("f")
    s.take("BB")
    return {"width": width, "height": height, "limits_m": limits_m, "resolution_m": resolution_m, "cells": cells,
            "method": method, "sigma_m": sigma_m, "z_hit": z_hit, "z_random": z_random, "range_max_m": range_max_m,
            "field_every": field_every, "cap_m": cap_m, "ray_every": ray_every, "ray_sigma_m": ray_sigma_m}


mrpt_objects.READERS["COccupancyGridMap2D"] = read_gridmap


class TestCase(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def assert_near(self, found, given, places):
        self.assertEqual(len(found), len(given))
        for a, b in zip(found, given, strict=True):
            self.assertAlmostEqual(a, b, places)


def scan_at(stamp_s, pose, ranges_m=(0.0, 1.5, 8.0, math.nan, math.inf, 2.25)):
    return logs.Scan(stamp_s, list(ranges_m), -0.5, 0.25, 8.0, (0.1, -0.02, 0.3), pose)


class Rawlog(TestCase):
    def setUp(self):
        super().setUp()
        self.scans = [scan_at(5.0, (1.0, 2.0, 3.0)), scan_at(5.1, (1.1, 2.2, -3.1)), scan_at(5.2, (0.9, 2.4, -2.9))]
        self.motion = mrpt.Motion(0.1, 0.02, 0.07, 0.11, 1e-4, 2e-4)

    def objects(self, misses_count):
        objects = list(mrpt_objects.Stream(mrpt.rawlog(self.scans, self.motion, misses_count, 10.0)).objects())
        self.assertEqual(len(objects), 6)
        return [a[0] for a in objects[::2]], [s[0] for s in objects[1::2]]

    def test_versions(self):
        data = mrpt.rawlog(self.scans, self.motion, True, 10.0)
        for name, version in (("CActionCollection", 0), ("CActionRobotMovement2D", 6), ("CPose2D", 1), ("CPose3D", 2),
                              ("CSensoryFrame", 2), ("CObservation2DRangeScan", 6)):
            self.assertEqual(data.count(bytes([0x80 | len(name)]) + name.encode() + bytes([version])), 3, name)

    def test_increments_lead_from_pose_to_pose(self):
        actions, _ = self.objects(True)
        x, y, heading = self.scans[0].T_odom_base
        for action, scan in zip(actions, self.scans, strict=True):
            dx, dy, turn = action.delta
            x, y = x + math.cos(heading) * dx - math.sin(heading) * dy, y + math.sin(heading) * dx + math.cos(heading) * dy
            heading += turn
            self.assertAlmostEqual(x, scan.T_odom_base[0], 12)
            self.assertAlmostEqual(y, scan.T_odom_base[1], 12)
            self.assertAlmostEqual(math.cos(heading - scan.T_odom_base[2]), 1, 12)
            self.assertLess(abs(turn), 1)  # the short way through pi
            self.assertEqual(action.model, 0)
            self.assert_near(action.gaussian, (0.1, 0.02, 0.07, 0.11, 1e-4, 2e-4), 7)  # float32

    def test_scan(self):
        _, scans = self.objects(True)
        scan = scans[1]
        self.assertAlmostEqual(scan.aperture_rad, 1.25, 6)
        self.assertEqual((scan.to_left, scan.range_max_m), (1, 10.0))
        x, y, z, yaw = scan.pose
        self.assertEqual((x, y, z), (0.1, -0.02, 0.0))
        # The first beam: MRPT's lies half the aperture to the right of the sensor's axis.
        self.assertAlmostEqual(yaw - scan.aperture_rad / 2, 0.3 - 0.5, 6)
        self.assertEqual(scan.ranges_m, (0.0, 1.5, 8.0, 0.0, 8.0, 2.25))
        self.assertEqual(scan.valid, (0, 1, 1, 0, 1, 1))

    def test_misses_left_out(self):
        self.assertEqual(self.objects(False)[1][0].valid, (0, 1, 0, 0, 0, 1))

    def test_stamps(self):
        actions, scans = self.objects(True)
        self.assertEqual([s.ticks for s in scans], [a.ticks for a in actions])
        self.assertEqual(scans[1].ticks - scans[0].ticks, 1_000_000)  # 0.1 s in 100 ns
        truth = [line.split() for line in mrpt.ground_truth(self.scans, [(1, 2, 3)] * 3).splitlines()]
        self.assertEqual(len(truth), 2 + 3)
        for row, scan in zip(truth[2:], scans, strict=True):
            self.assertEqual(mrpt.ticks(float(row[0])), scan.ticks)
        for row in truth[:2]:  # or else MRPT takes the first column for indices
            self.assertNotEqual(float(row[0]) % 1, 0)

    def test_reader_knows_recordings_of_mrpt(self):
        path = DATASETS / "localization_demo.rawlog"
        if not path.exists():
            self.skipTest(f"{path}: not there (apt-get install mrpt-common)")
        reader = mrpt_objects.Stream(path.read_bytes())
        self.assertEqual(len(reader.read()[0].delta), 3)
        self.assertEqual(len(reader.read()[0].ranges_m), 361)
        reader = mrpt_objects.Stream((DATASETS / "uwb_ro-localization_demo_map.gridmap.gz").read_bytes())
        self.assertEqual(reader.read()["width"], 700)
        self.assertEqual(reader.position, len(reader.data))


class Maps(TestCase):
    def write(self, pixels=b"P5\n# a comment\n3 2\n255\n" + bytes([0, 254, 205, 254, 254, 0]), **changes):
        settings = {"image": "m.pgm", "resolution": "0.05", "origin": "[-1.0, 2.0, 0.0]", **changes}
        (self.folder / "m.yaml").write_text("".join(f"{k}: {v}  # x\n" for k, v in settings.items() if v is not None))
        (self.folder / "m.pgm").write_bytes(pixels)
        return self.folder / "m.yaml"

    def test_lowest_row_first(self):
        grid = grids.read_map(self.write())
        free, occupied, unknown = grids.FREE, grids.OCCUPIED, grids.UNKNOWN
        self.assertEqual(list(grid.cells), [free, free, occupied, occupied, free, unknown])
        self.assertEqual((grid.width, grid.height, grid.origin_m), (3, 2, (-1.0, 2.0)))

    def test_margin_moves_nothing(self):
        grid = grids.read_map(self.write())
        wide = mrpt.with_margin(grid)
        self.assertEqual(wide.width % 16, 0)
        self.assertEqual(len(wide.cells), wide.width * wide.height)
        for row in range(grid.height):
            for column in range(grid.width):
                x = round((grid.origin_m[0] - wide.origin_m[0]) / 0.05) + column
                y = round((grid.origin_m[1] - wide.origin_m[1]) / 0.05) + row
                self.assertEqual(wide.cells[y * wide.width + x], grid.cells[row * grid.width + column])
        self.assertEqual(wide.cells.count(grids.UNKNOWN), len(wide.cells) - 5)

    def test_what_parloc_gets_is_what_mrpt_gets(self):
        wide = mrpt.with_margin(grids.read_map(self.write()))
        grids.write_map(self.folder / "w.yaml", wide, decimals=9)
        again = grids.read_map(self.folder / "w.yaml")
        self.assertEqual(again.cells, wide.cells)
        self.assertEqual((again.width, again.height), (wide.width, wide.height))
        self.assert_near(again.origin_m, wide.origin_m, 8)
        likelihood = mrpt.Likelihood(mrpt.LIKELIHOOD_FIELD, 0.1, 3.5, 0.1, 8.0, 2.0)
        found = mrpt_objects.Stream(mrpt.gridmap(wide, likelihood)).read()
        self.assertEqual((found["width"], found["height"]), (wide.width, wide.height))
        odds = {grids.FREE: 127, grids.OCCUPIED: -127, grids.UNKNOWN: 0}
        self.assertEqual(found["cells"], tuple(odds[c] for c in wide.cells))
        x0, x1, y0, y1 = found["limits_m"]
        self.assert_near((x0, y0), wide.origin_m, 6)
        self.assert_near(((x1 - x0) / 0.05, (y1 - y0) / 0.05), (wide.width, wide.height), 4)
        self.assertEqual((found["method"], found["field_every"], found["ray_every"]), (4, 1, 1))
        keys = ("sigma_m", "ray_sigma_m", "z_hit", "z_random", "range_max_m", "cap_m")
        self.assert_near([found[key] for key in keys], (0.1, 0.1, 3.5, 0.1, 8, 2), 6)

    def test_broken_maps(self):
        for name, path in (("image", lambda: self.write(pixels=b"P5\n3 2\n255\n12345")),
                           ("P2", lambda: self.write(pixels=b"P2\n3 2\n255\n")),
                           *((key, lambda key=key, value=value: self.write(**{key: value})) for key, value in (
                               ("image", "none.pgm"), ("origin", None), ("resolution", "x"), ("resolution", "0"),
                               ("origin", "[0, 0, 0.1]"), ("origin", "[0.02, 0, 0]"), ("mode", "raw"))),
                           ("file", lambda: self.folder / "none.yaml")):
            with self.subTest(name), self.assertRaisesRegex(Failure, r"\.(yaml|pgm): expected [^\n]+$"):
                grids.read_map(path())


class Logs(TestCase):
    def setUp(self):
        super().setUp()
        self.path = self.folder / "log"
        self.lines = [logs.carmen_text(scan_at(0.1 * i, (0.5 * i, 1.0, 0.2 * i), (0.0, 1.5, 8.0, 2.25))) for i in range(12)]

    def read(self, lines, limit=100):
        self.path.write_text("".join(lines))
        return logs.read_log(self.path, limit)

    def test_round_trip(self):
        scans = self.read(["# a comment\n", "ODOM 0 0 0 0 0 0 0 host 0\n", *self.lines], limit=11)
        self.assertEqual(len(scans), 11)
        self.assertEqual(scans[3].ranges_m, [0.0, 1.5, 8.0, 2.25])
        self.assert_near((*scans[3].T_base_sensor, *scans[3].T_odom_base, scans[3].stamp_s, scans[3].angle_step_rad),
                         (0.1, -0.02, 0.3, 1.5, 1.0, 0.6, 0.3, 0.25), 8)  # 9 decimals in the text

    def test_thinned(self):
        scan = mrpt.thinned(scan_at(0, (0, 0, 0), range(1, 7)), 3)
        self.assertEqual(scan.ranges_m, [1, 3, 5])
        self.assertEqual((scan.angle_min_rad, scan.angle_step_rad), (-0.5, 0.5))
        self.assertEqual(len(mrpt.thinned(scan_at(0, (0, 0, 0)), 6).ranges_m), 6)
        self.assertEqual(len(mrpt.thinned(scan_at(0, (0, 0, 0)), 4).ranges_m), 3)  # never more than asked for

    def test_broken_logs(self):
        broken = self.lines[5].rsplit(" ", 8)[0] + "\n"
        fewer = logs.carmen_text(scan_at(0, (0, 0, 0), (1.0, 2.0)))
        for name, lines, where in (("cut off", [*self.lines[:5], broken], "log:6: "),
                                   ("beams", [*self.lines, fewer], "log:13: "),
                                   ("FLASER", ["FLASER 2 1 2 0 0 0 0 0 0 0 h 0\n"], "log:1: "),
                                   ("few", self.lines[:9], "log: ")):
            with self.subTest(name), self.assertRaisesRegex(Failure, where + r"expected [^\n]+$"):
                self.read(lines)
        self.path.write_bytes(b"\x1f\x8b garbage")
        with self.assertRaisesRegex(Failure, "log: expected a CARMEN log"):
            logs.read_log(self.path, 100)


class Comparison(unittest.TestCase):
    def test_beam_model_is_that_of_mrpt(self):
        shares = mrpt_setup.mixture(8.0)
        self.assertAlmostEqual(sum(shares.values()), 1, 12)
        peak = shares["z_hit"] / (0.1 * math.sqrt(2 * math.pi))
        # MRPT: 0.9 exp(..) + 0.1 / 10; parloc: density of a hit + z_rand / 8; and the same ratio for misses.
        self.assertAlmostEqual(peak / (shares["z_rand"] / 8), 0.9 / 0.01, 9)
        self.assertAlmostEqual(shares["z_hit"] / shares["z_max"], 0.9 / 0.01, 9)

    def test_scenario_has_the_beams(self):
        text = runs.scenario_with(mrpt_setup.PAPER_SCENARIO, mrpt_setup.lidar_of(200))
        self.assertRegex(text, r"(?m)^  beams: 200\b")
        step = float(text.split("angle_step_deg:")[1].split()[0])
        self.assertAlmostEqual(step * 199, 270, 6)
        for key in ("map", "localization_map", "path"):
            name = text.split(f"\n{key}: ")[1].split()[0]
            self.assertTrue(pathlib.Path(name).is_absolute() and pathlib.Path(name).exists(), name)

    def refused(self, *arguments):
        done = subprocess.run([sys.executable, "-B", ROOT / "tools/studies/compare_mrpt.py", *arguments], capture_output=True,
                              text=True)
        self.assertEqual(done.returncode, 2, done.stderr)
        return done.stderr

    def test_says_what_is_missing(self):
        self.assertEqual(self.refused("--pf-localization", "no-such-program"),
                         "compare_mrpt.py: no-such-program: not found, it is a program of MRPT: apt-get install mrpt-apps\n")
        self.assertIn("belong together", self.refused("--log", "x"))


if __name__ == "__main__":
    unittest.main()
