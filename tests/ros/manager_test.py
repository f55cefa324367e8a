#!/usr/bin/env python3
"""What nav2's lifecycle manager relies on, asked of the node amcl as the manager asks it: transitions one by one, each with the
state after it; a bond that forms after activation and beats within bond_timeout; what is refused;
a node that is respawned. Written after the manager's published source, with its defaults; its own program is not run.
Usage: manager_test.py PROGRAM, as node_test.py."""

import json
import signal
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

import numpy
from bond.msg import Status
from robot import Transition

import parloc

BOND_TIMEOUT_S = 4.0
CONFIGURE, CLEANUP = Transition.TRANSITION_CONFIGURE, Transition.TRANSITION_CLEANUP
ACTIVATE, DEACTIVATE = Transition.TRANSITION_ACTIVATE, Transition.TRANSITION_DEACTIVATE
SHUTDOWN = Transition.TRANSITION_UNCONFIGURED_SHUTDOWN
AFTER = {CONFIGURE: "inactive", ACTIVATE: "active", DEACTIVATE: "inactive", CLEANUP: "unconfigured", SHUTDOWN: "finalized"}


class Bond:
    """What is said on `bond` of the manager's namespace, from now on, for the node."""

    def __init__(self, world):
        self._world = world
        self.beats = []  # (when, message)
        self._subscription = world.create_subscription(Status, "bond", self._take, 100)

    def _take(self, message):
        if message.id == "amcl":
            self.beats.append((time.monotonic(), message))

    def forms(self):
        return self._world.wait_for(lambda: any(m.active for _, m in self.beats))

    def is_broken(self):
        return any(not message.active for _, message in self.beats)

    def longest_gap_s(self):
        times = [when for when, _ in self.beats] + [time.monotonic()]
        return max(b - a for a, b in zip(times, times[1:], strict=False))

    def instances(self):
        return {message.instance_id for _, message in self.beats}

    def close(self):
        self._world.destroy_subscription(self._subscription)


class ManagerCase(unittest.TestCase):
    namespace = None

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.world, self.nodes, self.bonds = robot.World(namespace=self.namespace), [], []

    def tearDown(self):
        for node in self.nodes:
            node.end()
        self.world.close()
        self.folder.cleanup()

    def run_node(self, *more, **values):
        path = Path(self.folder.name) / f"{len(self.nodes)}.yaml"
        kept = str(Path(self.folder.name) / "pose.json")
        path.write_text(json.dumps({"/**": {"ros__parameters": {"pose_file": kept, **values}}}))
        self.nodes.append(robot.NodeProcess(path, path.with_suffix(".log"), "amcl", *more))
        self.assertEqual(self.world.wait_for_state(), "unconfigured", self.nodes[-1].said())
        return self.nodes[-1]

    def change(self, *transitions):
        """Each as the manager does it: it asks, and believes the state."""
        for transition in transitions:
            self.assertTrue(self.world.turn(transition), f"{transition}: {self.nodes[-1].said()}")
            self.assertEqual(self.world.state(), AFTER[transition])

    def refused(self, *transitions):
        before = self.world.state()
        for transition in transitions:
            self.assertFalse(self.world.turn(transition), transition)
            self.assertEqual(self.world.state(), before)

    def activate(self):
        """The manager listens for a bond after activation alone."""
        self.change(ACTIVATE)
        bond = Bond(self.world)
        self.assertTrue(bond.forms(), self.nodes[-1].said())
        return bond

    def start_up(self):
        self.change(CONFIGURE)
        return self.activate()


class Manages(ManagerCase):
    def test_up_paused_up_and_down(self):
        self.run_node()
        first = self.start_up()
        self.assertEqual(first.beats[0][1].heartbeat_timeout, BOND_TIMEOUT_S)
        time.sleep(1.0)
        self.assertFalse(first.is_broken())
        self.change(DEACTIVATE)
        self.assertTrue(self.world.wait_for(first.is_broken))
        count = len(first.beats)
        time.sleep(0.5)
        self.assertEqual(len(first.beats), count)  # it is at rest
        first.close()
        second = self.activate()
        self.assertEqual(len(first.instances() | second.instances()), 2)  # a bond of its own
        self.change(DEACTIVATE, CLEANUP, SHUTDOWN)
        self.assertEqual(self.world.state(), "finalized")

    def test_what_cannot_be_is_refused(self):
        node = self.run_node()
        self.refused(DEACTIVATE, CLEANUP, ACTIVATE)  # a reset that is hard asks for the first two of whatever there is
        self.change(CONFIGURE)
        self.refused(DEACTIVATE, CONFIGURE)  # a shutdown while it is paused begins so
        self.change(CLEANUP)
        self.start_up()
        self.refused(CONFIGURE, ACTIVATE, CLEANUP)
        self.change(DEACTIVATE, CLEANUP)
        self.assertIsNone(node.process.poll(), node.said())

    def test_killed_and_respawned(self):
        node = self.run_node()
        bond = self.start_up()
        node.kill()
        count = len(bond.beats)
        time.sleep(1.0)
        self.assertLessEqual(len(bond.beats), count + 1)
        bond.close()
        self.run_node()
        again = self.start_up()
        self.assertFalse(again.instances() & bond.instances())

    def test_ended_by_a_signal_it_says_so(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            with self.subTest(number=number):
                node = self.run_node()
                bond = self.start_up()
                node.end(number)
                self.assertTrue(self.world.wait_for(bond.is_broken), node.said())
                self.assertEqual(node.process.returncode, 0, node.said())
                bond.close()

    def test_beats_while_a_large_map_is_made_ready(self):
        node = self.run_node(threads=1)
        bond = self.start_up()
        cells = numpy.zeros((1600, 1600), numpy.uint8)
        cells[::40, ::3] = 1
        beats = len(bond.beats)
        self.world.show_map(parloc.map_message(parloc.GridMap(cells, 0.05)))
        time.sleep(3.0)
        self.assertLess(bond.longest_gap_s(), BOND_TIMEOUT_S)
        self.assertGreater(len(bond.beats), beats)
        self.assertIsNone(node.process.poll(), node.said())

    def test_without_a_bond(self):
        self.run_node(bond_heartbeat_period=0.0)
        self.change(CONFIGURE, ACTIVATE)
        bond = Bond(self.world)
        time.sleep(1.0)
        self.assertEqual(bond.beats, [])

    def test_starts_itself_if_told_to(self):
        path = Path(self.folder.name) / "auto.yaml"
        path.write_text(json.dumps({"/**": {"ros__parameters": {"autostart_node": True, "resume_pose": False}}}))
        self.nodes.append(robot.NodeProcess(path, path.with_suffix(".log")))
        self.assertTrue(self.world.wait_for(lambda: self.world.wait_for_state() == "active"), self.nodes[-1].said())


class ManagesInANamespace(ManagerCase):
    namespace = "/robot1"

    def test_the_bond_is_in_the_namespace(self):
        self.run_node("-r", "__ns:=/robot1")
        self.start_up()
        self.change(DEACTIVATE, CLEANUP)


if __name__ == "__main__":
    robot.begin()
    unittest.main(argv=sys.argv[:-1], verbosity=2)
