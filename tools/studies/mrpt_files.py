"""Maps, logs and settings in the forms that MRPT 2.5's pf-localization reads: .gridmap, .rawlog, truth and .ini.

Needs Python 3.10 and nothing else, no MRPT. Used by tools/studies/compare_mrpt.py.
"""

import math
import struct
from dataclasses import dataclass, replace

from grids import FREE, OCCUPIED, UNKNOWN, grid_of
from poses import relative

MARGIN_CELLS = 16
SHORTEST_M = 0.1  # parloc's scan.laser_min_range for logs that state none
EPOCH_S = 1e9  # added to all stamps: MRPT's clock has no dates about 1970


# ---- What both programs get --------------------------------------------------------------------------------------------


def with_margin(grid):
    """The map with unknown cells all around. MRPT's likelihood field is not right at a map's edge: it takes the last row and
    column for outside, and the row and column before the first for the first. Its rows must have a multiple of 16 cells."""
    width = -(-(grid.width + 2 * MARGIN_CELLS) // 16) * 16
    unknown = bytes([UNKNOWN])
    empty = [unknown * width] * MARGIN_CELLS
    rows = [(unknown * MARGIN_CELLS + row).ljust(width, unknown) for row in grid.rows()]
    return grid_of(empty + rows + empty, grid.resolution_m, tuple(v - MARGIN_CELLS * grid.resolution_m for v in grid.origin_m))


def thinned(scan, beams):
    """Every k-th beam, with the smallest k that leaves at most `beams`."""
    every = -(-len(scan.ranges_m) // beams)
    return replace(scan, ranges_m=scan.ranges_m[::every], angle_step_rad=scan.angle_step_rad * every)


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
    ranges_m = [scan.range_max_m if miss else r if math.isfinite(r) else 0.0
                for r, miss in zip(scan.ranges_m, missed, strict=True)]
    valid = bytes(misses_count if miss else r >= SHORTEST_M for r, miss in zip(ranges_m, missed, strict=True))
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
        parts += [action(relative(scan.T_odom_base, before), motion, stamp_s),
                  mrpt_object("CSensoryFrame", 2, struct.pack("<I", 1), scan_object)]
        before = scan.T_odom_base
    return b"".join(parts)


def mrpt_stamp(scan, scans):
    return EPOCH_S + 0.05 + scan.stamp_s - scans[0].stamp_s


def ground_truth(scans, poses):
    """Text rows `time x y heading`. MRPT takes the first column for times if that of the first two rows is no whole number:
    hence two rows of the past."""
    rows = [(EPOCH_S + past, *poses[0]) for past in (0.02, 0.03)]
    rows += [(mrpt_stamp(scan, scans), *pose) for scan, pose in zip(scans, poses, strict=True)]
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
