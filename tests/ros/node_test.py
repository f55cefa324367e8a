#!/usr/bin/env python3
"""The node amcl against true ROS 2 processes on the loopback: what it says is what `parloc run` says of the same bag.
Usage: node_test.py PROGRAM, with ROS 2, parloc and parloc_ros on PYTHONPATH; exit code 77 where ROS 2 is missing."""

import csv
import json
import math
import random
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

try:
    import robot
except ImportError as error:
    print(f"no ROS 2 here: {error}")
    sys.exit(77)

from std_srvs.srv import Empty, Trigger

import parloc

ROOT, PROGRAM = robot.ROOT, sys.argv[-1]
NAME = "malaga_corridor"
MAP = ROOT / "maps" / f"{NAME}.yaml"


def start_of_truth():
    for line in (ROOT / "maps" / "logs" / f"{NAME}.tum").read_text().splitlines():
        if line and line[0] != "#":
            row = [float(word) for word in line.split()]
            return row[1], row[2], 2.0 * math.atan2(row[6], row[7])
    raise AssertionError("no truth")


def all_of_nav2(**other):
    """Every parameter of nav2 written out, so that the node and `parloc run` read the same."""
    values = {}
    for name, text, _ in parloc.nav2_parameters():
        try:
            values[name] = json.loads(text)
        except ValueError:
            values[name] = text
    x, y, yaw = start_of_truth()
    values.update(
        {"base_frame_id": "base_link", "update_min_d": 0.0, "update_min_a": 0.0, "set_initial_pose": True,
         "initial_pose.x": x, "initial_pose.y": y, "initial_pose.yaw": yaw, "resample_interval": 2}
    )  # fmt: skip
    values.update(other)
    return values


def program(*words):
    done = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True, timeout=120)
    if done.returncode != 0:
        raise AssertionError(done.stderr)


def damaged(data):
    """As faults of all kinds leave a message."""
    kind, out = random.randrange(4), bytearray(data)
    if kind == 0:
        del out[random.randrange(len(out)) :]
    elif kind == 1:
        for _ in range(8):
            out[random.randrange(len(out))] = random.randrange(256)
    elif kind == 2:
        begin = 4 + random.randrange(16)
        out[begin:] = b"\xff" * (len(out) - begin)  # NaN everywhere
    else:
        out += bytes(random.randrange(1, 100))
    return bytes(out)


