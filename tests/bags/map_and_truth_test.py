#!/usr/bin/env python3
"""Maps and true poses of a bag in `parloc run`. Usage: map_and_truth_test.py PROGRAM"""

import json
import math
import pathlib
import subprocess
import tempfile
import unittest

import numpy as np
from bag_case import MAP, PROGRAM, ROOT, START, WithDrive  # first: it ends the test where the writers are missing
from drive import stamp_ns_of


class MapAndTruth(WithDrive):
    """A bag may hold the map and the true poses, too."""

    def map_message(self, topic="/map"):
        image, facts = (ROOT / "maps/malaga_corridor.pgm").read_bytes(), {}
        for line in MAP.read_text().splitlines():
            key, _, value = line.partition(":")
            facts[key] = value.strip()
        head, size, _, pixels = image.split(b"\n", 3)
        self.assertEqual(head, b"P5")
        width, height = (int(word) for word in size.split())
        grey = np.frombuffer(pixels, dtype=np.uint8).reshape(height, width)
        cells = np.where(grey == 0, 100, np.where(grey >= 250, 0, -1))
        origin = [float(word) for word in facts["origin"].strip("[]").split(",")]
        stamp_ns = self.drive.scans[0].stamp_ns
        return self.make[2].occupancy_grid(stamp_ns, cells, float(facts["resolution"]), origin, topic)

    def truth(self):
        rows = [line.split() for line in (ROOT / "maps/logs/malaga_corridor.tum").read_text().splitlines() if line[0] != "#"]
        for row in rows:
            values = [float(word) for word in row]
            yield stamp_ns_of(row[0]), (values[1], values[2], 2 * math.atan2(values[6], values[7]))

    def localize_in(self, bag, *options):
        out = pathlib.Path(tempfile.mkdtemp(dir=self.work))
        command = [PROGRAM, "run", "--log", bag, "--out", out, "--threads", "1", "--json", *options]
        return subprocess.run(command, capture_output=True, text=True, timeout=120), out

    def test_a_bag_with_its_map(self):
        bag = self.bag([self.map_message(), *self.messages()])
        for options in ((), ("--map", bag), ("--map", MAP)):
            result, out = self.localize_in(bag, "--init", START, *options)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual((out / "trajectory.tum").read_bytes(), self.expected.trajectory)

    def test_several_maps_are_a_choice(self):
        bag = self.bag([self.map_message("/costmap"), self.map_message(), *self.messages()])
        result, _ = self.localize_in(bag, "--init", START)
        self.assertEqual(result.returncode, 3)
        self.assertIn("2 topics hold a map: /costmap, /map; choose with --map-topic", result.stderr)
        result, out = self.localize_in(bag, "--init", START, "--map-topic", "map")
        self.assertEqual((out / "trajectory.tum").read_bytes(), self.expected.trajectory, result.stderr)

    def test_no_map(self):
        result, _ = self.localize_in(self.bag(self.messages()), "--init", START)
        self.assertEqual(result.returncode, 3)
        self.assertIn("expected a map: a topic of nav_msgs/OccupancyGrid, found /tf_static", result.stderr)
        result, _ = self.localize_in(self.log, "--init", START)
        self.assertEqual(result.returncode, 2)
        self.assertIn("expected --map M.yaml", result.stderr)

    def expect_truth(self, bag, *options):
        result, _ = self.localize_in(bag, "--map", MAP, *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        rmse_m = json.loads(result.stdout)["position_rmse_m"]
        self.assertLess(rmse_m, 0.2)
        return rmse_m

    def test_true_poses_of_a_topic(self):
        poses = [self.make[2].pose_stamped(stamp_ns, pose) for stamp_ns, pose in self.truth()]
        bag = self.bag(self.messages() + poses)
        of_file = self.expect_truth(self.log, "--truth", ROOT / "maps/logs/malaga_corridor.tum")
        of_topic = self.expect_truth(bag, "--truth-topic", "/truth")
        self.assertAlmostEqual(of_file, of_topic, delta=1e-6)
        self.assertEqual(of_topic, self.expect_truth(bag, "--truth", bag))
        result, _ = self.localize_in(bag, "--map", MAP, "--truth-topic", "/trutj")
        self.assertIn("did you mean /truth?", result.stderr)

    def test_true_poses_of_a_frame(self):
        """/tf says where the odometry's frame is in the world, a little later than the odometry comes."""
        make, messages = self.make[2], self.messages()
        stamps, poses = zip(*self.truth(), strict=True)
        for scan in self.drive.scans:
            messages.append(make.planar_transform(scan.stamp_ns, "odom", "base_link", scan.odometry))
            nearest = min(range(len(stamps)), key=lambda k: abs(stamps[k] - scan.stamp_ns))
            messages.append(make.planar_transform(scan.stamp_ns, "world", "odom", over(poses[nearest], scan.odometry)))
        bag = self.bag(sorted(messages, key=lambda m: m.stamp_ns))
        self.expect_truth(bag, "--truth-frame", "world")
        result, _ = self.localize_in(bag, "--map", MAP, "--truth-frame", "mars")
        self.assertEqual(result.returncode, 3)
        self.assertIn(
            "no transform from it to the robot (base_link) in /tf (frames: base_link, laser, odom, world)", result.stderr
        )


def over(true_pose, odometry):
    """Where the odometry's frame is, so that the base is at the true pose."""
    turn = true_pose[2] - odometry[2]
    x = true_pose[0] - (math.cos(turn) * odometry[0] - math.sin(turn) * odometry[1])
    y = true_pose[1] - (math.sin(turn) * odometry[0] + math.cos(turn) * odometry[1])
    return x, y, turn


if __name__ == "__main__":
    unittest.main()
