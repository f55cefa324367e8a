"""Scans of CARMEN logs, and trajectories of TUM files."""

import bisect
import gzip
import math
from dataclasses import dataclass

from measuring import Failure
from poses import compose, relative, wrap

RECORDED = {"intel": "map.yaml", "aces": "map.yaml", "tb3_house": "map_05.yaml"}  # the maps of the logs in the data's folder
MAX_TRUTH_GAP_S = 1.5  # as parloc itself interpolates


# ---- Scans -------------------------------------------------------------------------------------------------------------


@dataclass
class Scan:
    stamp_s: float
    ranges_m: list
    angle_min_rad: float
    angle_step_rad: float
    range_max_m: float
    T_base_sensor: tuple  # x, y [m], heading [rad]
    T_odom_base: tuple


def parse_robotlaser(line):
    fields = line.split()
    start, fov, step, range_max = map(float, fields[2:6])
    count = int(fields[8])
    ranges = [float(field) for field in fields[9:9 + count]]
    rest = fields[10 + count + int(fields[9 + count]):]
    laser, robot, stamp = tuple(map(float, rest[0:3])), tuple(map(float, rest[3:6])), float(rest[11])
    if len(ranges) != count or count < 2:
        raise ValueError
    if abs(fov / (count - 1) - step) < 1e-6:
        step = fov / (count - 1)  # the same number with less rounding
    return Scan(stamp, ranges, start, step, range_max, relative(laser, robot), robot)


def read_log(path, limit=None):
    """The first scans of a CARMEN log; all must look alike, as MRPT's format wants."""
    scans = []
    try:
        with open(path, "rb") as file:
            zipped = file.read(2) == b"\x1f\x8b"
        with (gzip.open if zipped else open)(path, "rt") as lines:
            for number, line in enumerate(lines, 1):
                if line.startswith(("FLASER ", "RLASER ")):
                    raise Failure(2, f"{path}:{number}: expected scans as ROBOTLASER1, found {line.split()[0]}")
                if not line.startswith("ROBOTLASER1 "):
                    continue
                try:
                    scans.append(parse_robotlaser(line))
                except (ValueError, IndexError):
                    raise Failure(2, f"{path}:{number}: expected a ROBOTLASER1 message of at least two ranges") from None
                if len(scans[-1].ranges_m) != len(scans[0].ranges_m):
                    raise Failure(2, f"{path}:{number}: expected {len(scans[0].ranges_m)} ranges as in the first scan")
                if len(scans) == limit:
                    break
    except (OSError, EOFError, UnicodeDecodeError) as error:
        raise Failure(2, f"{path}: expected a CARMEN log: {error}") from None
    if len(scans) < 10:
        raise Failure(2, f"{path}: expected at least 10 ROBOTLASER1 messages, found {len(scans)}")
    return scans


def carmen_text(scan):
    """The scan as a line that parloc reads."""
    numbers = [scan.angle_min_rad, scan.angle_step_rad * (len(scan.ranges_m) - 1), scan.angle_step_rad, scan.range_max_m]
    poses = [*compose(scan.T_odom_base, scan.T_base_sensor), *scan.T_odom_base]
    return " ".join(["ROBOTLASER1 0", *(f"{v:.9f}" for v in numbers), "0.01 0", str(len(scan.ranges_m)),
                     *(f"{v:.4f}" for v in scan.ranges_m), "0", *(f"{v:.9f}" for v in poses), "0 0 0 0 0",
                     f"{scan.stamp_s:.6f} host {scan.stamp_s:.6f}"]) + "\n"


# ---- Trajectories ------------------------------------------------------------------------------------------------------


def read_tum(path):
    """[(stamp [s], x [m], y [m], heading [rad])] in file order."""
    rows = []
    try:
        with open(path) as lines:
            for number, line in enumerate(lines, 1):
                if line.startswith("#") or not line.strip():
                    continue
                try:
                    stamp, x, y, _, _, _, qz, qw = map(float, line.split())
                except ValueError:
                    raise Failure(2, f"{path}:{number}: expected 8 numbers: timestamp x y z qx qy qz qw") from None
                rows.append((stamp, x, y, 2 * math.atan2(qz, qw)))
    except (OSError, UnicodeDecodeError) as error:
        raise Failure(2, f"{path}: expected a trajectory: {error}") from None
    return rows


class Truth:
    """The true pose and yaw rate at any stamp, by the rule of `parloc run`: the row of that stamp, else interpolated."""

    def __init__(self, rows):
        self.exact = {}
        for row in rows:
            self.exact.setdefault(round(row[0] * 1e6), row)
        self.rows = sorted(rows, key=lambda row: row[0])

    def _around(self, stamp_s):
        after = bisect.bisect_right(self.rows, stamp_s, key=lambda row: row[0])
        if not 0 < after < len(self.rows):
            return None
        a, b = self.rows[after - 1], self.rows[after]
        return (a, b) if 0 < b[0] - a[0] <= MAX_TRUTH_GAP_S else None

    def pose(self, stamp_s):
        row = self.exact.get(round(stamp_s * 1e6))
        if row:
            return row[1:]
        if not (around := self._around(stamp_s)):
            return None
        a, b = around
        u = (stamp_s - a[0]) / (b[0] - a[0])
        return a[1] + u * (b[1] - a[1]), a[2] + u * (b[2] - a[2]), a[3] + u * wrap(b[3] - a[3])

    def yaw_rate(self, stamp_s):
        """[rad/s] between the two rows around the stamp, None where there are none."""
        if not (around := self._around(stamp_s)):
            return None
        a, b = around
        return wrap(b[3] - a[3]) / (b[0] - a[0])