class NodeCase(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.work = Path(cls.folder.name)
        cls.bag = cls.work / "drive.mcap"
        program("log", "convert", ROOT / "maps" / "logs" / f"{NAME}.log.gz", "--output", cls.bag)
        cls.messages = robot.messages_of(cls.bag)
        cls.scan_topic = next(topic for _, topic, kind, _ in cls.messages if kind == "sensor_msgs/msg/LaserScan")
        cls.scans = sum(topic == cls.scan_topic for _, topic, _, _ in cls.messages)
        cls.map_bytes = parloc.map_message(parloc.read_map(MAP))

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def setUp(self):
        self.world = robot.World()
        self.nodes = []

    def tearDown(self):
        for node in self.nodes:
            node.end()
        self.world.close()

    def params(self, **other):
        kept = str(self.work / f"{self.id()}.json")
        own = {"scan_topic": self.scan_topic, "pose_file": kept, "resume_pose": False}
        values = all_of_nav2(**{**own, **other})
        path = self.work / f"{self.id()}_{len(self.nodes)}.yaml"
        path.write_text(json.dumps({"amcl": {"ros__parameters": values}}))
        return path

    def run_node(self, params, map_bytes=None):
        node = robot.NodeProcess(params, self.work / f"{self.id()}_{len(self.nodes)}.log")
        self.nodes.append(node)
        self.assertTrue(self.world.bring_up(), node.said())
        self.world.show_map(map_bytes or self.map_bytes)
        self.world.meet(self.messages)
        # A map is made beside, and put in with the next message.
        fixed = [message for message in self.messages if message[1] == "/tf_static"][:1]
        self.assertTrue(self.world.wait_for(lambda: self.world.play(fixed, 1e3) and "on a map" in node.said()), node.said())
        return node

    def play_all(self, speed, extra=1):
        """Plays the bag; the last scans wait for odometry that never comes."""
        sent_s = self.world.play(self.messages, speed)
        self.world.wait_for(lambda: len(self.world.poses) >= self.scans - extra, 15.0)
        return sent_s

    def expect_as_run(self, params):
        out = self.work / f"{self.id()}_run"
        program("run", "--log", self.bag, "--map", MAP, "--config", params, "--out", out, "--quiet")
        with open(out / "poses.csv") as file:
            rows = {row["stamp_s"]: row for row in csv.DictReader(file)}
        for stamp_s, pose in self.world.poses:
            row = rows[f"{stamp_s:.6f}"]
            self.assertEqual((pose.position.x, pose.position.y), (float(row["x_m"]), float(row["y_m"])), stamp_s)
            yaw = 2.0 * math.atan2(pose.orientation.z, pose.orientation.w)
            self.assertAlmostEqual(yaw, float(row["theta_rad"]), delta=1e-15)
        return rows


class PlaysABag(NodeCase):
    def played(self, speed):
        params = self.params(find_initial_pose=False)
        node = self.run_node(params)
        self.play_all(speed)
        self.expect_as_run(params)
        self.assertGreaterEqual(len(self.world.poses), self.scans - 1, node.said())
        by_stamp = {stamp_s: pose for stamp_s, pose in self.world.poses}
        self.assertEqual(len(self.world.transforms), len(by_stamp))

    def test_at_real_time(self):
        self.played(1.0)

    def test_at_ten_times(self):
        self.played(10.0)


class Goes(NodeCase):
    """What a robot demands of a node."""

    def answered(self, count):
        return self.world.wait_for(lambda: len(self.world.poses) >= count, 10.0)

    def test_a_thousand_broken_messages(self):
        self.world.close()
        self.world = robot.World(hears_transforms=False)
        node = self.run_node(self.params())
        random.seed(5)
        faults = 0
        for _, topic, kind, data in self.messages:
            self.world.player(topic, kind).publish(data)
            for _ in range(14 if kind in robot.KINDS and topic != "/tf_static" else 0):
                self.world.player(topic, kind).publish(damaged(data))
                faults += 1
                time.sleep(0.002)
        for broken in (self.map_bytes[:40], damaged(self.map_bytes), b"\0\1\0\0" + b"\0" * 120):
            self.world.show_map(broken)
        self.assertGreater(faults, 1000)
        self.assertTrue(self.answered(self.scans // 2), node.said())
        time.sleep(1.0)
        self.assertIsNone(node.process.poll(), node.said())
        self.assertEqual(self.world.state(), "active")
        said = [line.split("] ")[-1] for line in node.said().splitlines() if "[WARN]" in line or "[ERROR]" in line]
        self.assertGreater(len(said), 0)
        self.assertLess(len(said), 100, said)

    def test_a_bag_that_begins_anew(self):
        node = self.run_node(self.params())
        self.play_all(20.0)
        before = len(self.world.poses)
        stamp_s = self.world.poses[-2][0]
        place = self.world.place_at(stamp_s)
        x, y, yaw = start_of_truth()
        self.world.play(self.messages[:3], 20.0)
        time.sleep(0.3)
        self.world.send_pose(x, y, yaw)
        time.sleep(0.3)
        self.play_all(20.0)
        self.assertTrue(self.answered(2 * before), node.said())
        self.assertIn("set back", node.said())
        self.assert_near(self.world.place_at(stamp_s), place, 0.3)

    def assert_near(self, a, b, most_m):
        self.assertLess(math.hypot(a.x - b.x, a.y - b.y), most_m)

    def test_a_map_that_changes(self):
        node = self.run_node(self.params())
        half = len(self.messages) // 2
        self.world.play(self.messages[:half], 20.0)
        self.world.show_map(self.map_bytes)
        time.sleep(1.0)
        self.world.play(self.messages[half:], 20.0)
        self.assertTrue(self.answered(self.scans - 3), node.said())

    def test_killed_and_started_again(self):
        params = self.params(resume_pose=True, save_pose_rate=10.0)
        node = self.run_node(params)
        self.play_all(20.0)
        time.sleep(0.5)
        last = self.world.poses[-1][1].position
        node.kill()
        again = self.run_node(params)
        self.world.wait_for(lambda: "where the node was last" in again.said(), 10.0)
        self.world.poses.clear()
        ahead = self.messages[-6:]
        self.world.play([m for m in self.messages if m[1] == "/tf_static"] + ahead, 5.0)
        self.assertTrue(self.answered(1), again.said())
        self.assert_near(self.world.poses[0][1].position, last, 0.5)

    def test_services(self):
        node = self.run_node(self.params(update_min_d=0.5, update_min_a=0.5))
        self.play_all(20.0, extra=self.scans)
        self.world.call(Empty, "request_nomotion_update", Empty.Request())
        self.world.call(Empty, "reinitialize_global_localization", Empty.Request())
        self.assertIn("whole map", node.said())

    def test_parameters_change_while_it_runs(self):
        node = self.run_node(self.params())
        half = len(self.messages) // 2
        self.world.play(self.messages[:half], 20.0)
        self.assertTrue(self.world.set_parameter("max_particles", 800).successful)
        refused = self.world.set_parameter("max_particles", -5)
        self.assertFalse(refused.successful)
        self.assertIn("max_particles", refused.reason)
        self.assertFalse(self.world.set_parameter("scan_topic", 7).successful)
        time.sleep(1.0)
        self.world.play(self.messages[half:], 20.0)
        self.assertTrue(self.answered(self.scans - 3), node.said())

    def test_goes_down_and_comes_up(self):
        self.run_node(self.params())
        turn = robot.Transition
        for transition in (turn.TRANSITION_DEACTIVATE, turn.TRANSITION_CLEANUP):
            self.assertTrue(self.world.turn(transition))
        self.assertTrue(self.world.bring_up())
        self.assertEqual(self.world.state(), "active")
        self.play_all(20.0)
        self.assertTrue(self.answered(self.scans - 3))


class Maps(NodeCase):
    """The node slam."""

    def test_a_map_grows_and_is_saved(self):
        path = self.work / "made.yaml"
        values = {"scan_topic": self.scan_topic, "base_frame_id": "base_link", "map_file": str(path)}
        params = self.work / "slam.yaml"
        params.write_text(json.dumps({"slam": {"ros__parameters": {**values, "map_update_interval": 0.0}}}))
        self.world.hear_maps()
        node = robot.NodeProcess(params, self.work / "slam.log", "slam")
        self.nodes.append(node)
        self.assertTrue(self.world.bring_up("slam"), node.said())
        self.world.meet(self.messages)
        self.world.play(self.messages, 5.0)
        self.assertTrue(self.world.wait_for(lambda: len(self.world.maps) > 3), node.said())
        self.assertGreater(self.world.maps[-1].info.width, self.world.maps[0].info.width)
        answer = self.world.call(Trigger, "save_map", Trigger.Request())
        self.assertTrue(answer.success, answer.message)
        self.assertGreater(parloc.read_map(path).width, 100)


if __name__ == "__main__":
    robot.begin()
    unittest.main(argv=sys.argv[:-1], verbosity=2)
