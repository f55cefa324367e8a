#!/usr/bin/env python3
"""The node amcl on a robot with two LiDARs: every scan of both is answered, as `parloc run` answers a bag of two topics; one
that stops, or that nobody has placed, is no matter to the other.
Usage: lidars_test.py PROGRAM, as node_test.py."""

import node_case
from node_case import ROOT, program

SCENARIO = """
map: {root}/maps/fine/hall_obstacles.yaml
localization_map: {root}/maps/hall_obstacles.yaml
path: {root}/maps/paths/hall_17m.yaml
seed: 1
scan_rate: 10
lidars:
  - {{beams: 271, angle_min_deg: -135.0, angle_step_deg: 1.0, range_min: 0.05, range_max: 20.0, sigma_range: 0.02,
     mount: [0.25, 0.15, 45.0]}}
  - {{beams: 181, angle_min_deg: -90.0, angle_step_deg: 1.0, range_min: 0.1, range_max: 10.0, sigma_range: 0.01,
     mount: [-0.25, -0.15, -135.0], upside_down: true, delay: 0.05}}
odometry: {{rate: 20, form: seed, alpha1: 0.1, alpha2: 0.05, alpha3: 0.1, alpha4: 0.02}}
"""
FRONT, REAR = "/robotlaser1", "/robotlaser2"


class TwoLidars(node_case.NodeCase):
    map_path = ROOT / "maps" / "hall_obstacles.yaml"

    @classmethod
    def record(cls):
        scenario, upside_down = cls.work / "scenario.yaml", cls.work / "lidars.yaml"
        scenario.write_text(SCENARIO.format(root=ROOT))
        upside_down.write_text("lidars: {robotlaser2: {upside_down: true}}")
        program("simulate", "--scenario", scenario, "--out", cls.work / "sim", "--quiet")
        program("log", "convert", cls.work / "sim" / "scans.log", "--config", upside_down, "--output", cls.bag)
        rows = (cls.work / "sim" / "truth.tum").read_text().splitlines()
        x, y = next(row for row in rows if row[0] != "#").split()[1:3]
        return float(x), float(y), 0.0

    def setUp(self):
        super().setUp()
        self.assertEqual(self.scan_topics, [FRONT, REAR])
        begin_s = self.messages[0][0]
        self.drive = [m for m in self.messages if m[1] == "/tf_static" or m[0] < begin_s + 12.0]

    def answers_to(self, topic):
        stamps = {round(stamp_s, 6) for stamp_s, of, _, _ in self.drive if of == topic}
        return [stamp_s for stamp_s, _ in self.world.poses if round(stamp_s, 6) in stamps]

    def expect_in_order(self):
        stamps = [stamp_s for stamp_s, _ in self.world.poses]
        self.assertEqual(stamps, sorted(stamps))

    def test_all_scans_of_both_are_answered_as_of_a_bag(self):
        params = self.params(find_initial_pose=False)
        node = self.run_node(params)
        self.assertEqual(self.world.play_in_step(self.drive), [], node.said())
        self.expect_in_order()
        self.assertGreater(len(self.answers_to(FRONT)), 110)
        self.assertGreater(len(self.answers_to(REAR)), 110)
        self.expect_as_run(params)

    def test_one_that_stops(self):
        node = self.run_node(self.params(find_initial_pose=False))
        half_s = self.drive[0][0] + 6.0
        self.drive = [m for m in self.drive if m[1] != REAR or m[0] < half_s]
        self.assertEqual(self.world.play_in_step(self.drive), [], node.said())
        self.expect_in_order()
        self.assertGreater(len(self.answers_to(FRONT)), 110)
        self.assertLess(len(self.answers_to(REAR)), 65)

    def test_one_that_nobody_has_placed(self):
        node = self.run_node(self.params(find_initial_pose=False))
        fixed = [m for m in self.drive if m[1] == "/tf_static"]
        placed = [m for m in fixed if b"robotlaser2" not in m[3]]
        self.assertEqual((len(fixed), len(placed)), (2, 1))
        moving = [m for m in self.drive if m[1] != "/tf_static"]
        self.assertEqual(self.world.play_in_step(placed + moving, unanswered=[REAR]), [], node.said())
        self.expect_in_order()
        self.assertGreater(len(self.answers_to(FRONT)), 110)
        self.assertEqual(self.answers_to(REAR), [])
        told = [line for line in node.said().splitlines() if "no transform from" in line]
        self.assertEqual(len(told), 1, node.said())


if __name__ == "__main__":
    node_case.main()
