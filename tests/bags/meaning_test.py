#!/usr/bin/env python3
"""What topics, frames and times of a bag mean to `parloc run`, and the one line for what cannot be.
Usage: meaning_test.py PROGRAM"""

import math
import shutil
import sqlite3
import unittest

import numpy as np
from bag_case import WithDrive  # first: it ends the test where the writers are missing
from bag_writer import write_ros2
from drive import Drive, Scan


class Meaning(WithDrive):
    """What topics, frames and times mean."""

    def planar(self, scan, parent="odom", child="base_link"):
        return self.make[2].planar_transform(scan.stamp_ns, parent, child, scan.odometry)

    def of_scans(self, of_scan, first=()):
        messages = list(first)
        for scan in self.drive.scans:
            messages += of_scan(scan)
        return messages

    def test_odometry_from_transforms(self):
        make = self.make[2]
        start = self.drive.scans[0].stamp_ns
        first = [make.planar_transform(start, "map", "odom", (5.0, 6.0, 1.0)), make.mount(start, self.ahead)]
        of_scan = lambda scan: [self.planar(scan), make.scan(self.drive, scan)]  # noqa: E731
        self.expect_same_bytes(self.bag(self.of_scans(of_scan, first)))
        renamed = lambda scan: [self.planar(scan, "robot/odom"), make.scan(self.drive, scan)]  # noqa: E731
        bag = self.bag(self.of_scans(renamed, first))
        self.expect_refused(bag, "no transform from odom to the robot in /tf", "robot/odom", "--odom-frame")
        self.expect_same_bytes(bag, "--odom-frame", "robot/odom")

    def test_first_echo(self):
        make = self.make[2]
        of_scan = lambda scan: [make.odometry(scan.stamp_ns, scan.odometry), make.multi_echo_scan(self.drive, scan)]  # noqa: E731
        self.expect_same_bytes(self.bag(self.of_scans(of_scan, [make.mount(self.drive.scans[0].stamp_ns, self.ahead)])))

    def test_a_lidar_in_the_base_frame_needs_no_transform(self):
        make = self.make[2]
        of_scan = lambda scan: [  # noqa: E731
            make.odometry(scan.stamp_ns, scan.odometry),
            make.scan(self.drive, scan, frame="base_link"),
        ]
        found = self.localize(self.bag(self.of_scans(of_scan)))
        self.assertEqual(len(found.places()), len(self.drive.scans), found.error)

    def test_a_lidar_without_a_place_gets_one_by_a_setting(self):
        make = self.make[2]
        of_scan = lambda scan: [make.odometry(scan.stamp_ns, scan.odometry), make.scan(self.drive, scan)]  # noqa: E731
        bag = self.bag(self.of_scans(of_scan))
        self.expect_refused(bag, "no transform from base_link to laser", "lidars: scan: {x: 0, y: 0, yaw: 0}")
        config = self.work / "mount.yaml"
        config.write_text(f"lidars: {{scan: {{x: {self.drive.ahead_m}, y: 0, yaw: 0}}}}\n")
        self.expect_same_bytes(bag, "--config", config)

    def test_upside_down(self):
        """Rolled by half a turn, a LiDAR sees its beams in the other order."""
        make = self.make[2]
        n = len(self.drive.scans[0].ranges_m)
        mirrored = Drive(
            -(self.drive.angle_min_rad + self.drive.angle_step_rad * (n - 1)),
            self.drive.angle_step_rad,
            self.drive.range_max_m,
            self.drive.ahead_m,
            [Scan(s.stamp_ns, s.ranges_m[::-1].copy(), s.odometry) for s in self.drive.scans],
        )
        messages = [make.mount(self.drive.scans[0].stamp_ns, rotation=(1.0, 0.0, 0.0, 0.0), move=self.ahead)]
        for scan in mirrored.scans:
            messages += [make.odometry(scan.stamp_ns, scan.odometry), make.scan(mirrored, scan)]
        # Of 361 beams others are used: centimetres. Taken for upright, the walls would be on the other side.
        self.expect_near(self.bag(messages), 0.06)
        upright = self.localize(self.bag([self.make[2].mount(self.drive.scans[0].stamp_ns, self.ahead), *messages[1:]]))
        apart = np.linalg.norm((upright.places() - self.expected.places())[:, 1:3], axis=1)
        self.assertGreater(apart.max(), 0.3)

    def test_tilted_is_refused(self):
        half = math.radians(20) / 2
        rest = self.messages()[1:]
        mount = self.make[2].mount(self.drive.scans[0].stamp_ns, rotation=(0.0, math.sin(half), 0.0, math.cos(half)))
        self.expect_refused(self.bag([mount, *rest]), "laser is tilted by 20 degrees against base_link")

    def test_odometry_between_its_readings(self):
        """Readings lie between the scans: of the middle of two straight steps, so that the scans' own come out again."""
        make = self.make[2]
        scans = self.drive.scans
        messages = [make.mount(scans[0].stamp_ns, self.ahead), make.odometry(scans[0].stamp_ns, scans[0].odometry)]
        for before, scan in zip(scans, scans[1:], strict=False):
            between = [b + (s - b) * 0.5 for b, s in zip(before.odometry, scan.odometry, strict=True)]
            middle_ns = (before.stamp_ns + scan.stamp_ns) // 2
            messages += [make.odometry(middle_ns, between), make.odometry(scan.stamp_ns, scan.odometry)]
        messages += [make.scan(self.drive, scan) for scan in scans]
        self.expect_near(self.bag(messages), 0.05)

    def test_two_lidars(self):
        make = self.make[2]
        start = self.drive.scans[0].stamp_ns
        first = [
            make.mount(start, (0.1, 0.0, 0.0), child="front_laser"),
            make.mount(start, (-0.1, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), child="rear_laser"),
        ]
        of_scan = lambda scan: [  # noqa: E731
            make.odometry(scan.stamp_ns, scan.odometry),
            make.scan(self.drive, scan, "/front/scan", "front_laser"),
            make.scan(self.drive, scan, "/rear/scan", "rear_laser"),
        ]
        bag = self.bag(self.of_scans(of_scan, first))
        self.expect_refused(bag, "2 topics hold scans: /front/scan, /rear/scan; choose with --scan-topic")
        found = self.localize(bag, "--scan-topic", "/front/scan")
        self.assertEqual(len(found.places()), len(self.drive.scans))
        found = self.localize(bag, "--scan-topic", "/front/scan", "--scan-topic", "rear/scan")
        self.assertEqual(len(found.places()), 2 * len(self.drive.scans))

    def test_an_empty_topic_is_no_choice(self):
        messages = self.messages()
        path = self.work / "empty_topic.db3"
        write_ros2(self.work / "empty_topic", [self.make[2].scan(self.drive, self.drive.scans[0], "/other"), *messages])
        shutil.copy(next((self.work / "empty_topic").glob("*.db3")), path)
        with sqlite3.connect(path) as bag:
            bag.execute("DELETE FROM messages WHERE topic_id = (SELECT id FROM topics WHERE name = '/other')")
        self.expect_same_bytes(path)

    def test_a_cloud_of_points(self):
        make = self.make[2]
        n = len(self.drive.scans[0].ranges_m)
        angles = self.drive.angle_min_rad + self.drive.angle_step_rad * np.arange(n)
        messages = [make.mount(self.drive.scans[0].stamp_ns, (self.drive.ahead_m, 0.0, 0.5))]
        for scan in self.drive.scans:
            points = np.stack([np.cos(angles) * scan.ranges_m, np.sin(angles) * scan.ranges_m, np.zeros(n)], 1)
            floor = points * [0.3, 0.3, 0.0] - [0.0, 0.0, 0.5]
            cloud = make.cloud(scan.stamp_ns, np.concatenate([points, floor]).astype(np.float32))
            messages += [make.odometry(scan.stamp_ns, scan.odometry), cloud]
        bag = self.bag(messages)
        self.expect_refused(bag, "found only clouds of points: /points; --scan-topic makes scans of one")
        self.expect_near(bag, 0.3, "--scan-topic", "/points")


