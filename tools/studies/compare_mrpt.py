#!/usr/bin/env python3
"""Runs MRPT's pf-localization and `parloc run` by turns on the same log, and writes a page (Markdown) with all values beside it
(JSON): time of a filter step, and position error.

    sudo apt-get install mrpt-apps
    tools/studies/compare_mrpt.py                                   a simulated log: some minutes
    tools/studies/compare_mrpt.py --map M.yaml --log LOG --truth T.tum

Needs Python 3.10, a built program, and pf-localization of MRPT 2; nothing else here needs MRPT. An interrupted comparison (Ctrl-C)
writes the rounds that it has as mrpt.partial.* and leaves the page of an earlier one alone.

Exit code: 0 done, 2 wrong usage or a missing or broken file, 3 a run of a program failed, 130 interrupted.
"""

import argparse
import json
import math
import os
import pathlib
import re
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass

import mrpt_files as mrpt
from accuracy import PAPER_MAP, PAPER_SCENARIO
from measuring import OUT, ROOT, Failure, circumstances, parse, positive, program_and_folder, reported, table, write_results
from track_errors import Truth, read_tum

SIGMA_M = 0.1  # of all models
START_SIGMA_M, START_SIGMA_RAD = 0.05, 0.03
ALPHAS = (0.1, 0.05, 0.1, 0.02)  # parloc's motion noise, as configs/paz2012.yaml has it
MOTION = mrpt.Motion(ALPHAS[2], ALPHAS[3], math.sqrt(2) * ALPHAS[1], ALPHAS[0], 1e-4, 1e-4)
FIELD_CAP_M, FIELD_HIT, FIELD_RANDOM, FIELD_TEMPERING = 2.0, 0.9, 0.1, 0.1  # parloc's defaults
MRPT_RAY_STEP_CELLS = 0.8
MRPT_RAY_HIT, MRPT_RAY_FLOOR_M = 0.9, 0.1  # likelihood 0.9 exp(-d^2 / 2 sigma^2) + 0.1 m / maximum range
TIMEOUT_S = 900


# ---- What is compared --------------------------------------------------------------------------------------------------


@dataclass
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
    groups = {"motion": {"form": "seed", **{f"alpha{i}": alpha for i, alpha in enumerate(ALPHAS, 1)}},
              "sensor": {**sensor, "sigma_hit": SIGMA_M}, "resample": {"scheme": "systematic", "threshold": 1.0},
              "estimate": {"mode": "mean"}}
    return "".join(f"{group}:\n" + "".join(f"  {key}: {value}\n" for key, value in keys.items())
                   for group, keys in groups.items())


def mrpt_likelihood(row, range_max_m):
    if row.group == "ray":
        return mrpt.Likelihood(mrpt.RAY_TRACING, SIGMA_M)
    return mrpt.Likelihood(mrpt.LIKELIHOOD_FIELD, SIGMA_M, FIELD_HIT * peak_of_density(), FIELD_RANDOM, range_max_m,
                           FIELD_CAP_M)


# ---- The log -----------------------------------------------------------------------------------------------------------


def scenario_with(beams):
    """The paper's scenario with exactly so many beams over the same angle, and file names that hold from anywhere."""
    text = (ROOT / PAPER_SCENARIO).read_text()
    home = (ROOT / PAPER_SCENARIO).parent
    step_deg = 270 / (beams - 1)
    for pattern, new in ((r"(^ *beams:) *\d+", rf"\1 {beams}"), (r"(^ *angle_step_deg:) *[\d.]+", rf"\1 {step_deg:.12g}"),
                         (r"(^(?:map|localization_map|path):) *(\S+)", rf"\1 {home}/\2")):
        text, count = re.subn(pattern, new, text, flags=re.MULTILINE)
        if count == 0:
            raise Failure(2, f"{home / PAPER_SCENARIO}: expected a line like {pattern}")
    return text


def take_log(args, program, work):
    """Files of the map, the log, and the truth."""
    if args.log:
        return args.map, args.log, args.truth
    (work / "scenario.yaml").write_text(scenario_with(args.beams))
    program("simulate", "--scenario", work / "scenario.yaml", "--out", work / "simulated", "--quiet")
    return ROOT / PAPER_MAP, work / "simulated/scans.log", work / "simulated/truth.tum"


