"""What compare_mrpt.py compares: the same models, log and start, in the words of parloc and of MRPT."""

import math
from dataclasses import dataclass

import mrpt_files as mrpt
from accuracy import PAPER_MAP, PAPER_SCENARIO
from grids import Grid, read_map, write_map
from logs import Truth, carmen_text, read_log, read_tum
from measuring import ROOT, Failure
from runs import simulate, yaml_text

SIGMA_M = 0.1  # of all models
START_SIGMA_M, START_SIGMA_RAD = 0.05, 0.03
ALPHAS = (0.1, 0.05, 0.1, 0.02)  # parloc's motion noise, as configs/paz2012.yaml has it
MOTION = mrpt.Motion(ALPHAS[2], ALPHAS[3], math.sqrt(2) * ALPHAS[1], ALPHAS[0], 1e-4, 1e-4)
FIELD_CAP_M, FIELD_HIT, FIELD_RANDOM, FIELD_TEMPERING = 2.0, 0.9, 0.1, 0.1  # parloc's defaults
MRPT_RAY_STEP_CELLS = 0.8
MRPT_RAY_HIT, MRPT_RAY_FLOOR_M = 0.9, 0.1  # likelihood 0.9 exp(-d^2 / 2 sigma^2) + 0.1 m / maximum range


# ---- What is compared --------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Row:
    key: str
    text: str
    group: str  # compared with MRPT's row of the same group
    model: str = ""  # parloc's configuration; none for MRPT
    threads: int = 1
    simd: str = ""  # limit of the instruction set


def parloc_rows(group, model, text):
    return [Row(f"{model}_1", f"parloc, {text}", group, model),
            Row(f"{model}_2", f"parloc, {text}", group, model, threads=2),
            Row(f"{model}_1_baseline", f"parloc, {text}, without AVX", group, model, simd="baseline")]


ROWS = [Row("mrpt_ray", "**MRPT, `lmRayTracing`**", "ray"),
        *parloc_rows("ray", "mixture", "`beam` with MRPT's likelihood"),
        *parloc_rows("ray", "gaussian", "`gaussian`"),
        Row("mrpt_field", "**MRPT, `lmLikelihoodField_Thrun`**", "field"),
        *parloc_rows("field", "field", "`likelihood_field`, same likelihood")]


def mixture(range_max_m):
    """Shares of parloc's beam model with the likelihood of MRPT's ray tracing, up to a factor: density of a hit to density of
    anything as there, and likewise for a miss."""
    floor = MRPT_RAY_FLOOR_M / told_range_m(range_max_m)
    hit, miss = MRPT_RAY_HIT / peak_of_density(), floor / MRPT_RAY_HIT
    shares = {"z_hit": hit, "z_short": 0.0, "z_max": hit * miss, "z_rand": floor * range_max_m}
    return {key: value / sum(shares.values()) for key, value in shares.items()}


def peak_of_density():
    return 1 / (SIGMA_M * math.sqrt(2 * math.pi))


def told_range_m(range_max_m):
    """MRPT's rays end after maximum range / cell steps of 0.8 cells: told a longer range, they reach the true one."""
    return range_max_m / MRPT_RAY_STEP_CELLS


def parloc_config(model, range_max_m):
    sensor = {
        "mixture": {"model": "beam", "tempering": 1, **mixture(range_max_m)},
        "gaussian": {"model": "gaussian", "tempering": 1},
        "field": {"model": "likelihood_field", "z_hit": FIELD_HIT, "z_rand": FIELD_RANDOM, "lookup": "nearest",
                  "laser_likelihood_max_dist": FIELD_CAP_M, "tempering": FIELD_TEMPERING},
    }[model]
    return yaml_text({"motion": {"form": "seed", **{f"alpha{i}": alpha for i, alpha in enumerate(ALPHAS, 1)}},
                      "sensor": {**sensor, "sigma_hit": SIGMA_M}, "resample": {"scheme": "systematic", "threshold": 1.0},
                      "estimate": {"mode": "mean"}})


