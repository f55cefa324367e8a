#!/usr/bin/env python3
"""`parloc log info`: what it says of bags that are known, and that the command lines it prints do run.
Usage: info_test.py PROGRAM"""

import json
import math
import os
import shlex
import subprocess
import tempfile
import unittest

from bag_case import MAP, PROGRAM, WithDrive  # first: it ends the test where the writers are missing


class Info(WithDrive):
    def info(self, log, *options, code=0):
        result = subprocess.run([PROGRAM, "log", "info", log, *options], capture_output=True, text=True, timeout=60)
        self.assertEqual(result.returncode, code, result.stderr)
        return result

    def numbers(self, log, code=0):
        return json.loads(self.info(log, "--json", code=code).stdout)

    def printed_line(self, log, key):
        lines = [line for line in self.info(log, "--quiet").stdout.splitlines() if line.startswith(key)]
        self.assertEqual(len(lines), 1)
        return shlex.split(lines[0][len(key) :].strip())

    def run_line(self, words):
        self.assertEqual(words[0], "parloc")
        out = tempfile.mkdtemp(dir=self.work)
        words = [PROGRAM, *(str(MAP) if word == "MAP.yaml" else word for word in words[1:])]
        words[words.index("--out") + 1] = os.path.join(out, "out")
        result = subprocess.run([*words, "--quiet"], capture_output=True, text=True, timeout=120)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertTrue(os.path.exists(os.path.join(out, "out/trajectory.tum")))

    def test_numbers(self):
        found = self.numbers(self.bag(self.messages()))
        scans = len(self.drive.scans)
        self.assertEqual(found["format"], "mcap")
        self.assertEqual({t["name"]: t["count"] for t in found["topics"]}, {"/tf_static": 1, "/odom": scans, "/scan": scans})
        lidar = found["lidars"]["scan"]
        self.assertEqual(lidar["count"], scans)
        self.assertEqual(lidar["scans_of_beams"], {"361": scans})
        self.assertAlmostEqual(lidar["first_bearing_rad"], -math.pi / 2, delta=1e-6)
        self.assertAlmostEqual(lidar["mount"]["x_m"], self.drive.ahead_m, delta=1e-9)
        self.assertFalse(lidar["mount"]["upside_down"])
        self.assertEqual(sum(lidar["readings"].values()), 361 * scans)
        steps = [
            math.dist(a.odometry[:2], b.odometry[:2]) for a, b in zip(self.drive.scans, self.drive.scans[1:], strict=False)
        ]
        self.assertAlmostEqual(found["odometry"]["length_m"], sum(steps), delta=1e-9)
        self.assertEqual(found["notes"], [])
        self.assertEqual(self.numbers(self.log)["lidars"]["robotlaser1"]["count"], scans)

    def test_the_lines_it_prints_run(self):
        bag = self.bag(self.messages(), "a bag's name.mcap")
        for log in (bag, self.log):
            self.run_line(self.printed_line(log, "run it"))
            self.run_line(self.printed_line(log, "or map it"))

    def test_where_there_is_a_choice_it_says_which(self):
        make, messages = self.make[2], self.messages()
        for scan in self.drive.scans[:20]:
            messages.append(make.scan(self.drive, scan, "/filtered/scan"))
            messages.append(make.odometry(scan.stamp_ns, scan.odometry, "/ekf"))
        bag = self.bag(messages)
        text = self.info(bag, "--quiet").stdout
        self.assertIn("2 topics hold scans (/scan, /filtered/scan): /scan is the usual one", text)
        words = self.printed_line(bag, "run it")
        self.assertIn("--scan-topic", words)
        self.assertIn("--odom-topic", words)
        self.run_line(words)

    def test_what_cannot_run_is_listed_all_the_same(self):
        bag = self.bag([m for m in self.messages() if m.topic != "/tf_static"])
        result = self.info(bag, "--quiet", code=3)
        self.assertIn("/scan", result.stdout)
        self.assertIn("no transform from base_link to laser", result.stderr)
        self.assertIn("no transform", self.numbers(bag, code=3)["trouble"])

    def test_odd_times_and_ranges_are_told(self):
        make, drive = self.make[2], self.drive
        messages = [make.mount(drive.scans[0].stamp_ns, self.ahead)]
        for k, scan in enumerate(drive.scans):
            if 10 <= k < 25:
                continue
            ranges = scan.ranges_m.copy()
            ranges[:90] = 0.0
            messages.append(make.odometry(scan.stamp_ns, scan.odometry))
            messages.append(make.scan(drive, scan, ranges=ranges))
        found = self.numbers(self.bag(messages))["lidars"]["scan"]
        self.assertEqual(found["readings"]["zero"], 90 * found["count"])
        gap_s = (drive.scans[25].stamp_ns - drive.scans[9].stamp_ns) / 1e9
        self.assertAlmostEqual(found["longest_gap_s"], gap_s, delta=1e-6)


if __name__ == "__main__":
    unittest.main()
