"""Maps, logs and settings in the forms that MRPT 2.5's pf-localization reads: .gridmap, .rawlog, truth and .ini.

Needs Python 3.10 and nothing else, no MRPT. Used by tools/studies/compare_mrpt.py.
"""

import gzip
import math
import pathlib
import re
import struct
from dataclasses import dataclass

from measuring import Failure
from poses import wrap

FREE, OCCUPIED, UNKNOWN = 0, 1, 2
MARGIN_CELLS = 16
SHORTEST_M = 0.1  # parloc's scan.laser_min_range for logs that state none
EPOCH_S = 1e9  # added to all stamps: MRPT's clock has no dates about 1970


# ---- Reading what parloc reads -----------------------------------------------------------------------------------------


@dataclass
class Grid:
    width: int
    height: int
    resolution_m: float
    origin_m: tuple  # lower-left corner
    cells: bytes  # FREE, OCCUPIED or UNKNOWN, row by row, the lowest first


@dataclass
class Scan:
    stamp_s: float
    ranges_m: list
    angle_min_rad: float
    angle_step_rad: float
    range_max_m: float
    T_base_sensor: tuple  # x, y [m], heading [rad]
    T_odom_base: tuple


def map_settings(path):
    """`key: value` lines of a map_server file."""
    try:
        text = pathlib.Path(path).read_text()
    except (OSError, UnicodeDecodeError) as error:
        raise Failure(2, f"{path}: expected a map_server YAML file: {error}")
    settings = dict(re.findall(r"^(\w+):[ \t]*([^#\n]*?)[ \t]*(?:#.*)?$", text, re.MULTILINE))
    if missing := {"image", "resolution", "origin"} - settings.keys():
        raise Failure(2, f"{path}: expected a map_server YAML file with {', '.join(sorted(missing))}")
    if settings.get("mode", "trinary") != "trinary":
        raise Failure(2, f"{path}: expected mode trinary, found {settings['mode']}")
    return settings


