#!/usr/bin/env python3
"""Draws a drive on its map: the true path, what the odometry says, and where the beams end.

    python3 tools/studies/draw_log.py maps/hall_obstacles.pgm 0 0 DIR docs/images/hall_17m.png
    python3 tools/studies/draw_log.py maps/malaga_faculty.pgm -38 -49 maps/logs/malaga_faculty faculty.png

The two numbers are the map's origin; DIR holds scans.log and truth.tum of `parloc simulate`, else it is the beginning of the
names of a .log.gz and a .tum. Of a long log every 25th scan is drawn. Makes the pictures of docs/simulator.md.
"""

import math
import pathlib
import sys

from grids import GREY, OCCUPIED, UNKNOWN, png, read_pgm
from logs import read_log, read_tum
from measuring import reported
from poses import compose, relative

CELL_M, SCALE = 0.05, 3  # of the map; pixels per cell
INK = {GREY[OCCUPIED]: (60, 60, 60), GREY[UNKNOWN]: (205, 205, 205)}
HIT, ODOMETRY, TRUTH, STOP = (240, 160, 60), (200, 60, 60), (40, 90, 200), (10, 40, 120)


class Picture:
    def __init__(self, pgm, origin):
        self.width, height, cells = read_pgm(pgm)
        self.origin, self.rows = origin, []
        for row in range(height):
            line = b"".join(bytes(INK.get(v, (255, 255, 255))) * SCALE
                            for v in cells[row * self.width:(row + 1) * self.width])
            self.rows += [bytearray(line) for _ in range(SCALE)]

    def dot(self, x_m, y_m, colour, radius):
        column = (x_m - self.origin[0]) / CELL_M * SCALE
        row = len(self.rows) - (y_m - self.origin[1]) / CELL_M * SCALE
        for r in range(math.floor(row - radius), math.ceil(row + radius) + 1):
            for c in range(math.floor(column - radius), math.ceil(column + radius) + 1):
                inside = (r + 0.5 - row) ** 2 + (c + 0.5 - column) ** 2 <= radius ** 2
                if inside and 0 <= r < len(self.rows) and 0 <= c < self.width * SCALE:
                    self.rows[r][3 * c:3 * c + 3] = bytes(colour)


def draw(pgm, x, y, folder, image):
    picture, folder = Picture(pgm, (float(x), float(y))), pathlib.Path(folder)
    log, trajectory = ((folder / "scans.log", folder / "truth.tum") if folder.is_dir() else
                       (folder.with_suffix(".log.gz"), folder.with_suffix(".tum")))
    scans, truth = read_log(log), [row[1:] for row in read_tum(trajectory)]
    for pose, scan in list(zip(truth, scans, strict=False))[::25 if len(scans) > 250 else 1]:
        sensor = compose(pose, scan.T_base_sensor)
        for k, r in enumerate(scan.ranges_m):
            if 0 < r < scan.range_max_m:
                angle = sensor[2] + scan.angle_min_rad + k * scan.angle_step_rad
                picture.dot(sensor[0] + r * math.cos(angle), sensor[1] + r * math.sin(angle), HIT, 0.8)
    for scan in scans:
        picture.dot(*compose(truth[0], relative(scan.T_odom_base, scans[0].T_odom_base))[:2], ODOMETRY, 1.2)
    for before, pose in zip([truth[0], *truth], truth, strict=False):
        stands = math.dist(before[:2], pose[:2]) < 1e-6
        picture.dot(pose[0], pose[1], STOP if stands else TRUTH, 6 if stands else 2.2)
    pathlib.Path(image).write_bytes(png(picture.rows, channels=3))
    return 0


if __name__ == "__main__":
    if len(sys.argv) != 6:
        sys.exit(__doc__)
    sys.exit(reported(lambda: draw(*sys.argv[1:])))
