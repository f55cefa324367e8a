"""A drive as numbers, from a CARMEN log of ROBOTLASER lines, and written as CARMEN again: what bags of it are held against."""

import dataclasses
import gzip
import math

import numpy as np


@dataclasses.dataclass
class Scan:
    stamp_ns: int
    ranges_m: np.ndarray  # float32
    odometry: tuple  # x [m], y [m], yaw [rad]


@dataclasses.dataclass
class Drive:
    angle_min_rad: float  # values of float32, as messages hold them
    angle_step_rad: float
    range_max_m: float
    ahead_m: float  # the LiDAR, of the base
    scans: list


def stamp_text(stamp_ns):
    return f"{stamp_ns // 10**9}.{stamp_ns % 10**9:09d}"


def stamp_ns_of(text):
    seconds, _, digits = text.partition(".")
    return int(seconds) * 10**9 + int(digits.ljust(9, "0")[:9])


def yaw_quaternion(yaw_rad):
    """z and w of a turn about z."""
    return math.sin(yaw_rad / 2), math.cos(yaw_rad / 2)


def as_messages_hold_it(yaw_rad):
    z, w = yaw_quaternion(yaw_rad)
    return 2 * math.atan2(z, w)


def read_drive(path):
    scans = []
    with gzip.open(path, "rt") as lines:
        for line in lines:
            words = line.split()
            if words[0] != "ROBOTLASER1":
                continue
            start, step, most, n = float(words[2]), float(words[4]), float(words[5]), int(words[8])
            ranges = np.array(words[9 : 9 + n], dtype=np.float32)
            tail = words[9 + n + 1 + int(words[9 + n]) :]
            x, y, yaw = (float(w) for w in tail[3:6])
            ahead_m = round(math.hypot(float(tail[0]) - x, float(tail[1]) - y), 4)
            scans.append(Scan(stamp_ns_of(tail[11]), ranges, (x, y, as_messages_hold_it(yaw))))
    return Drive(float(np.float32(start)), float(np.float32(step)), float(np.float32(most)), ahead_m, scans)


def carmen_text(drive):
    """The same numbers, each with all of its digits."""
    lines = []
    for scan in drive.scans:
        n = len(scan.ranges_m)
        x, y, yaw = scan.odometry
        pose = f"{x!r} {y!r} {yaw!r}"
        laser_pose = f"{x + drive.ahead_m * math.cos(yaw)!r} {y + drive.ahead_m * math.sin(yaw)!r} {yaw!r}"
        ranges = " ".join(repr(float(r)) for r in scan.ranges_m)
        head = f"{drive.angle_min_rad!r} {drive.angle_step_rad * (n - 1)!r} {drive.angle_step_rad!r} {drive.range_max_m!r}"
        stamp = stamp_text(scan.stamp_ns)
        lines.append(f"ROBOTLASER1 0 {head} 0 0 {n} {ranges} 0 {laser_pose} {pose} 0 0 0 0 0 {stamp} robot {stamp}")
    return "\n".join(lines) + "\n"