@dataclass
class Drive:
    """What both programs get."""

    grid: mrpt.Grid
    scans: list
    poses: list  # the true ones: x, y [m], heading [rad]


def read_drive(args, program, work):
    map_file, log, truth_file = take_log(args, program, work)
    grid = mrpt.with_margin(mrpt.read_map(map_file))
    scans = [mrpt.thinned(scan, args.beams) for scan in mrpt.read_log(log, args.scans)]
    try:
        rows = read_tum(truth_file)
    except (OSError, UnicodeDecodeError) as error:
        raise Failure(2, f"{truth_file}: expected the true trajectory: {error}")
    truth = Truth(rows)
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
    map_yaml, map_image = mrpt.map_server_files(drive.grid, "map.pgm")
    (work / "map.yaml").write_text(map_yaml)
    (work / "map.pgm").write_bytes(map_image)
    (work / "scans.log").write_text("".join(map(mrpt.carmen_text, drive.scans)))
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


# ---- Running the programs ----------------------------------------------------------------------------------------------


def run_program(command, environment=None):
    """Its output, and how many cores it kept busy on average."""
    before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    try:
        done = subprocess.run(list(map(str, command)), stdin=subprocess.DEVNULL, capture_output=True, text=True, cwd=ROOT,
                              errors="replace", timeout=TIMEOUT_S, env={**os.environ, **(environment or {})})
    except subprocess.TimeoutExpired:
        raise Failure(3, f"{command[0]} took longer than {TIMEOUT_S} s; give fewer --scans or --particles")
    wall_s, after = time.monotonic() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode != 0:
        message = re.search(r"Message:\s*(.+)", done.stdout + done.stderr)
        last = message[1] if message else (done.stderr.strip().splitlines() or ["no message"])[-1]
        raise Failure(3, f"exit code {done.returncode} of {' '.join(map(str, command))}: {last}")
    return done.stdout, (after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime) / wall_s


def errors_of(path, poses):
    """Mean and maximum of the position error, the first scan left out: MRPT takes no step there."""
    errors = [math.hypot(x - true[0], y - true[1]) for (x, y), true in zip(path, poses)][1:]
    return {"mean_m": statistics.fmean(errors), "max_m": max(errors)}


def nearest_rank(values, share):
    return sorted(values)[math.ceil(share * len(values)) - 1]


MRPT_POSE = re.compile(r"PDF estimation: \(([-\d.e+]+),([-\d.e+]+),[-\d.e+]+deg\)")
MRPT_ESS = re.compile(r"Done in [\d.]+ms, ESS=([\d.]+)")


def run_mrpt(args, row, drive, work):
    folder = work / f"{row.key}_000_{args.particles:07}"
    shutil.rmtree(folder, ignore_errors=True)
    out, busy = run_program([args.pf_localization, work / f"{row.key}.ini"])
    path = [(float(x), float(y)) for x, y in MRPT_POSE.findall(out)]
    try:
        step_s = [float(value) for value in (folder / "exec_times.txt").read_text().split()]
        spread_m = [float(value) for value in (folder / "GT_error.txt").read_text().split()]
    except (OSError, ValueError) as error:
        raise Failure(3, f"{row.key}: expected MRPT's step times and errors: {error}")
    if len(path) != len(drive.scans) or len(step_s) != len(path) - 1:
        raise Failure(3, f"{row.key}: expected {len(drive.scans)} poses of MRPT, found {len(path)} and {len(step_s)} steps")
    errors = errors_of(path, drive.poses)
    # The mean distance of the particles, by MRPT itself, cannot be less than that of their mean (poses have 3 decimals). MRPT
    # has no truth at scans that are more than 0.2 s from the next.
    if len(spread_m) == len(path) and not statistics.fmean(spread_m[1:]) > errors["mean_m"] - 0.001:
        raise Failure(3, f"{row.key}: MRPT says {statistics.fmean(spread_m[1:]):.4f} m to its truth, its poses say "
                         f"{errors['mean_m']:.4f} m")
    ms = [1e3 * s for s in step_s[1:]]
    version = re.search(r"MRPT (\d+\.\d+\.\d+)", out)
    return {"median_ms": statistics.median(ms), "p99_ms": nearest_rank(ms, 0.99), "first_ms": 1e3 * step_s[0], **errors,
            "cores_busy": busy, "ess_after_resampling": statistics.median(map(float, MRPT_ESS.findall(out))),
            "backend": f"MRPT {version[1]}" if version else "MRPT of unknown version"}


