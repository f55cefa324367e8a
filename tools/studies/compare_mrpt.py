#!/usr/bin/env python3
"""Runs MRPT's pf-localization and `parloc run` by turns on the same log, and writes a page (Markdown) with all values beside
it (JSON): time of a filter step, and position error.

    sudo apt-get install mrpt-apps
    tools/studies/compare_mrpt.py                                   a simulated log: some minutes
    tools/studies/compare_mrpt.py --map M.yaml --log LOG --truth T.tum

Needs pf-localization of MRPT 2; nothing else here needs MRPT.
"""

import json
import math
import os
import re
import resource
import shutil
import statistics
import sys
import time

import measuring
import mrpt_setup as models
from accuracy import PAPER_MAP, PAPER_SCENARIO
from logs import read_tum
from measuring import Failure, Program, count, option, path
from mrpt_files import MARGIN_CELLS
from mrpt_setup import ROWS, START_SIGMA_M, START_SIGMA_RAD, left_out_by_mrpt, read_drive, told_range_m, write_inputs
from pages import CIRCUMSTANCES, circumstances, circumstances_text, table_of, write_results

TIMEOUT_S = 900


# ---- Running the programs ----------------------------------------------------------------------------------------------


def children_s():
    """Of CPU time, by all programs that have ended."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def run_program(program, *arguments, environment=None):
    """Its output, and how many cores it kept busy on average."""
    worked_s, begun = children_s(), time.monotonic()
    out = program(*arguments, environment=environment)
    return out, round((children_s() - worked_s) / (time.monotonic() - begun), 2)


def errors_of(path, poses):
    """Mean and maximum of the position error, the first scan left out: MRPT takes no step there."""
    errors = [math.hypot(x - true[0], y - true[1]) for (x, y), true in zip(path, poses, strict=True)][1:]
    return {"mean_m": statistics.fmean(errors), "max_m": max(errors)}


def nearest_rank(values, share):
    return sorted(values)[math.ceil(share * len(values)) - 1]


MRPT_POSE = re.compile(r"PDF estimation: \(([-\d.e+]+),([-\d.e+]+),[-\d.e+]+deg\)")
MRPT_ESS = re.compile(r"Done in [\d.]+ms, ESS=([\d.]+)")


MRPT_ONLY = ("first_ms", "ess_after_resampling")


def run_mrpt(program, particles, row, drive, work):
    folder = work / f"{row.key}_000_{particles:07}"
    shutil.rmtree(folder, ignore_errors=True)
    out, busy = run_program(program, work / f"{row.key}.ini")
    path = [(float(x), float(y)) for x, y in MRPT_POSE.findall(out)]
    try:
        step_s = [float(value) for value in (folder / "exec_times.txt").read_text().split()]
        spread_m = [float(value) for value in (folder / "GT_error.txt").read_text().split()]
    except (OSError, ValueError) as error:
        raise Failure(3, f"{row.key}: expected MRPT's step times and errors: {error}") from None
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


def run_parloc(program, particles, row, drive, work, seed):
    start = ",".join(f"{v:.9f}" for v in (*drive.poses[0], START_SIGMA_M, START_SIGMA_M, START_SIGMA_RAD))
    out, busy = run_program(
        program, "run", "--map", work / "map.yaml", "--log", work / "scans.log", "--config", work / f"{row.model}.yaml",
        f"--init={start}", "--particles", particles, "--beams", len(drive.scans[0].ranges_m), "--seed", seed,
        "--backend", "cpu", "--threads", row.threads, "--json", "--quiet", "--out", work / "parloc",
        environment={"PARLOC_SIMD": row.simd} if row.simd else None)
    metrics = json.loads(out)
    path = [(x, y) for _, x, y, _ in read_tum(work / "parloc/trajectory.tum")]
    if len(path) != len(drive.scans):
        raise Failure(3, f"{row.key}: expected {len(drive.scans)} poses of parloc, found {len(path)}")
    return {"median_ms": metrics["step_ms_median"], "p99_ms": metrics["step_ms_p99"], **errors_of(path, drive.poses),
            "cores_busy": busy, "digest": metrics["digest"], "backend": metrics["backend"]}


def measure(bench, drive):
    """Rounds of one run per row, one right after the other: [{row key: values}], and how it ended."""
    particles, pf_localization = bench.args.particles, Program(bench.args.pf_localization, TIMEOUT_S)

    def one_run(bench, number, row):
        if row.model:
            return run_parloc(bench.program, particles, row, drive, bench.folder, number)
        return run_mrpt(pf_localization, particles, row, drive, bench.folder)

    keys = [(number, row) for number in range(1, bench.args.repeats + 1) for row in ROWS]
    results, end = bench.measure(one_run, keys, lambda key, run: (
        f"round {key[0]}, {key[1].key}: {run['median_ms']:.3f} ms per step, mean error {100 * run['mean_m']:.2f} cm"),
        pf_localization)
    whole = len(results) // len(ROWS)
    if not whole:
        raise end
    return [{row.key: results[number, row] for row in ROWS} for number in range(1, whole + 1)], end


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
        kept = ["median_ms", "p99_ms", "mean_m", "max_m", "cores_busy", *([] if row.model else MRPT_ONLY)]
        record = {"row": row.key, "threads": row.threads, "backend": runs[0]["backend"],
                  **{key: [run[key] for run in runs] for key in kept}}
        if row.model:
            record["times_faster_than_mrpt"] = [
                values[f"mrpt_{row.group}"]["median_ms"] / values[row.key]["median_ms"] for values in rounds]
        result.append(record)
    return result


def results_table(records):
    """`records` by key of their row."""
    return table_of(({"text": row.text, **records[row.key]} for row in ROWS), {
        "program and model": lambda r: r["text"], "threads": lambda r: str(r["threads"]),
        "ms per step": lambda r: spread(r["median_ms"], milliseconds),
        "p99": lambda r: milliseconds(statistics.median(r["p99_ms"])),
        "times faster": lambda r: spread(r["times_faster_than_mrpt"], times) if "times_faster_than_mrpt" in r else "",
        "mean error": lambda r: f"{100 * statistics.fmean(r['mean_m']):.2f}",
        "maximum": lambda r: f"{100 * max(r['max_m']):.1f}"})


def page(record):
    rows, setup = {run["row"]: run for run in record["runs"]}, record["setup"]
    partial = f"**Partial: ended after {setup['rounds']} rounds ({record['ended_by']}).** " if record["partial"] else ""
    mrpt, range_m = rows["mrpt_ray"]["backend"], setup["range"]
    busy = spread([v for key in ("mrpt_ray", "mrpt_field") for v in rows[key]["cores_busy"]], lambda v: f"{v:.2f}")
    ess = spread([v for run in rows.values() for v in run.get("ess_after_resampling", [])], lambda v: f"{v:.2f}")
    keys = list(CIRCUMSTANCES)
    keys[-1:] = "load", keys[-1]
    keys.insert(keys.index("compiler"), "mrpt")
    return f"""# parloc beside MRPT

