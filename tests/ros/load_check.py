#!/usr/bin/env python3
"""How fast the node amcl answers: 1081 beams at 40 Hz and 2000 particles, publisher and listener on the same machine.
Prints scans, answers, latency from scan to pose, and the CPU that the node takes of a core. Meanwhile the map is sent again so
often as MAPS says. A measurement, not a test.
Usage: load_check.py PROGRAM [SECONDS [MAPS]]"""

import json
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import robot
from node_case import all_of_nav2

import parloc

SCENARIO = """
map: {root}/maps/fine/hall_obstacles.yaml
localization_map: {root}/maps/hall_obstacles.yaml
path: {root}/maps/paths/hall_17m.yaml
seed: 1
scan_rate: 40
lidar: {{beams: 1081, angle_min_deg: -135.0, angle_step_deg: 0.25, range_min: 0.05, range_max: 20.0, sigma_range: 0.02,
  mount: [0.1, 0.0, 0.0]}}
odometry: {{rate: 40, form: seed, alpha1: 0.1, alpha2: 0.05, alpha3: 0.1, alpha4: 0.02}}
"""


def cpu_s(pid):
    """Of a process so far."""
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / 100.0


def drive(work, program, seconds):
    """The messages of a simulated drive, and where it starts."""
    (work / "scenario.yaml").write_text(SCENARIO.format(root=robot.ROOT))
    for words in (
        ["simulate", "--scenario", work / "scenario.yaml", "--out", work / "sim", "--quiet"],
        ["log", "convert", work / "sim" / "scans.log", "--output", work / "drive.mcap"],
    ):
        subprocess.run([program, *map(str, words)], check=True, capture_output=True, timeout=300)
    messages = robot.messages_of(work / "drive.mcap")
    row = next(line for line in (work / "sim" / "truth.tum").read_text().splitlines() if line[0] != "#").split()
    return [m for m in messages if m[0] <= messages[0][0] + seconds and m[1] != "/odom"], [float(v) for v in row[1:3]]


def play(world, messages, map_bytes, maps):
    """At real time, in parts, with a map between them."""
    sent_s = {}
    for part in range(maps + 1):
        if part > 0:
            world.show_map(map_bytes)
        sent_s.update(world.play(messages[part * len(messages) // (maps + 1) : (part + 1) * len(messages) // (maps + 1)], 1.0))
    return sent_s


def main(program, seconds, maps):
    robot.begin()
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        messages, start = drive(work, program, seconds)
        topic = next(topic for _, topic, kind, _ in messages if kind == "sensor_msgs/msg/LaserScan")
        values = all_of_nav2(**{
            "scan_topic": topic, "initial_pose.x": start[0], "initial_pose.y": start[1], "initial_pose.yaw": 0.0,
            "min_particles": 2000, "resume_pose": False, "pose_file": str(work / "pose.json")})  # fmt: skip
        params = work / "params.yaml"
        params.write_text(json.dumps({"amcl": {"ros__parameters": values}}))
        world, node = robot.World(), robot.NodeProcess(params, work / "node.log")
        try:
            world.bring_up()
            map_bytes = parloc.map_message(parloc.read_map(robot.ROOT / "maps" / "hall_obstacles.yaml"))
            world.show_map(map_bytes)
            world.meet(messages)
            fixed = [message for message in messages if message[1] == "/tf_static"][:1]
            world.wait_for(lambda: world.play(fixed, 1e3) and "on a map" in node.said())
            cpu_before_s, wall_before_s = cpu_s(node.process.pid), time.monotonic()
            sent_s = play(world, messages, map_bytes, maps)
            cpu_share = (cpu_s(node.process.pid) - cpu_before_s) / (time.monotonic() - wall_before_s)
            scans = [stamp_s for name, stamp_s in sent_s if name == topic]
            world.wait_for(lambda: len(world.arrived_s) >= len(scans) - 1, 5.0)
            latency_ms = sorted(1e3 * (world.arrived_s[s] - sent_s[topic, s]) for s in scans if s in world.arrived_s)
            median_ms, p99_ms = statistics.median(latency_ms), latency_ms[int(0.99 * len(latency_ms))]
            print(f"{len(scans)} scans, {len(latency_ms)} answers; node: {100 * cpu_share:.0f} % of a core")
            print(f"scan to pose: median {median_ms:.2f} ms, p99 {p99_ms:.2f} ms, most {latency_ms[-1]:.2f} ms")
            print(node.said(), end="")
        finally:
            node.end()
            world.close()


if __name__ == "__main__":
    program, seconds, maps = sys.argv[1:] + ["30", "0"][len(sys.argv) - 2 :]
    main(program, float(seconds), int(maps))
