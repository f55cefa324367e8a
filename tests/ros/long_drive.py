#!/usr/bin/env python3
"""Hours of scans at 40 Hz through parloc.LiveLocalizer, as fast as it takes them: memory must not grow.
Prints scans and resident memory, hour by hour of the robot's clock. A measurement, not a test.
Usage: long_drive.py HOURS, with the Python package parloc on PYTHONPATH"""

import math
import struct
import sys
import time
from pathlib import Path

import numpy

import parloc

RATE_HZ, BEAMS, CYCLE = 40, 181, 600
LENGTH_M, WIDTH_M, CELL_M = 12.0, 6.0, 0.05
HEADER = b"\0\1\0\0"


def text(value):
    raw = value.encode() + b"\0"
    return struct.pack("<I", len(raw)) + raw + b"\0" * (-len(raw) % 4)


def stamp(time_s):
    return struct.pack("<iI", int(time_s), int(1e9 * (time_s % 1.0)))


def transform(time_s, parent, child, x_m, yaw_rad):
    """tf2_msgs/TFMessage with one transform."""
    body = struct.pack("<I", 1) + stamp(time_s) + text(parent) + text(child)
    body += b"\0" * (-len(body) % 8)
    return HEADER + body + struct.pack("<7d", x_m, 0.0, 0.0, 0.0, 0.0, math.sin(yaw_rad / 2), math.cos(yaw_rad / 2))


def scan(time_s, ranges_m):
    """sensor_msgs/LaserScan."""
    numbers = struct.pack("<7f", -math.pi / 2, math.pi / 2, math.pi / (BEAMS - 1), 0.0, 0.025, 0.1, 20.0)
    return HEADER + stamp(time_s) + text("laser") + numbers + struct.pack(f"<I{BEAMS}fI", BEAMS, *ranges_m, 0)


def resident_mib():
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096 / 2**20


def room():
    """Four walls."""
    cells = numpy.zeros((round(WIDTH_M / CELL_M), round(LENGTH_M / CELL_M)), numpy.uint8)
    cells[[0, -1], :] = cells[:, [0, -1]] = 1
    return parloc.GridMap(cells, CELL_M)


def ranges_from(x_m):
    """What is seen from the middle of the room, x_m from its left wall, looking along it."""
    ranges_m = []
    for k in range(BEAMS):
        angle_rad = math.pi * (k / (BEAMS - 1) - 0.5)
        ahead_m = (LENGTH_M - CELL_M - x_m) / max(math.cos(angle_rad), 1e-9)
        aside_m = (WIDTH_M / 2 - CELL_M) / max(abs(math.sin(angle_rad)), 1e-9)
        ranges_m.append(min(ahead_m, aside_m, 20.0))
    return ranges_m


def main(hours):
    config = parloc.Config.from_yaml("{particles: 300, threads: 1, log: {base_frame: base_link}, scan: {max_beams: 30}}")
    robot = parloc.LiveLocalizer(config)
    robot.put(robot.prepare(config, room()))
    robot.start((4.0, WIDTH_M / 2, 0.0), (0.1, 0.1, 0.05))
    robot.take("fixed_transforms", "/tf_static", transform(0.0, "base_link", "laser", 0.0, 0.0))
    moved_m = [2.0 * math.sin(2.0 * math.pi * k / CYCLE) for k in range(CYCLE)]
    seen_m = [ranges_from(4.0 + m) for m in moved_m]
    begun_s, answers, weighed = time.monotonic(), 0, 0
    for k in range(int(hours * 3600 * RATE_HZ)):
        time_s = 1.7e9 + k / RATE_HZ
        robot.take("transforms", "/tf", transform(time_s, "odom", "base_link", moved_m[k % CYCLE], 0.0))
        answered = robot.take("scan", "/scan", scan(time_s, seen_m[k % CYCLE]))
        answers, weighed = answers + len(answered), weighed + sum(answer.weighted for answer in answered)
        if (k + 1) % (3600 * RATE_HZ) == 0 or k == 60 * RATE_HZ:
            took_s = time.monotonic() - begun_s
            said = f"{answers} answers, {weighed} weighed, {answered[-1].state}"
            print(f"{k / RATE_HZ / 3600:6.2f} h: {said}, {resident_mib():.1f} MiB, {took_s:.0f} s", flush=True)


if __name__ == "__main__":
    main(float(sys.argv[1]))