{partial}MRPT's `pf-localization` ({mrpt}) and `parloc run` on the same log, map, start, number of particles and beams, by turns in one run.
{setup["particles"]} particles x {setup["beams"]} beams, {setup["scans"]} scans of {setup["log"]}; {setup["rounds"]} rounds.

{results_table(rows)}

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
parloc took what this CPU has: {rows["gaussian_1"]["backend"]}.

## What is the same

- The log, its odometry and its beams: every beam is used.
- The map, cell by cell, with a margin of {MARGIN_CELLS} unknown cells: at the very edge of a map MRPT's field is off.
- Resampling in every step, systematic, and a fixed number of particles. The estimate is the mean of all particles.
- `beam` with MRPT's likelihood: of a hit {models.MRPT_RAY_HIT:g} exp(-d^2 / 2 sigma^2) + {models.MRPT_RAY_FLOOR_M / told_range_m(range_m):g}, sigma {models.SIGMA_M} m, the product over the beams. parloc's shares
  (`z_hit` and so on) are chosen to be that, up to a factor.
- The likelihood field: sigma {models.SIGMA_M} m, distance to a wall up to {models.FIELD_CAP_M} m, the value of the nearest cell, weights to the power of {models.FIELD_TEMPERING}. A field pulls
  hits to the middle of a wall's cells, though they lie on its face; so its errors are larger than those of rays, in both programs.

## What is not

- **Rays.** MRPT marches in steps of {models.MRPT_RAY_STEP_CELLS} cells: its ranges are multiples of {100 * models.MRPT_RAY_STEP_CELLS * setup["resolution_m"]:g} cm, too long by up to that. parloc's are exact. MRPT's
  rays end after as many steps as the maximum range has cells; so it was told {told_range_m(range_m):g} m, to reach the true {range_m:g} m.