class Refusals(WithDrive):
    """One line that says what is missing and what to do."""

    def test_no_scans(self):
        messages = [m for m in self.messages() if m.topic != "/scan"]
        self.expect_refused(
            self.bag(messages), "expected a topic of sensor_msgs/LaserScan, found /tf_static", "/odom (nav_msgs/Odometry)"
        )

    def test_no_odometry(self):
        messages = [m for m in self.messages() if m.topic == "/scan"]
        self.expect_refused(self.bag(messages), "expected odometry", "slam.odometry: scans")

    def test_a_topic_that_is_not_there(self):
        bag = self.bag(self.messages())
        self.expect_refused(bag, "no such topic, did you mean /scan?", options=("--scan-topic", "/scam"))
        self.expect_refused(
            bag,
            "--odom-topic /scan: expected nav_msgs/Odometry, found sensor_msgs/LaserScan",
            options=("--odom-topic", "/scan"),
        )

    def test_two_odometries(self):
        more = [self.make[2].odometry(s.stamp_ns, s.odometry, "/ekf/odom") for s in self.drive.scans]
        bag = self.bag(self.messages() + more)
        self.expect_refused(bag, "2 topics hold odometry: /odom, /ekf/odom", "--odom-topic")
        self.expect_same_bytes(bag, "--odom-topic", "odom")

    def test_odometry_of_another_time(self):
        messages = self.messages()
        late = [self.make[2].odometry(s.stamp_ns + 10**12, s.odometry) for s in self.drive.scans]
        bag = self.bag([m for m in messages if m.topic != "/odom"] + late)
        self.expect_refused(bag, "no scan lies between two readings of the odometry")

    def test_encrypted(self):
        data = self.bag(self.messages()).read_bytes().replace(b"\x04\x00\x00\x00zstd", b"\x04\x00\x00\x00aes9")
        path = self.work / "encrypted.mcap"
        path.write_bytes(data)
        self.expect_refused(path, "aes9")


if __name__ == "__main__":
    unittest.main()