def read_pgm(path):
    """Width, height, and the grey values of a binary PGM with 8 bits."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise Failure(2, f"{path}: expected the map's image: {error}")
    head = re.match(rb"P5(?:\s+#[^\n]*)*\s+(\d+)\s+(\d+)\s+255\s", data)
    if not head:
        raise Failure(2, f"{path}: expected a binary PGM (P5) with grey values to 255")
    width, height = int(head[1]), int(head[2])
    if len(data) - head.end() != width * height:
        raise Failure(2, f"{path}: expected {width} x {height} grey values, found {len(data) - head.end()}")
    return width, height, data[head.end():]


def read_map(path):
    settings = map_settings(path)
    try:
        resolution_m = float(settings["resolution"])
        x_m, y_m, yaw = (float(part) for part in settings["origin"].strip("[]").split(","))
        occupied, free = float(settings.get("occupied_thresh", 0.65)), float(settings.get("free_thresh", 0.196))
        negate = int(settings.get("negate", 0))
    except ValueError as error:
        raise Failure(2, f"{path}: expected numbers: {error}")
    if not resolution_m > 0:
        raise Failure(2, f"{path}: expected a positive resolution, found {resolution_m:g}")
    # MRPT rounds a map's corner to whole cells and knows no turned maps.
    if yaw != 0 or any(abs(v / resolution_m - round(v / resolution_m)) > 1e-4 for v in (x_m, y_m)):
        raise Failure(2, f"{path}: expected an origin of whole cells and no yaw, found {settings['origin']}")
    width, height, grey = read_pgm(pathlib.Path(path).parent / settings["image"].strip("\"'"))

    def cell(value):
        p = (value if negate else 255 - value) / 255
        return OCCUPIED if p > occupied else FREE if p < free else UNKNOWN

    cells = grey.translate(bytes(map(cell, range(256))))
    rows = [cells[row * width:(row + 1) * width] for row in reversed(range(height))]
    return Grid(width, height, resolution_m, (x_m, y_m), b"".join(rows))


def with_margin(grid):
    """The map with unknown cells all around. MRPT's likelihood field is not right at a map's edge: it takes the last row and
    column for outside, and the row and column before the first for the first. Its rows must have a multiple of 16 cells."""
    width, height = -(-(grid.width + 2 * MARGIN_CELLS) // 16) * 16, grid.height + 2 * MARGIN_CELLS
    unknown = bytes([UNKNOWN])
    rows = [(unknown * MARGIN_CELLS + grid.cells[row * grid.width:(row + 1) * grid.width]).ljust(width, unknown)
            for row in range(grid.height)]
    empty = unknown * width * MARGIN_CELLS
    origin_m = tuple(v - MARGIN_CELLS * grid.resolution_m for v in grid.origin_m)
    return Grid(width, height, grid.resolution_m, origin_m, empty + b"".join(rows) + empty)


def map_server_files(grid, image):
    """Text of the YAML file and bytes of the image, as parloc reads them."""
    grey = grid.cells.translate(bytes([254, 0, 205]).ljust(256, b"\0"))
    rows = [grey[row * grid.width:(row + 1) * grid.width] for row in reversed(range(grid.height))]
    x_m, y_m = grid.origin_m
    text = (f"image: {image}\nmode: trinary\nresolution: {grid.resolution_m}\norigin: [{x_m:.9g}, {y_m:.9g}, 0.0]\nnegate: 0\n"
            "occupied_thresh: 0.65\nfree_thresh: 0.196\n")
    return text, f"P5\n{grid.width} {grid.height}\n255\n".encode() + b"".join(rows)


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
    c, s, dx, dy = math.cos(robot[2]), math.sin(robot[2]), laser[0] - robot[0], laser[1] - robot[1]
    sensor = (c * dx + s * dy, -s * dx + c * dy, wrap(laser[2] - robot[2]))
    return Scan(stamp, ranges, start, step, range_max, sensor, robot)


def read_log(path, limit):
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
                    raise Failure(2, f"{path}:{number}: expected a ROBOTLASER1 message of at least two ranges")
                if len(scans[-1].ranges_m) != len(scans[0].ranges_m):
                    raise Failure(2, f"{path}:{number}: expected {len(scans[0].ranges_m)} ranges as in the first scan")
                if len(scans) == limit:
                    break
    except (OSError, EOFError, UnicodeDecodeError) as error:
        raise Failure(2, f"{path}: expected a CARMEN log: {error}")
    if len(scans) < 10:
        raise Failure(2, f"{path}: expected at least 10 ROBOTLASER1 messages, found {len(scans)}")
    return scans


def thinned(scan, beams):
    """Every k-th beam, with the smallest k that leaves at most `beams`."""
    every = -(-len(scan.ranges_m) // beams)
    return Scan(scan.stamp_s, scan.ranges_m[::every], scan.angle_min_rad, scan.angle_step_rad * every, scan.range_max_m,
                scan.T_base_sensor, scan.T_odom_base)


def carmen_text(scan):
    """The scan as a line that parloc reads."""
    x, y, theta = scan.T_odom_base
    c, s = math.cos(theta), math.sin(theta)
    sx, sy, stheta = scan.T_base_sensor
    numbers = [scan.angle_min_rad, scan.angle_step_rad * (len(scan.ranges_m) - 1), scan.angle_step_rad, scan.range_max_m]
    poses = [x + c * sx - s * sy, y + s * sx + c * sy, wrap(theta + stheta), x, y, theta]
    return " ".join(["ROBOTLASER1 0", *(f"{v:.9f}" for v in numbers), "0.01 0", str(len(scan.ranges_m)),
                     *(f"{v:.4f}" for v in scan.ranges_m), "0", *(f"{v:.9f}" for v in poses), "0 0 0 0 0",
                     f"{scan.stamp_s:.6f} host {scan.stamp_s:.6f}"]) + "\n"


# ---- MRPT's serialised objects -----------------------------------------------------------------------------------------
# An object is: length of its class name with bit 7 set, the name, a version, the members, 0x88; little endian. The versions
# are those of the recordings in Debian's mrpt-common, which every MRPT 2 reads.


def mrpt_object(name, version, *members):
    return struct.pack("<B", 0x80 | len(name)) + name.encode() + struct.pack("<B", version) + b"".join(members) + b"\x88"


@dataclass
class Likelihood:
    """MRPT's settings of a grid's likelihood. A .gridmap holds them, and they replace those of the .ini file."""

    method: int  # RAY_TRACING or LIKELIHOOD_FIELD
    sigma_m: float
    z_hit: float = 0.95  # likelihood field: weight of exp(-d^2 / 2 sigma^2), which is not a density there
    z_random: float = 0.05  # ... and of 1 / range_max_m
    range_max_m: float = 8.0
    distance_cap_m: float = 0.3


RAY_TRACING, LIKELIHOOD_FIELD = 1, 4
LOG_ODDS = {FREE: 127, OCCUPIED: -127, UNKNOWN: 0}  # of being free, in a signed byte


def gridmap(grid, likelihood):
    """A COccupancyGridMap2D."""
    x_m, y_m = grid.origin_m
    head = struct.pack("<BII5f", 8, grid.width, grid.height, x_m, x_m + grid.width * grid.resolution_m, y_m,
                       y_m + grid.height * grid.resolution_m, grid.resolution_m)
    cells = grid.cells.translate(bytes(LOG_ODDS[kind] & 0xFF for kind in range(3)).ljust(256, b"\0"))
    insertion = struct.pack("<fBffBHf", 0.0, 0, 15.0, 0.65, 1, 1, 0.0)
    options = struct.pack("<i4fIfB", likelihood.method, likelihood.sigma_m, likelihood.z_hit, likelihood.z_random,
                          likelihood.range_max_m, 1, likelihood.distance_cap_m, 0)  # every beam, their product
    options += struct.pack("<fIfBif", 2.5, 10, 1.5, 0, 1, likelihood.sigma_m)  # of other methods; rays: every beam, sigma
    options += struct.pack("<ifI100fB", 1, 5.0, 100, *[0.01] * 100, 1)  # of other methods; the field is kept in a table
    return mrpt_object("COccupancyGridMap2D", 3, head, cells, insertion, options, struct.pack("<B", 0))


def ticks(stamp_s):
    """100 ns since 1601."""
    return round((stamp_s + 11644473600) * 1e7)


@dataclass
class Motion:
    """MRPT's Gaussian motion model: sigma_xy = a1 d + a2 |turn| + floor, sigma_phi = a3 d + a4 |turn| + floor."""

    a1: float
    a2: float
    a3: float
    a4: float
    floor_m: float
    floor_rad: float


