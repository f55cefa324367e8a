#!/usr/bin/env python3
"""Draws a simulated drive on its map: the true path, what the odometry says, and where the beams end.

    python3 tools/studies/draw_log.py maps/hall_obstacles.pgm 0 0 DIR docs/images/hall_17m.png

The two numbers are the map's origin; DIR holds scans.log and truth.tum of `parloc simulate`. Makes the pictures of
docs/simulator.md; Python's standard library only.
"""

import math
import pathlib
import sys

from make_maps import COARSE_M, OCCUPIED, UNKNOWN, write_png
from poses import compose, inverse

SCALE = 3  # pixels per cell
INK = {OCCUPIED: (60, 60, 60), UNKNOWN: (205, 205, 205)}
HIT, ODOMETRY, TRUTH, STOP = (240, 160, 60), (200, 60, 60), (40, 90, 200), (10, 40, 120)


class Picture:
    def __init__(self, pgm, origin):
        _, size, _, cells = pathlib.Path(pgm).read_bytes().split(b"\n", 3)
        self.width, self.height = map(int, size.split())
        self.origin, self.rows = origin, []
        for row in range(self.height):
            line = b"".join(bytes(INK.get(v, (255, 255, 255))) * SCALE
                            for v in cells[row * self.width:(row + 1) * self.width])
            self.rows += [bytearray(line) for _ in range(SCALE)]

    def dot(self, x_m, y_m, colour, radius):
        column = (x_m - self.origin[0]) / COARSE_M * SCALE
        row = len(self.rows) - (y_m - self.origin[1]) / COARSE_M * SCALE
        for r in range(math.floor(row - radius), math.ceil(row + radius) + 1):
            for c in range(math.floor(column - radius), math.ceil(column + radius) + 1):
                inside = (r + 0.5 - row) ** 2 + (c + 0.5 - column) ** 2 <= radius ** 2
                if inside and 0 <= r < len(self.rows) and 0 <= c < self.width * SCALE:
                    self.rows[r][3 * c:3 * c + 3] = bytes(colour)


def read_truth(path):
    rows = [list(map(float, line.split())) for line in open(path) if not line.startswith("#")]
    return [(r[1], r[2], 2 * math.atan2(r[6], r[7])) for r in rows]


def read_scans(path):
    """(start angle, step, maximum, ranges, laser pose, robot pose) per ROBOTLASER1 line, poses by odometry."""
    for line in open(path):
        word = line.split()
        if word[:1] != ["ROBOTLASER1"]:
            continue
        n = int(word[8])
        poses = list(map(float, word[10 + n:16 + n]))
        yield (float(word[2]), float(word[4]), float(word[5]), list(map(float, word[9:9 + n])), tuple(poses[:3]),
               tuple(poses[3:]))


def main(pgm, x, y, folder, png):
    picture = Picture(pgm, (float(x), float(y)))
    truth = read_truth(pathlib.Path(folder) / "truth.tum")
    scans = list(read_scans(pathlib.Path(folder) / "scans.log"))
    for pose, (start, step, longest, ranges, laser, robot) in list(zip(truth, scans))[::25]:
        sensor = compose(pose, compose(inverse(robot), laser))
        for k, r in enumerate(ranges):
            if 0 < r < longest:
                angle = sensor[2] + start + k * step
                picture.dot(sensor[0] + r * math.cos(angle), sensor[1] + r * math.sin(angle), HIT, 0.8)
    to_map = compose(truth[0], inverse(scans[0][5]))
    for scan in scans:
        picture.dot(*compose(to_map, scan[5])[:2], ODOMETRY, 1.2)
    for before, pose in zip([truth[0]] + truth, truth):
        stands = math.dist(before[:2], pose[:2]) < 1e-6
        picture.dot(pose[0], pose[1], STOP if stands else TRUTH, 6 if stands else 2.2)
    write_png(pathlib.Path(png), picture.rows, channels=3)


if __name__ == "__main__":
    if len(sys.argv) != 6:
        sys.exit(__doc__)
    main(*sys.argv[1:])