- **Missing returns** (no wall within {range_m:g} m). MRPT compares {range_m:g} m with the range that it expects. parloc's `gaussian` does the
  same, its `beam` takes the probability of no return. In both fields they are left out.
- **Hits left out.** MRPT's field skips a hit within half a cell of the one before: {setup["left_out"]:.1%} of this log's hits.
- **`gaussian`** is the model of Paz et al. 2012, which has no floor. parloc gives up a particle once its weight is certain to be zero, and
  a sharper likelihood does so sooner: hence this row is faster than `beam`.
- **Motion noise.** parloc: turn, drive, turn, each with its noise (alpha {", ".join(map(str, models.ALPHAS))}). MRPT: one Gaussian, as wide across as along, with
  the same standard deviation along and about, and 0.1 mm and 0.0001 rad more.
- **Start.** parloc: Gaussian, {START_SIGMA_M} m and {START_SIGMA_RAD} rad. MRPT: uniform, with the same standard deviation. MRPT takes no step at the
  first scan, parloc does.
- **Weights after resampling** should be equal, an effective sample size of 1 in MRPT's output. It says {ess}: there, evidence counts more
  than once. Its errors are those of the program as it is.
- **Random numbers.** MRPT's seed is the time: its errors differ from run to run. parloc's seeds are the numbers of the rounds. MRPT's
  poses have 3 decimals.

{circumstances_text({**record, "mrpt": mrpt}, keys)}"""  # noqa: E501


# ---- Command line ------------------------------------------------------------------------------------------------------


def check(args):
    if len({args.map is None, args.log is None, args.truth is None}) > 1:
        raise Failure(2, "--map, --log and --truth belong together")
    if args.scans < 10 or args.beams < 2:
        raise Failure(2, "expected at least 10 --scans and 2 --beams")
    if not (found := shutil.which(args.pf_localization)):
        raise Failure(2, f"{args.pf_localization}: not found, it is a program of MRPT: apt-get install mrpt-apps")
    args.pf_localization = found


def compare(bench):
    args, bench.program.timeout_s = bench.args, TIMEOUT_S
    if args.keep:
        args.keep.mkdir(parents=True, exist_ok=True)
        bench.folder = args.keep
    facts = {**circumstances(bench.program), "load": f"{os.getloadavg()[0]:.1f} in the minute before"}
    drive, work = read_drive(bench), bench.folder
    write_inputs(drive, args.particles, work)
    rounds, end = measure(bench, drive)
    log = f"`{args.log.name}` on `{args.map.name}`" if args.log else f"`{PAPER_SCENARIO}` (a simulated drive) on `{PAPER_MAP}`"
    setup = {"particles": args.particles, "beams": len(drive.scans[0].ranges_m), "scans": len(drive.scans), "log": log,
             "rounds": len(rounds), "range": drive.scans[0].range_max_m, "resolution_m": drive.grid.resolution_m,
             "left_out": left_out_by_mrpt(drive.scans, drive.grid.resolution_m)}
    record = {"what": "mrpt", "partial": end is not None, "ended_by": str(end) if end else None, **facts, "setup": setup,
              "configs": {row.model: (work / f"{row.model}.yaml").read_text() for row in ROWS if row.model},
              "ini": {row.key: (work / f"{row.key}.ini").read_text().replace(f"{work}/", "") for row in ROWS if not row.model},
              "runs": summary(rounds)}
    return write_results(bench, "mrpt", record, page, end=end)


if __name__ == "__main__":
    sys.exit(measuring.study(__doc__, {compare: (
        count("--particles", 4000, "particles"), count("--beams", 200, "beams of a scan, at most"),
        count("--scans", 120, "scans from the start of the log, at least 10"), count("--repeats", 5, "rounds"),
        path("--map", None, "map_server YAML with a PGM", "FILE"),
        path("--log", None, "CARMEN log of ROBOTLASER1 messages, instead of a simulated one", "FILE"),
        path("--truth", None, "its true trajectory, TUM format", "FILE"),
        path("--keep", None, "keep the converted files and MRPT's output here"),
        option("--pf-localization", "pf-localization", "MRPT's program, found by PATH", metavar="FILE"))}, check))