def run_parloc(args, row, drive, work, seed):
    start = ",".join(f"{v:.9f}" for v in (*drive.poses[0], START_SIGMA_M, START_SIGMA_M, START_SIGMA_RAD))
    out, busy = run_program(
        [args.parloc, "run", "--map", work / "map.yaml", "--log", work / "scans.log", "--config", work / f"{row.model}.yaml",
         f"--init={start}", "--particles", args.particles, "--beams", len(drive.scans[0].ranges_m), "--seed", seed,
         "--backend", "cpu", "--threads", row.threads, "--json", "--quiet", "--out", work / "parloc"],
        {"PARLOC_SIMD": row.simd} if row.simd else None)
    metrics = json.loads(out)
    path = [(x, y) for _, x, y, _ in read_tum(work / "parloc/trajectory.tum")]
    if len(path) != len(drive.scans):
        raise Failure(3, f"{row.key}: expected {len(drive.scans)} poses of parloc, found {len(path)}")
    return {"median_ms": metrics["step_ms_median"], "p99_ms": metrics["step_ms_p99"], **errors_of(path, drive.poses),
            "cores_busy": busy, "digest": metrics["digest"], "backend": metrics["backend"]}


def measure(args, drive, work):
    """Rounds of one run per row, one right after the other: [{row key: values}], and how it ended."""
    rounds, end = [], None
    try:
        for number in range(1, args.repeats + 1):
            values = {}
            for row in ROWS:
                values[row.key] = (run_parloc(args, row, drive, work, number) if row.model
                                   else run_mrpt(args, row, drive, work))
                print(f"[{number}/{args.repeats}] {row.key}: {values[row.key]['median_ms']:.3f} ms per step, mean error "
                      f"{100 * values[row.key]['mean_m']:.2f} cm", file=sys.stderr, flush=True)
            rounds.append(values)
    except (KeyboardInterrupt, Failure) as stop:
        end = stop if isinstance(stop, Failure) else Failure(130, "interrupted")
        if not rounds:
            raise end
    return rounds, end


# ---- The page ----------------------------------------------------------------------------------------------------------


def spread(values, form):
    low, high = form(min(values)), form(max(values))
    middle = form(statistics.median(values))
    return middle if low == high else f"{middle} ({low} to {high})"


def times(ratio):
    return f"{ratio:.0f}" if ratio >= 100 else f"{ratio:.1f}"


def milliseconds(ms):
    return f"{ms:.1f}" if ms >= 100 else f"{ms:.3g}"


def summary(rounds):
    """One record per row. A ratio is that of two medians of the same round."""
    result = []
    for row in ROWS:
        runs = [values[row.key] for values in rounds]
        record = {"row": row.key, "threads": row.threads, "backend": runs[0]["backend"],
                  "median_ms": [run["median_ms"] for run in runs], "p99_ms": [run["p99_ms"] for run in runs],
                  "mean_m": [run["mean_m"] for run in runs], "max_m": [run["max_m"] for run in runs],
                  "cores_busy": [round(run["cores_busy"], 2) for run in runs]}
        if row.model:
            record["times_faster_than_mrpt"] = [
                values[f"mrpt_{row.group}"]["median_ms"] / values[row.key]["median_ms"] for values in rounds]
        else:
            record["first_ms"] = [run["first_ms"] for run in runs]
            record["ess_after_resampling"] = [run["ess_after_resampling"] for run in runs]
        result.append(record)
    return result


def table_row(row, record):
    return (row.text, str(row.threads), spread(record["median_ms"], milliseconds),
            milliseconds(statistics.median(record["p99_ms"])),
            spread(record["times_faster_than_mrpt"], times) if row.model else "",
            f"{100 * statistics.fmean(record['mean_m']):.2f}", f"{100 * max(record['max_m']):.1f}")


