"""Reads the scans, poses and odometry of MRPT's serialised objects; no MRPT library needed."""

import gzip
import struct
from dataclasses import dataclass

import numpy as np

MAP_RANGE_M = 30.0  # beyond it, beams half a degree apart are too sparse for 5 cm cells
NO_RETURN_M = 80.0  # the recordings' maxRange; codes for "no return" are 81.83 to 81.91


# ---- planar geometry ---------------------------------------------------------------------------------------------------


def wrap(a):
    return (a + np.pi) % (2 * np.pi) - np.pi


def transform(pose, points):
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return pose[:2] + points @ np.array([[c, s], [-s, c]])


def compose(a, b):
    return np.append(transform(a, b[None, :2])[0], wrap(a[2] + b[2]))


def relative(a, b):
    """Pose a seen from pose b."""
    c, s = np.cos(b[2]), np.sin(b[2])
    d = a[:2] - b[:2]
    return np.array([c * d[0] + s * d[1], -s * d[0] + c * d[1], wrap(a[2] - b[2])])


# ---- MRPT's serialised objects -----------------------------------------------------------------------------------------
# An object is: length of its class name (with bit 7 set; files before 2006 have it as int32 without), the name, a version
# (byte; int32 before), the members, and 0x88 (nothing before). Only the classes of these four files are known here.


class Stream:
    def __init__(self, path):
        data = path.read_bytes()
        self.data = gzip.decompress(data) if data[:2] == b"\x1f\x8b" else data
        self.position = 0

    def take(self, layout):
        values = struct.unpack_from("<" + layout, self.data, self.position)
        self.position += struct.calcsize("<" + layout)
        return values if len(values) > 1 else values[0]

    def objects(self):
        while self.position < len(self.data):
            yield self.read()

    def read(self):
        tagged = self.data[self.position] & 0x80
        length = self.take("B") & 0x7F if tagged else self.take("i")
        name = self.data[self.position : self.position + length].decode()
        self.position += length
        value = READERS[name](self, self.take("B" if tagged else "i"))
        if tagged and self.take("B") != 0x88:
            raise ValueError(f"{name} at byte {self.position}: expected an end mark")
        return value


@dataclass
class Observation:
    """One scan: ranges in metres from right (-90 degrees) to left (+90 degrees), both ends included."""

    stamp_s: float
    ranges_m: np.ndarray
    T_base_sensor: np.ndarray  # x, y, theta

    def points(self, max_range_m=MAP_RANGE_M):
        """Reflections in the frame of the base, n x 2."""
        bearing = -np.pi / 2 + np.pi / (len(self.ranges_m) - 1) * np.arange(len(self.ranges_m))
        keep = (self.ranges_m > 0.05) & (self.ranges_m < max_range_m)
        r, a = self.ranges_m[keep], bearing[keep]
        return transform(self.T_base_sensor, np.stack([r * np.cos(a), r * np.sin(a)], 1))


def read_matrix(s, code):
    rows, columns = s.take("II")
    return np.array(s.take(f"{rows * columns}{code}")).reshape(rows, columns)


def read_pose3d(s, version):
    """Planar part (x, y, yaw) of a 3-D pose."""
    if version < 2:
        m = s.read()
        return np.array([m[0, 3], m[1, 3], np.arctan2(m[1, 0], m[0, 0])])
    x, y, _, w, qx, qy, qz = s.take("7d")
    return np.array([x, y, np.arctan2(2 * (w * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz))])


def read_scan(s, version):
    aperture_rad, right_to_left, max_range_m = s.take("fBf")
    T_base_sensor = s.read()
    if version < 6:
        s.read()  # covariance of the sensor's pose
    count = s.take("I")
    ranges_m = np.array(s.take(f"{count}f"))
    s.take(f"{count}B")  # validity: false exactly for the codes beyond the maximum
    _, ticks, _ = s.take("fQf")  # error, stamp in 100 ns since 1601, beam aperture
    if version >= 5:
        label_bytes = s.take("I")
        s.position += label_bytes
        s.take("d")
    if right_to_left != 1 or count != 361 or abs(aperture_rad - np.pi) > 1e-6 or max_range_m != NO_RETURN_M:
        raise ValueError("expected 361 beams over 180 degrees from right to left, 80 m")
    return Observation((ticks - 116444736000000000) / 1e7, ranges_m, T_base_sensor)


def read_movement(s, version):
    """Odometry increment, a pose in the frame of the one before."""
    if s.take("I") != 0:
        raise ValueError("expected odometry")
    increment = np.array(s.read(), dtype=float)
    s.take("I6fI6f" if version >= 5 else "I6fI4f")  # settings of MRPT's own motion model
    s.take("BffBii")
    if version >= 6:
        s.take("Q")
    return increment


def read_frame(s, version):
    if version < 2:
        s.take("I")
    return [s.read() for _ in range(s.take("I"))]


def read_pose_gaussian(s, version):
    mean = np.array(s.read(), dtype=float)
    s.take("6f" if version == 1 else "9f")
    return mean


def read_pose3d_gaussian(s, _):
    mean = s.read()
    s.take("21d")
    return mean


def read_simplemap(s, _):
    return [(s.read(), s.read()[0]) for _ in range(s.take("I"))]


READERS = {
    "CPose2D": lambda s, version: s.take("3f" if version == 0 else "3d"),
    "CMatrix": lambda s, _: read_matrix(s, "f"),
    "CMatrixD": lambda s, _: read_matrix(s, "d"),
    "CPose3D": read_pose3d,
    "CPosePDFGaussian": read_pose_gaussian,
    "CPose3DPDFGaussian": read_pose3d_gaussian,
    "CObservation2DRangeScan": read_scan,
    "CSensoryFrame": read_frame,
    "CSensorialFrame": read_frame,
    "CActionCollection": lambda s, _: [s.read() for _ in range(s.take("I"))],
    "CActionRobotMovement2D": read_movement,
    "CSimpleMap": read_simplemap,
    "CSensFrameProbSequence": read_simplemap,
}


def read_rawlog(path):
    """Scans, and the odometry pose at each, from the increments between them; the first is at the origin."""
    scans, odometry, pose = [], [], np.zeros(3)
    for entry in Stream(path).objects():
        if isinstance(entry[0], Observation):
            scans.append(entry[0])
            odometry.append(pose)
        elif scans:  # an increment before the first scan moves nothing that is in the log
            pose = compose(pose, entry[0])
    return scans, np.array(odometry)
