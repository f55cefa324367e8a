"""Reads the serialised objects of MRPT's recordings; no MRPT library needed.

An object is: length of its class name (with bit 7 set; files before 2006 have it as int32 without), the name, a version
(byte; int32 before), the members, and 0x88 (nothing before); little endian. Only the classes of the recordings that parloc
ships are known here.
"""

import gzip
import math
import struct
from dataclasses import dataclass


class Stream:
    def __init__(self, data):
        self.data = gzip.decompress(data) if data[:2] == b"\x1f\x8b" else data
        self.position = 0

    def take(self, layout):
        values = struct.unpack_from("<" + layout, self.data, self.position)
        self.position += struct.calcsize("<" + layout)
        return values if len(values) != 1 else values[0]

    def take_list(self, code):
        """As many as the number before them says."""
        count = self.take("I")
        values = self.take(f"{count}{code}")
        return (values,) if count == 1 else values

    def objects(self):
        while self.position < len(self.data):
            yield self.read()

    def read(self):
        tagged = self.data[self.position] & 0x80
        length = self.take("B") & 0x7F if tagged else self.take("i")
        name = self.data[self.position:self.position + length].decode()
        self.position += length
        value = READERS[name](self, self.take("B" if tagged else "i"))
        if tagged and self.take("B") != 0x88:
            raise ValueError(f"{name} at byte {self.position}: expected an end mark")
        return value

    def read_list(self):
        return [self.read() for _ in range(self.take("I"))]


@dataclass
class RangeScan:
    aperture_rad: float
    to_left: int
    range_max_m: float
    pose: tuple  # of the sensor on the base: x, y, z [m], yaw [rad]
    ranges_m: tuple
    valid: tuple
    ticks: int  # of 100 ns since 1601


@dataclass
class Movement:
    """Odometry: a pose in the frame of the one before, and the settings of MRPT's Gaussian motion model."""

    delta: tuple
    model: int
    gaussian: list
    ticks: int


def read_matrix(s, code):
    rows, columns = s.take("II")
    values = s.take(f"{rows * columns}{code}")
    return [values[row * columns:(row + 1) * columns] for row in range(rows)]


def read_pose3d(s, version):
    """x, y, z [m] and yaw [rad]."""
    if version < 2:
        m = s.read()
        return m[0][3], m[1][3], m[2][3], math.atan2(m[1][0], m[0][0])
    x, y, z, w, qx, qy, qz = s.take("7d")
    return x, y, z, math.atan2(2 * (w * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz))


def read_scan(s, version):
    aperture_rad, to_left, range_max_m = s.take("fBf")
    pose = s.read()
    if version < 6:
        s.read()  # covariance of the sensor's pose
    ranges_m = s.take_list("f")
    valid = s.take(f"{len(ranges_m)}B")  # in the recordings false exactly for the codes beyond the maximum
    _, ticks, _ = s.take("fQf")  # error, stamp, beam aperture
    if version >= 5:
        s.take_list("B")  # label
        s.take("d")
    return RangeScan(aperture_rad, to_left, range_max_m, pose, ranges_m, valid, ticks)


def read_movement(s, version):
    if s.take("I") != 0:
        raise ValueError("expected odometry")
    delta = s.read()
    model, *gaussian = s.take("I6f")
    s.take("I6f" if version >= 5 else "I4f")  # its other motion model
    s.take("BffBii")
    return Movement(delta, model, gaussian, s.take("Q") if version >= 6 else 0)


def read_frame(s, version):
    if version < 2:
        s.take("I")
    return s.read_list()


def read_pose_gaussian(s, covariance):
    mean = s.read()
    s.take(covariance)
    return mean


def read_simplemap(s, _):
    """Poses, and the scan taken at each."""
    return [(s.read(), s.read()[0]) for _ in range(s.take("I"))]


READERS = {
    "CPose2D": lambda s, version: s.take("3f" if version == 0 else "3d"),
    "CMatrix": lambda s, _: read_matrix(s, "f"),
    "CMatrixD": lambda s, _: read_matrix(s, "d"),
    "CPose3D": read_pose3d,
    "CPosePDFGaussian": lambda s, version: read_pose_gaussian(s, "6f" if version == 1 else "9f"),
    "CPose3DPDFGaussian": lambda s, _: read_pose_gaussian(s, "21d"),
    "CObservation2DRangeScan": read_scan,
    "CSensoryFrame": read_frame,
    "CSensorialFrame": read_frame,
    "CActionCollection": lambda s, _: s.read_list(),
    "CActionRobotMovement2D": read_movement,
    "CSimpleMap": read_simplemap,
    "CSensFrameProbSequence": read_simplemap,
}
