#!/usr/bin/env python3
"""The node amcl against true ROS 2 processes on the loopback: what it says is what `parloc run` says of the same bag.
Usage: node_test.py PROGRAM, with ROS 2, parloc and parloc_ros on PYTHONPATH; exit code 77 where ROS 2 is missing."""

import json
import math
import random
import time

import node_case
import numpy
import robot
from std_srvs.srv import Empty, Trigger

import parloc


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


class PlaysABag(node_case.NodeCase):
    def played(self, speed):
        params = self.params(find_initial_pose=False)
        for _ in range(3):  # scans are sent with best effort: a busy machine may lose one
            node = self.run_node(params)
            self.play_all(speed)
            if len(self.world.poses) >= self.scans - 1:
                break
            node.end()
            self.world.poses.clear()
            self.world.transforms.clear()
        self.expect_as_run(params)
        self.assertGreaterEqual(len(self.world.poses), self.scans - 1, node.said())
        by_stamp = {stamp_s: pose for stamp_s, pose in self.world.poses}
        self.assertEqual(len(self.world.transforms), len(by_stamp))

    def test_at_real_time(self):
        self.played(1.0)

    def test_at_ten_times(self):
        self.played(10.0)


class Goes(node_case.NodeCase):
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
        self.assertEqual(self.world.play_in_step(self.messages[:-3]), [], node.said())
        before = len(self.world.poses)
        stamp_s = self.world.poses[-2][0]
        place = self.world.place_at(stamp_s)
        self.world.play(self.messages[:4], 20.0)  # up to the first scan, which tells
        self.assertTrue(self.world.wait_for(lambda: "set back" in node.said()), node.said())
        self.world.send_pose(*self.start)
        self.assertTrue(self.world.wait_for(lambda: "as was said" in node.said()), node.said())
        self.assertEqual(self.world.play_in_step(self.messages[4:]), [], node.said())
        self.assertTrue(self.answered(2 * before - 1), node.said())
        self.assert_near(self.world.place_at(stamp_s), place, 0.3)

    def assert_near(self, a, b, most_m):
        self.assertLess(math.hypot(a.x - b.x, a.y - b.y), most_m)

    def play_over_a_new_map(self, node, map_bytes):
        """Every scan is answered while the map is made ready, and after it has taken over."""
        third = len(self.messages) // 3
        self.assertEqual(self.world.play_in_step(self.messages[:third]), [], node.said())
        self.world.show_map(map_bytes)
        self.assertEqual(self.world.play_in_step(self.messages[third : 2 * third]), [], node.said())
        self.wait_for_map(node, 2)
        self.assertEqual(self.world.play_in_step(self.messages[2 * third :]), [], node.said())
        self.assertTrue(self.answered(self.scans - 1), node.said())

    def test_a_map_that_is_sent_again_changes_no_bit(self):
        params = self.params(find_initial_pose=False)
        self.play_over_a_new_map(self.run_node(params), self.map_bytes)
        self.expect_as_run(params)

    def test_a_larger_map_that_begins_elsewhere(self):
        params = self.params(find_initial_pose=False)
        node = self.run_node(params)
        grid, margin = parloc.read_map(self.map_path), 40
        origin = [c - margin * grid.resolution_m for c in (grid.origin.x_m, grid.origin.y_m)]
        larger = parloc.GridMap(numpy.pad(grid.cells, margin, constant_values=2), grid.resolution_m, (*origin, 0.0))
        self.play_over_a_new_map(node, parloc.map_message(larger))
        self.assertIn(f"on a map of {larger.width} x {larger.height}", node.said())
        self.expect_as_run(params, apart_m=0.3)

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
        params = self.params(find_initial_pose=False)
        node = self.run_node(params)
        half = len(self.messages) // 2
        self.world.play_in_step(self.messages[:half])
        self.assertTrue(self.world.set_parameter("max_particles", 800).successful)
        refused = self.world.set_parameter("max_particles", -5)
        self.assertFalse(refused.successful)
        self.assertIn("max_particles", refused.reason)
        self.assertFalse(self.world.set_parameter("scan_topic", 7).successful)
        self.wait_for_map(node, 2)
        self.assertEqual(self.world.play_in_step(self.messages[half:]), [], node.said())
        self.assertTrue(self.answered(self.scans - 1), node.said())
        self.expect_as_run(params, apart_m=0.3)

    def test_goes_down_and_comes_up(self):
        node = self.run_node(self.params())
        turn = robot.Transition
        for transition in (turn.TRANSITION_DEACTIVATE, turn.TRANSITION_CLEANUP):
            self.assertTrue(self.world.turn(transition))
        self.assertTrue(self.world.bring_up())
        self.assertEqual(self.world.state(), "active")
        self.wait_for_map(node, 2)
        self.play_all(20.0)
        self.assertTrue(self.answered(self.scans - 3), node.said())


class Maps(node_case.NodeCase):
    """The node slam."""

    def test_a_map_grows_and_is_saved(self):
        path = self.work / "made.yaml"
        values = {"scan_topic": ",".join(self.scan_topics), "base_frame_id": "base_link", "map_file": str(path)}
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
        path.unlink()
        node.end()
        self.assertTrue(path.is_file(), node.said())  # its end saves it, too


if __name__ == "__main__":
    node_case.main()