def mrpt_likelihood(row, range_max_m):
    if row.group == "ray":
        return mrpt.Likelihood(mrpt.RAY_TRACING, SIGMA_M)
    return mrpt.Likelihood(mrpt.LIKELIHOOD_FIELD, SIGMA_M, FIELD_HIT * peak_of_density(), FIELD_RANDOM, range_max_m,
                           FIELD_CAP_M)


# ---- The log -----------------------------------------------------------------------------------------------------------


def lidar_of(beams):
    """Exactly so many beams over the same angle as the paper's scenario has."""
    return {"beams": beams, "angle_step_deg": f"{270 / (beams - 1):.12g}"}


def take_log(bench):
    """Files of the map, the log, and the truth."""
    if bench.args.log:
        return bench.args.map, bench.args.log, bench.args.truth
    drive, _ = simulate(bench, PAPER_SCENARIO, None, "simulated", lidar_of(bench.args.beams))
    return ROOT / PAPER_MAP, drive / "scans.log", drive / "truth.tum"


@dataclass
class Drive:
    """What both programs get."""

    grid: Grid
    scans: list
    poses: list  # the true ones: x, y [m], heading [rad]


def read_drive(bench):
    map_file, log, truth_file = take_log(bench)
    grid = mrpt.with_margin(read_map(map_file))
    scans = [mrpt.thinned(scan, bench.args.beams) for scan in read_log(log, bench.args.scans)]
    truth = Truth(read_tum(truth_file))
    poses = [truth.pose(scan.stamp_s) for scan in scans]
    if None in poses:
        raise Failure(2, f"{truth_file}: expected a pose at every scan, found none at {scans[poses.index(None)].stamp_s:.6f}")
    if not scans[0].range_max_m > 0:
        raise Failure(2, f"{log}: expected a positive maximum range in the first scan, found {scans[0].range_max_m:g}")
    return Drive(grid, scans, poses)


def left_out_by_mrpt(scans, resolution_m):
    """Share of the hits that MRPT's field leaves out: those closer than half a cell to the one before that counts."""
    hits = kept = 0
    for scan in scans:
        last = None
        for i, r in enumerate(scan.ranges_m):
            if not mrpt.SHORTEST_M <= r < scan.range_max_m:
                continue
            angle = scan.angle_min_rad + i * scan.angle_step_rad
            point = r * math.cos(angle), r * math.sin(angle)
            hits += 1
            if last is None or math.dist(point, last) >= resolution_m / 2:
                kept, last = kept + 1, point
    return 1 - kept / hits if hits else 0.0


def write_inputs(drive, particles, work):
    """One folder with all that the programs read."""
    range_max_m = drive.scans[0].range_max_m
    write_map(work / "map.yaml", drive.grid, decimals=9)
    (work / "scans.log").write_text("".join(map(carmen_text, drive.scans)))
    (work / "truth.txt").write_text(mrpt.ground_truth(drive.scans, drive.poses))
    for row in ROWS:
        if row.model:
            (work / f"{row.model}.yaml").write_text(parloc_config(row.model, range_max_m))
            continue
        likelihood = mrpt_likelihood(row, range_max_m)
        rays = row.group == "ray"
        (work / f"{row.key}.gridmap").write_bytes(mrpt.gridmap(drive.grid, likelihood))
        # A field knows no missing returns, and parloc's leaves them out too.
        (work / f"{row.key}.rawlog").write_bytes(mrpt.rawlog(drive.scans, MOTION, misses_count=rays,
                                                             range_max_m=told_range_m(range_max_m)))
        (work / f"{row.key}.ini").write_text(mrpt.ini(
            work, row.key, particles, drive.poses[0], START_SIGMA_M, START_SIGMA_RAD, 1 if rays else FIELD_TEMPERING,
            likelihood, drive.grid.resolution_m))