PAGE = """# parloc beside MRPT

{partial}MRPT's `pf-localization` ({mrpt}) and `parloc run` on the same log, map, start, number of particles and beams, by turns in one run.
{particles} particles x {beams} beams, {scans} scans of {log}; {rounds} rounds.

{table}

- **ms per step**: the median over the steps of a run; of that, the median over the rounds and, in brackets, the lowest and the
  highest. p99: 99 % of a run's steps are not slower, the median over the rounds.
- **times faster**: MRPT's row above, over this row, of the same round; again median and range.
- Errors are in cm: the distance between reported and true position, the first scan left out. Mean over all scans and rounds, and the
  worst of any.

## What is timed

Both programs time their own steps: MRPT's are those of its `exec_times.txt`, parloc's those of its `metrics.json`. Both are wall-clock
times of prediction, weighting of all particles and resampling. parloc's also hold the estimate, MRPT computes it after its step.
The first step of every run is left out (MRPT begins its table of the field in it). Reading files is in neither.

`pf-localization` works on one thread: it kept {busy} cores busy on average. Debian builds it for any x86-64. "Without AVX" is parloc limited
to the same (`PARLOC_SIMD=baseline`): its fused multiply-adds, which make its answers the same everywhere, are calls there. Otherwise
parloc took what this CPU has: {backend}.

## What is the same

- The log, its odometry and its beams: every beam is used.
- The map, cell by cell, with a margin of {margin} unknown cells: at the very edge of a map MRPT's field is off.
- Resampling in every step, systematic, and a fixed number of particles. The estimate is the mean of all particles.
- `beam` with MRPT's likelihood: of a hit {hit:g} exp(-d^2 / 2 sigma^2) + {floor:g}, sigma {sigma} m, the product over the beams. parloc's shares
  (`z_hit` and so on) are chosen to be that, up to a factor.
- The likelihood field: sigma {sigma} m, distance to a wall up to {cap} m, the value of the nearest cell, weights to the power of {tempering}. A field pulls
  hits to the middle of a wall's cells, though they lie on its face; so its errors are larger than those of rays, in both programs.

## What is not

- **Rays.** MRPT marches in steps of {step} cells: its ranges are multiples of {step_cm:g} cm, too long by up to that. parloc's are exact. MRPT's
  rays end after as many steps as the maximum range has cells; so it was told {told:g} m, to reach the true {range:g} m.
- **Missing returns** (no wall within {range:g} m). MRPT compares {range:g} m with the range that it expects. parloc's `gaussian` does the
  same, its `beam` takes the probability of no return. In both fields they are left out.
- **Hits left out.** MRPT's field skips a hit within half a cell of the one before: {left_out:.1%} of this log's hits.
- **`gaussian`** is the model of Paz et al. 2012, which has no floor. parloc gives up a particle once its weight is certain to be zero, and
  a sharper likelihood does so sooner: hence this row is faster than `beam`.
- **Motion noise.** parloc: turn, drive, turn, each with its noise (alpha {alphas}). MRPT: one Gaussian, as wide across as along, with
  the same standard deviation along and about, and 0.1 mm and 0.0001 rad more.
- **Start.** parloc: Gaussian, {start_m} m and {start_rad} rad. MRPT: uniform, with the same standard deviation. MRPT takes no step at the
  first scan, parloc does.
- **Weights after resampling** should be equal, an effective sample size of 1 in MRPT's output. It says {ess}: there, evidence counts more
  than once. Its errors are those of the program as it is.
- **Random numbers.** MRPT's seed is the time: its errors differ from run to run. parloc's seeds are the numbers of the rounds. MRPT's
  poses have 3 decimals.

"""


def page(record):
    rows, setup = {run["row"]: run for run in record["runs"]}, record["setup"]
    ess = spread([v for run in rows.values() for v in run.get("ess_after_resampling", [])], lambda v: f"{v:.2f}")
    text = PAGE.format(
        partial=f"**Partial: ended after {setup['rounds']} rounds ({record['ended_by']}).** " if record["partial"] else "",
        mrpt=rows["mrpt_ray"]["backend"], **setup, sigma=SIGMA_M, cap=FIELD_CAP_M, tempering=FIELD_TEMPERING,
        table=table(("program and model", "threads", "ms per step", "p99", "times faster", "mean error", "maximum"),
                    [table_row(row, rows[row.key]) for row in ROWS]),
        busy=spread([v for key in ("mrpt_ray", "mrpt_field") for v in rows[key]["cores_busy"]], lambda v: f"{v:.2f}"),
        backend=rows["gaussian_1"]["backend"], hit=MRPT_RAY_HIT, floor=MRPT_RAY_FLOOR_M / told_range_m(setup["range"]),
        step=MRPT_RAY_STEP_CELLS, step_cm=100 * MRPT_RAY_STEP_CELLS * setup["resolution_m"], told=told_range_m(setup["range"]),
        margin=mrpt.MARGIN_CELLS, alphas=", ".join(map(str, ALPHAS)), start_m=START_SIGMA_M, start_rad=START_SIGMA_RAD, ess=ess)
    keys = ("command", "date", "commit", "program", "mrpt", "compiler", "machine", "load", "system")
    facts = {**record, "mrpt": rows["mrpt_ray"]["backend"]}
    return text + "## Where and when\n\n" + table(
        ("", ""), [(key, f"`{facts[key]}`" if key == "command" else facts[key]) for key in keys])


