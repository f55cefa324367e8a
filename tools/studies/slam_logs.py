#!/usr/bin/env python3
"""Maps the recorded logs with `parloc slam` and writes a page (Markdown) with all values beside it (JSON).

Every log that has relations, by parts: what the bars ask for; few particles; no odometry; and of particles alone, without
loops that are closed afterwards: the proposals, resampling only when it is needed or at every scan, few with a wide search,
many. The relation error is that of Kuemmerle et al. 2009. PARLOC_DATA names the folder of the logs, else ../shared/data.
"""

import json
import math
import resource
import sys

import measuring
from measuring import DATA, JOBS, Failure, count, option, subset
from pages import bars_table, circumstances_text, mean, study, table, table_of_groups, where
from runs import yaml_text

# Kuemmerle et al. 2009, translation [m]: scan matching, RBPF with 50 particles, graph mapping; a secondary tabulation.
PUBLISHED = {"intel": (0.220, 0.070, 0.031), "aces": (0.173, 0.060, 0.044)}
RANGES = {"intel": 80, "aces": 50}  # the logs do not say their longest range [m]
SEEDS_KEPT = 0.8  # of the seeds must keep the published figure of RBPF ...
TIME_BAR_S = 90  # Intel, with 30 particles
MEMORY_BAR_MIB, MEMORY_PARTICLES = 4096, 1000

SEARCH = {"search_xy": 0.5, "search_theta": 0.2}  # [m, rad]
OPEN = {"close_loops": False}  # what the particles alone make of it


def particles(*numbers, **settings):
    return {f"{n} particle{'s' * (n > 1)}": {"particles": n, **settings} for n in numbers}


# By part: title, seeds (0: as many as are asked for), and its variations: a name and settings of `slam:`. 30 particles,
# scan_match, resampling by N_eff, and loops that are closed afterwards are the defaults.
PARTS = {
    "bars": ("30 particles", 0, {"": {}}),
    "few": ("Few particles", 3, particles(1, 2, 4)),
    "scans": ("No odometry: from the scans alone", 3,
              {"30 particles": {"odometry": "scans"}, "1 particle": {"odometry": "scans", "particles": 1}}),
    "proposals": ("Proposals: 30 particles alone", 0,
                  {name: {"proposal": name, **OPEN} for name in ("motion", "scan_match", "gaussian")}),
    "resampling": ("Resampling: 30 particles alone", 0,
                   {"N_eff < N / 2": OPEN, "every scan": {"resample_threshold": 1, **OPEN}}),
    "search": ("Few particles alone, with and without a wide search (0.5 m, 0.2 rad)", 3,
               {f"{name}{text}": {**settings, **more} for name, settings in particles(1, 2, 4, **OPEN).items()
                for text, more in (("", {}), (", search", SEARCH))}),
    "scans_alone": ("No odometry: from the scans alone, 30 particles alone", 3, {"scans": {"odometry": "scans", **OPEN}}),
    "many": ("Many particles alone", 1, particles(30, 100, 300, MEMORY_PARTICLES, **OPEN)),
}


def worked_s():
    """Of all programs that have ended."""
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime


def one_run(bench, log, settings, seed):
    worked_before_s = worked_s()
    out = bench.folder / f"{log}_{'_'.join(f'{k}_{v}' for k, v in settings)}_{seed}"
    config = out.with_name(f"{out.name}.yaml")
    config.write_text(yaml_text({"scan": {"laser_max_range": RANGES[log]}, "slam": dict(settings)}))
    m = json.loads(bench.program("slam", "--log", DATA / log / "scans.log", "--relations", DATA / log / "relations.txt",
                                 "--config", config, "--seed", seed, "--out", out, "--json"))
    r = m["relations"]
    return {"log": log, "settings": dict(settings), "seed": seed, "particles": dict(settings).get("particles", 30),
            "translation_mean_m": r["translation_mean_m"], "translation_std_m": r["translation_std_m"],
            "rotation_mean_deg": math.degrees(r["rotation_mean_rad"]), "compared": r["compared"],
            "taken_in": m["scans_taken_in"], "resampled": m["resampled"], "n_eff_mean": m["n_eff"]["mean"],
            "ancestors_half": m["ancestors_at_quarters"][2], "single_ancestor": m["distinct_ancestors"].count(1),
            "most_tile_mib": m["memory"]["most_tile_bytes"] / 2**20, "table_mib": m["memory"]["table_bytes"] / 2**20,
            "resident_mib": m["memory"]["resident_bytes"] / 2**20,
            "wall_s": m["wall_s"], "cpu_s": worked_s() - worked_before_s, "real_time_factor": m["real_time_factor"],
            "digest": m["digest"], "backend": m["backend"], "config": m["config"]}


def text_of(key, run):
    log, settings, seed = key
    what = ' '.join(f'{k}={v}' for k, v in settings) or 'defaults'
    return f"{log} {what} seed {seed}: {run['translation_mean_m']:.4f} m, {run['wall_s']:.0f} s"