def increment(before, after):
    """Pose `after` seen from pose `before`."""
    c, s, dx, dy = math.cos(before[2]), math.sin(before[2]), after[0] - before[0], after[1] - before[1]
    return c * dx + s * dy, -s * dx + c * dy, wrap(after[2] - before[2])


def action(delta, motion, stamp_s):
    movement = mrpt_object(
        "CActionRobotMovement2D", 6, struct.pack("<I", 0), mrpt_object("CPose2D", 1, struct.pack("<3d", *delta)),
        struct.pack("<I6f", 0, motion.a1, motion.a2, motion.a3, motion.a4, motion.floor_m, motion.floor_rad),
        struct.pack("<I6f", 300, 0, 0, 0, 0, 0, 0),  # its other motion model, not in use
        struct.pack("<BffBiiQ", 0, 0, 0, 0, 0, 0, ticks(stamp_s)))
    return mrpt_object("CActionCollection", 0, struct.pack("<I", 1), movement)


def observation(scan, stamp_s, misses_count, range_max_m):
    aperture = scan.angle_step_rad * (len(scan.ranges_m) - 1)
    x, y, heading = scan.T_base_sensor
    yaw = heading + scan.angle_min_rad + aperture / 2  # MRPT's scans lie evenly about the sensor's x axis
    pose = mrpt_object("CPose3D", 2, struct.pack("<7d", x, y, 0, math.cos(yaw / 2), 0, 0, math.sin(yaw / 2)))
    missed = [not r < scan.range_max_m and not math.isnan(r) for r in scan.ranges_m]
    ranges_m = [scan.range_max_m if miss else r if math.isfinite(r) else 0.0 for r, miss in zip(scan.ranges_m, missed)]
    valid = bytes(misses_count if miss else r >= SHORTEST_M for r, miss in zip(ranges_m, missed))
    label = b"laser"
    return mrpt_object(
        "CObservation2DRangeScan", 6, struct.pack("<fBf", aperture, 1, range_max_m), pose, struct.pack("<I", len(ranges_m)),
        struct.pack(f"<{len(ranges_m)}f", *ranges_m), valid, struct.pack("<fQf", 0.01, ticks(stamp_s), math.radians(0.25)),
        struct.pack("<I", len(label)), label, struct.pack("<d", 0.0))


