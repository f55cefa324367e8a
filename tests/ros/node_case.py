"""What the tests of the nodes have in common: a bag, a node, and a world around it. Imported by scripts whose last argument is
the program parloc; ends them with exit code 77 where ROS 2 is missing."""

import csv
import json
import math
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

try:
    import robot
except ImportError as error:
    print(f"no ROS 2 here: {error}")
    sys.exit(77)

import parloc

ROOT, PROGRAM = robot.ROOT, sys.argv[-1]
NAME = "malaga_corridor"


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


class NodeCase(unittest.TestCase):
    """A shipped log as a bag; another one is recorded by whoever says so in record()."""

    map_path = ROOT / "maps" / f"{NAME}.yaml"

    @classmethod
    def record(cls):
        """Writes the bag; returns where the robot starts: x [m], y [m], heading [rad]."""
        program("log", "convert", ROOT / "maps" / "logs" / f"{NAME}.log.gz", "--output", cls.bag)
        return start_of_truth()

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.work = Path(cls.folder.name)
        cls.bag = cls.work / "drive.mcap"
        cls.start = cls.record()
        cls.messages = robot.messages_of(cls.bag)
        of_scans = [topic for _, topic, kind, _ in cls.messages if kind == "sensor_msgs/msg/LaserScan"]
        cls.scan_topics, cls.scans = sorted(set(of_scans)), len(of_scans)
        cls.map_bytes = parloc.map_message(parloc.read_map(cls.map_path))

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
        own = {"scan_topic": ",".join(self.scan_topics), "pose_file": kept, "resume_pose": False}
        own["max_scan_delay"] = 60.0  # messages are played at a pace of the test's own, on a machine that may be busy
        own.update(zip(("initial_pose.x", "initial_pose.y", "initial_pose.yaw"), self.start, strict=True))
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
        self.wait_for_map(node)
        return node

    def wait_for_map(self, node, count=1):
        """A map is made beside, and put in with the next message: until that has been done so often."""
        fixed = [message for message in self.messages if message[1] == "/tf_static"][:1]
        done = self.world.wait_for(lambda: self.world.play(fixed, 1e3) and node.said().count("on a map") >= count)
        self.assertTrue(done, node.said())

    def play_all(self, speed, extra=1):
        """Plays the bag; the last scans wait for odometry that never comes."""
        sent_s = self.world.play(self.messages, speed)
        self.world.wait_for(lambda: len(self.world.poses) >= self.scans - extra, 15.0)
        return sent_s

    def expect_as_run(self, params, apart_m=0.0):
        """What the node has said is what `parloc run` says of the bag: to the bit, or so far apart."""
        out = self.work / f"{self.id()}_run"
        topics = [word for topic in self.scan_topics for word in ("--scan-topic", topic)]
        program("run", "--log", self.bag, *topics, "--map", self.map_path, "--config", params, "--out", out, "--quiet")
        with open(out / "poses.csv") as file:
            rows = {row["stamp_s"]: row for row in csv.DictReader(file)}
        for stamp_s, pose in self.world.poses:
            row = rows[f"{stamp_s:.6f}"]
            x_m, y_m = float(row["x_m"]), float(row["y_m"])
            if apart_m > 0.0:
                self.assertLess(math.hypot(pose.position.x - x_m, pose.position.y - y_m), apart_m, stamp_s)
                continue
            self.assertEqual((pose.position.x, pose.position.y), (x_m, y_m), stamp_s)
            yaw = 2.0 * math.atan2(pose.orientation.z, pose.orientation.w)
            self.assertAlmostEqual(yaw, float(row["theta_rad"]), delta=1e-15)


def main():
    """As unittest has it, but for the last argument."""
    robot.begin()
    unittest.main("__main__", argv=sys.argv[:-1], verbosity=2)