def variation(runs, log, settings, seeds):
    return [run for run in where(runs, log=log, settings=settings) if run["seed"] <= seeds]


def judged(record):
    """[(what, figures, holds)]"""
    bars = []
    for log, (_, rbpf, graph) in PUBLISHED.items():
        if some := variation(record["runs"], log, {}, record["seeds"]):
            good = sum(r["translation_mean_m"] <= rbpf for r in some)
            aim = sum(r["translation_mean_m"] <= graph for r in some)
            bars.append((f"{log}: at or under the published RBPF, {rbpf:.3f} m, with 30 particles on 4 of 5 seeds",
                         f"{good} of {len(some)} (the aim, graph mapping's {graph:.3f} m: {aim} of {len(some)})",
                         good >= SEEDS_KEPT * len(some)))
            if log == "intel":
                slowest = max(r["wall_s"] for r in some)
                bars.append((f"{log}: 30 particles in under {TIME_BAR_S} s", f"{slowest:.0f} s at most", slowest < TIME_BAR_S))
        for r in variation(record["runs"], log, {"particles": MEMORY_PARTICLES, **OPEN}, 1):
            mib = r["resident_mib"]
            bars.append((f"{log}: {MEMORY_PARTICLES} particles in {MEMORY_BAR_MIB} MiB", f"{mib:.0f} MiB, the whole program",
                         mib <= MEMORY_BAR_MIB))
    return bars


def mean_text(key, digits):
    """The column of a value: its mean and, of several runs, from the least to the most."""
    def text(runs):
        values = [run[key] for run in runs]
        spread = f" ({min(values):.{digits}f} to {max(values):.{digits}f})" if len(values) > 1 else ""
        return f"{mean(runs, key):.{digits}f}{spread}"
    return text


COLUMNS = {
    "seeds": lambda runs: str(len(runs)),
    "translation [m]": mean_text("translation_mean_m", 4), "rotation [deg]": mean_text("rotation_mean_deg", 2),
    "resampled": mean_text("resampled", 0), "N_eff": mean_text("n_eff_mean", 1),
    "ancestors half way": mean_text("ancestors_half", 1), "one way": mean_text("single_ancestor", 0),
    "tiles [MiB]": mean_text("most_tile_mib", 0), "tables [MiB]": mean_text("table_mib", 1),
    "resident [MiB]": mean_text("resident_mib", 0), "time [s]": mean_text("wall_s", 0), "of a core [s]": mean_text("cpu_s", 0),
}


def part_table(record, part):
    _, most, variations = PARTS[part]
    groups = {(log, name): some for log in PUBLISHED for name, settings in variations.items()
              if (some := variation(record["runs"], log, settings, most or record["seeds"]))}
    return table_of_groups(("log", ""), groups, COLUMNS) if groups else "Not measured."


def page(record):
    partial = f"\n**Partial: {record['ended_by']}.**\n" if record["partial"] else ""
    parts = "".join(f"\n## {PARTS[part][0]}\n\n{part_table(record, part)}\n" for part in record["parts"])
    published = [(log, *(f"{figure:.3f}" for figure in figures)) for log, figures in PUBLISHED.items()]
    return f"""# Maps from recorded logs

How it works: [slam](../slam.md).
{partial}
{bars_table(judged(record))}

Relation error: mean over the relations; mean over the seeds and, in brackets, from best to worst. "Ancestors half way": how \
many poses of the scan in the middle the particles of the end go back to. "One way": scans from the start on for which that \
is one. 2580 scans are taken in of Intel, 1279 of ACES. Times are of both cores, and the sum of what they worked.
{parts}
## Published

Kuemmerle et al. 2009, translation [m]; from a secondary tabulation:

{table(("log", "scan matching", "RBPF, 50 particles", "graph mapping"), published)}

{circumstances_text(record)}"""


def run(bench):
    args = bench.args
    needed = [DATA / log / name for log in PUBLISHED for name in ("scans.log", "relations.txt")]
    if missing := [path for path in needed if not path.is_file()]:
        raise Failure(2, f"{missing[0]}: expected this file; PARLOC_DATA names the folder of the logs")
    keys = [(log, tuple(settings.items()), seed) for part in args.parts for log in args.logs
            for settings in PARTS[part][2].values() for seed in range(1, (PARTS[part][1] or args.seeds) + 1)]
    if args.jobs > 1:
        print("slam_logs.py: with several runs at a time none has its own time", file=sys.stderr)
    return study(bench, args.name, one_run, keys, text_of, page, parts=args.parts, seeds=args.seeds,
                 holds=lambda record: all(kept for _, _, kept in judged(record)))


if __name__ == "__main__":
    sys.exit(measuring.study(__doc__, {run: (
        subset("--parts", PARTS, "what to run", "P"), subset("--logs", PUBLISHED, "on which", "L"),
        count("--seeds", 5, "from 1 on"), option("--name", "slam", "of the page and its JSON", metavar="PAGE"), JOBS)}))