def rawlog(scans, motion, misses_count, range_max_m):
    """An action and a scan per scan. misses_count: a beam without return counts as one of scan.range_max_m, else as none.
    range_max_m is what MRPT is told of the sensor."""
    parts, before = [], scans[0].T_odom_base
    for scan in scans:
        stamp_s = mrpt_stamp(scan, scans)
        scan_object = observation(scan, stamp_s, misses_count, range_max_m)
        parts += [action(increment(before, scan.T_odom_base), motion, stamp_s),
                  mrpt_object("CSensoryFrame", 2, struct.pack("<I", 1), scan_object)]
        before = scan.T_odom_base
    return b"".join(parts)


def mrpt_stamp(scan, scans):
    return EPOCH_S + 0.05 + scan.stamp_s - scans[0].stamp_s


def ground_truth(scans, poses):
    """Text rows `time x y heading`. MRPT takes the first column for times if that of the first two rows is no whole number:
    hence two rows of the past."""
    rows = [(EPOCH_S + past, *poses[0]) for past in (0.02, 0.03)]
    rows += [(mrpt_stamp(scan, scans), *pose) for scan, pose in zip(scans, poses)]
    return "".join(f"{t:.6f} {x:.6f} {y:.6f} {heading:.9f}\n" for t, x, y, heading in rows)


INI = """[KLD_options]
KLD_minSampleSize = {particles}
KLD_maxSampleSize = {particles}

[PF_options]
PF_algorithm = 0            // standard proposal
resamplingMethod = 3        // systematic
adaptiveSampleSize = 0
BETA = 1                    // resample in every step
powFactor = {tempering}
sampleSize = {particles}

[LocalizationExperiment]
use_3D_poses = false
map_file = {folder}/{name}.gridmap
rawlog_file = {folder}/{name}.rawlog
ground_truth_path_file = {folder}/truth.txt
logOutput_dir = {folder}/{name}
3DSceneFrequency = -1
experimentRepetitions = 1
particles_count = {particles}
init_PDF_mode = 1           // uniform in this box
init_PDF_min_x = {x_min:.6f}
init_PDF_max_x = {x_max:.6f}
init_PDF_min_y = {y_min:.6f}
init_PDF_max_y = {y_max:.6f}
init_PDF_min_yaw_deg = {yaw_min:.6f}
init_PDF_max_yaw_deg = {yaw_max:.6f}
SHOW_PROGRESS_3D_REAL_TIME = false

[MetricMap]
occupancyGrid_count = 1
likelihoodMapSelection = -1

[MetricMap_occupancyGrid_00_creationOpts]
resolution = {resolution_m}

[MetricMap_occupancyGrid_00_likelihoodOpts]
// Not in use: the .gridmap file has its own. Only there can ray tracing be told to use every beam.
likelihoodMethod = {method}
"""


def ini(folder, name, particles, start, sigma_m, sigma_rad, tempering, likelihood, resolution_m):
    """Settings of pf-localization. It has no Gaussian start: a box of the same standard deviation is its nearest."""
    half_m, half_deg = math.sqrt(3) * sigma_m, math.degrees(math.sqrt(3) * sigma_rad)
    x, y, yaw = start[0], start[1], math.degrees(start[2])
    return INI.format(folder=folder, name=name, particles=particles, tempering=tempering, method=likelihood.method,
                      resolution_m=resolution_m, x_min=x - half_m, x_max=x + half_m, y_min=y - half_m, y_max=y + half_m,
                      yaw_min=yaw - half_deg, yaw_max=yaw + half_deg)
