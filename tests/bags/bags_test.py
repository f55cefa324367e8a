#!/usr/bin/env python3
"""`parloc run` on bags that rosbags and mcap wrote: the same bytes as from the CARMEN log with the same numbers, whatever the
container; what topics and frames mean; and one line for what cannot be. Usage: bags_test.py PROGRAM"""

import json
import math
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

try:
    import numpy as np
    from bag_writer import (
        Messages,
        shuffled_rows,
        split_ros2,
        without_index,
        write_mcap,
        write_ros1,
        write_ros2,
    )
    from drive import Drive, Scan, carmen_text, read_drive, stamp_ns_of
    from mcap.writer import IndexType
except ImportError as missing:
    print(f"skipped: {missing} (pip install rosbags mcap lz4)")
    sys.exit(77)

ROOT = pathlib.Path(__file__).resolve().parents[2]
MAP = ROOT / "maps/malaga_corridor.yaml"
START = "3.452733,-10.171480,-0.485216"
PROGRAM = ""


class Localized:
    def __init__(self, result, folder):
        self.code, self.error = result.returncode, result.stderr
        path = folder / "trajectory.tum"
        self.trajectory = path.read_bytes() if path.exists() else b""

    def places(self):
        rows = [line.split() for line in self.trajectory.decode().splitlines() if not line.startswith("#")]
        return np.array([[float(word) for word in row[:3]] for row in rows])


class WithDrive(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.drive = read_drive(ROOT / "maps/logs/malaga_corridor.log.gz")
        cls.work = pathlib.Path(tempfile.mkdtemp(prefix="parloc_bags_"))
        cls.ahead = (cls.drive.ahead_m, 0.0, 0.0)
        cls.log = cls.work / "same.log"
        cls.log.write_text(carmen_text(cls.drive))
        cls.make = {1: Messages(1), 2: Messages(2)}
        cls.expected = cls.localize(cls.log)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.work)

    @classmethod
    def localize(cls, log, *options):
        out = pathlib.Path(tempfile.mkdtemp(dir=cls.work))
        command = [PROGRAM, "run", "--log", log, "--map", MAP, "--init", START, "--out", out, "--threads", "1", "--quiet"]
        result = subprocess.run([*command, *options], capture_output=True, text=True, timeout=120)
        return Localized(result, out)

    def messages(self, ros=2):
        return self.make[ros].of_drive(self.drive)

    def bag(self, messages, name="bag.mcap"):
        path = pathlib.Path(tempfile.mkdtemp(dir=self.work)) / name
        write_mcap(path, messages)
        return path

    def expect_same_bytes(self, log, *options):
        found = self.localize(log, *options)
        self.assertEqual(found.code, 0, found.error)
        self.assertEqual(found.error, "")
        self.assertGreater(len(found.trajectory), 1000)
        self.assertTrue(found.trajectory == self.expected.trajectory, f"{log}: another trajectory")

    def expect_near(self, log, most_m, *options):
        found = self.localize(log, *options)
        self.assertEqual(found.code, 0, found.error)
        apart = np.linalg.norm((found.places() - self.expected.places())[:, 1:3], axis=1)
        self.assertLess(apart.max(), most_m)

    def expect_refused(self, log, *parts, options=()):
        found = self.localize(log, *options)
        self.assertEqual(found.code, 3, found.error)
        self.assertEqual(found.error.count("\n"), 1, found.error)
        for part in parts:
            self.assertIn(part, found.error)


class Containers(WithDrive):
    """Every container gives the bytes of the CARMEN log, in one command without options."""

    def test_ros2_folders(self):
        for storage, mode in (
            ("sqlite3", None),
            ("sqlite3", "file"),
            ("sqlite3", "message"),
            ("mcap", None),
            ("mcap", "file"),
            ("mcap", "storage"),
        ):
            folder = self.work / f"{storage}_{mode}"
            write_ros2(folder, self.messages(), storage, mode)
            self.expect_same_bytes(folder)

    def test_ros2_single_files_and_without_metadata(self):
        folder = self.work / "lone"
        write_ros2(folder, self.messages())
        self.expect_same_bytes(next(folder.glob("*.db3")))
        (folder / "metadata.yaml").unlink()
        self.expect_same_bytes(folder)
        shuffled_rows(next(folder.glob("*.db3")))
        self.expect_same_bytes(folder)

    def test_ros2_split(self):
        split_ros2(self.work / "split", self.messages())
        self.expect_same_bytes(self.work / "split")
        (self.work / "split/metadata.yaml").unlink()
        self.expect_same_bytes(self.work / "split")

    def test_ros2_big_endian(self):
        write_ros2(self.work / "big_endian", self.messages(), little_endian=False)
        self.expect_same_bytes(self.work / "big_endian")

    def test_mcap(self):
        bare = {"index_types": IndexType.NONE, "use_statistics": False, "use_summary_offsets": False}
        variants = {
            "none": {"compression": "none", "chunk_size": 20000},
            "lz4": {"compression": "lz4", "chunk_size": 20000},
            "zstd": {"compression": "zstd", "chunk_size": 20000},
            "unchunked": {"use_chunking": False},
            "no_index": {"repeat_channels": False, "repeat_schemas": False, **bare},
            "no_checksums": {"enable_crcs": False},
        }
        for name, options in variants.items():
            write_mcap(self.work / f"{name}.mcap", self.messages(), **options)
            self.expect_same_bytes(self.work / f"{name}.mcap")
        write_mcap(self.work / "ros1.mcap", self.messages(1), ros=1)
        self.expect_same_bytes(self.work / "ros1.mcap")

    def test_mcap_out_of_order(self):
        messages = self.messages()
        write_mcap(self.work / "disordered.mcap", messages[1::2] + messages[::2], chunk_size=20000)
        self.expect_same_bytes(self.work / "disordered.mcap")

    def test_ros1(self):
        for compression in (None, "bz2", "lz4"):
            path = self.work / f"ros1_{compression}.bag"
            write_ros1(path, self.messages(1), compression)
            self.expect_same_bytes(path)
            without_index(path)
            self.expect_same_bytes(path)

    def test_the_name_says_nothing(self):
        write_ros1(self.work / "a.bag", self.messages(1))
        for name in ("a.log", "a.mcap", "a"):
            shutil.copy(self.work / "a.bag", self.work / name)
            self.expect_same_bytes(self.work / name)

    def test_cut_off_gives_the_beginning(self):
        write_mcap(self.work / "whole.mcap", self.messages(), "zstd", chunk_size=8000)
        data = (self.work / "whole.mcap").read_bytes()
        (self.work / "cut.mcap").write_bytes(data[: len(data) // 2])
        found = self.localize(self.work / "cut.mcap")
        self.assertEqual(found.code, 0, found.error)
        rows, expected = found.trajectory.splitlines(), self.expected.trajectory.splitlines()
        self.assertGreater(len(rows), 3)
        self.assertLess(len(rows), len(expected))
        self.assertEqual(rows, expected[: len(rows)])


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
        import sqlite3

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
    PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