# ---- Command line ------------------------------------------------------------------------------------------------------


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name, default, text in (("particles", 4000, "particles"), ("beams", 200, "beams of a scan, at most"),
                                ("scans", 120, "scans from the start of the log, at least 10"), ("repeats", 5, "rounds")):
        parser.add_argument(f"--{name}", type=positive, default=default, metavar="N", help=f"{text} ({default})")
    for name, text in (("map", "map_server YAML with a PGM"), ("log", "CARMEN log of ROBOTLASER1 messages, instead of a "
                       "simulated one"), ("truth", "its true trajectory, TUM format")):
        parser.add_argument(f"--{name}", type=pathlib.Path, metavar="FILE", help=text)
    parser.add_argument("--out", type=pathlib.Path, default=OUT, metavar="DIR", help="folder for the page (docs/results)")
    parser.add_argument("--keep", type=pathlib.Path, metavar="DIR", help="keep the converted files and MRPT's output here")
    parser.add_argument("--parloc", type=pathlib.Path, default=ROOT / "build/cpu/parloc", metavar="FILE",
                        help="the program (build/cpu/parloc)")
    parser.add_argument("--pf-localization", default="pf-localization", metavar="FILE", help="MRPT's program (found by PATH)")
    args = parse(parser)
    if len({args.map is None, args.log is None, args.truth is None}) > 1:
        parser.error("--map, --log and --truth belong together")
    if args.scans < 10 or args.beams < 2:
        parser.error("expected at least 10 --scans and 2 --beams")
    return args


def compare(args, work):
    if not (found := shutil.which(args.pf_localization)):
        raise Failure(2, f"{args.pf_localization}: not found, it is a program of MRPT: apt-get install mrpt-apps")
    args.pf_localization = found
    program = program_and_folder(args)
    facts = {**circumstances(program), "load": f"{os.getloadavg()[0]:.1f} in the minute before"}
    drive = read_drive(args, program, work)
    write_inputs(drive, args.particles, work)
    rounds, end = measure(args, drive, work)
    log = f"`{args.log.name}` on `{args.map.name}`" if args.log else f"`{PAPER_SCENARIO}` (a simulated drive) on `{PAPER_MAP}`"
    setup = {"particles": args.particles, "beams": len(drive.scans[0].ranges_m), "scans": len(drive.scans), "log": log,
             "rounds": len(rounds), "range": drive.scans[0].range_max_m, "resolution_m": drive.grid.resolution_m,
             "left_out": left_out_by_mrpt(drive.scans, drive.grid.resolution_m)}
    record = {"what": "mrpt", "partial": end is not None, "ended_by": str(end) if end else None, **facts, "setup": setup,
              "configs": {row.model: (work / f"{row.model}.yaml").read_text() for row in ROWS if row.model},
              "ini": {row.key: (work / f"{row.key}.ini").read_text().replace(f"{work}/", "") for row in ROWS if not row.model},
              "runs": summary(rounds)}
    write_results(args.out, "mrpt", record, page(record))
    if end:
        raise end
    return 0


def main():
    args = parse_arguments()

    def work():
        if args.keep:
            args.keep.mkdir(parents=True, exist_ok=True)
            return compare(args, args.keep)
        with tempfile.TemporaryDirectory(prefix="parloc_mrpt_") as folder:
            return compare(args, pathlib.Path(folder))
    return reported("compare_mrpt", work)


if __name__ == "__main__":
    sys.exit(main())
