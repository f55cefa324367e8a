#!/usr/bin/env python3
"""Maps the recorded logs with `parloc slam` and writes a page (Markdown) with all values beside it (JSON).

    tools/slam_logs.py [--seeds N] [--proposals P ...] [--particles N ...] [--jobs K] [--out DIR] [--parloc FILE]

Every log that has relations, every proposal, every seed; the relation error is that of Kuemmerle et al. 2009. Needs Python 3.10, a
built program and the folder of the logs (PARLOC_DATA, else ../shared/data).

Exit code: 0 all bars kept, 1 a bar missed, 2 wrong usage or a missing file, 3 a run of parloc failed, 130 interrupted.
"""

import argparse
import json
import math
import statistics
import sys

import measuring
from measuring import DATA, table

# Kuemmerle et al. 2009, translation [m]: scan matching, RBPF with 50 particles, graph mapping; a secondary tabulation.
PUBLISHED = {"intel": (0.220, 0.070, 0.031), "aces": (0.173, 0.060, 0.044)}
RANGES = {"intel": 80, "aces": 50}  # the logs do not say their longest range [m]
SEEDS_KEPT = 0.8  # of the seeds must keep the published figure of RBPF ...
BAR_PARTICLES = 30  # ... with so many particles
TIME_BAR_S = 90  # Intel, with those


def one_run(program, work, log, proposal, particles, seed):
    name = f"{log}_{proposal}_{particles}_{seed}"
    config = work / f"{name}.yaml"
    config.write_text(f"scan: {{laser_max_range: {RANGES[log]}}}\n")
    m = json.loads(program("slam", "--log", DATA / log / "scans.log", "--relations", DATA / log / "relations.txt", "--config", config,
                           "--proposal", proposal, "--particles", particles, "--seed", seed, "--out", work / name, "--json"))
    r = m["relations"]
    distinct = m["distinct_ancestors"]
    return {"log": log, "proposal": proposal, "particles": particles, "seed": seed,
            "translation_mean_m": r["translation_mean_m"], "translation_std_m": r["translation_std_m"],
            "rotation_mean_deg": math.degrees(r["rotation_mean_rad"]), "compared": r["compared"],
            "taken_in": m["scans_taken_in"], "resampled": m["resampled"],
            "single_ancestor": sum(1 for n in distinct if n == 1), "most_tile_mib": m["memory"]["most_tile_bytes"] / 2**20,
            "table_mib": m["memory"]["table_bytes"] / 2**20, "wall_s": m["wall_s"], "digest": m["digest"],
            "backend": m["backend"], "config": m["config"]}


def text_of(key, run):
    return f"{' '.join(map(str, key))}: {run['translation_mean_m']:.4f} m, {run['wall_s']:.0f} s"


def groups(runs):
    keys = dict.fromkeys((r["log"], r["proposal"], r["particles"]) for r in runs)
    return [(key, [r for r in runs if (r["log"], r["proposal"], r["particles"]) == key]) for key in keys]


def judged(runs):
    """[(what, figures, holds)] of the default proposal."""
    bars = []
    for (log, proposal, particles), some in groups(runs):
        if proposal != "scan_match" or particles != BAR_PARTICLES:
            continue
        rbpf, graph = PUBLISHED[log][1:]
        good = sum(r["translation_mean_m"] <= rbpf for r in some)
        aim = sum(r["translation_mean_m"] <= graph for r in some)
        bars.append((f"{log}: at or under the published RBPF, {rbpf:.3f} m, with {particles} particles on 4 of 5 seeds",
                     f"{good} of {len(some)} (the aim, graph mapping's {graph:.3f} m: {aim} of {len(some)})",
                     good >= SEEDS_KEPT * len(some)))
        if log == "intel":
            slowest = max(r["wall_s"] for r in some)
            bars.append((f"{log}: {particles} particles in under {TIME_BAR_S} s", f"{slowest:.0f} s at most", slowest < TIME_BAR_S))
    return bars


def mean_text(some, key, digits=3):
    values = [r[key] for r in some]
    spread = f" ({min(values):.{digits}f} to {max(values):.{digits}f})" if len(values) > 1 else ""
    return f"{statistics.mean(values):.{digits}f}{spread}"


def page(record):
    runs = record["runs"]
    text = "# Maps from recorded logs\n\nHow it works: [slam](../slam.md).\n"
    if record["partial"]:
        text += f"\n**Partial: {record['ended_by']}.**\n"
    text += "\n" + table(("bar", "measured", ""), [(a, b, "kept" if c else "**missed**") for a, b, c in judged(runs)]) + "\n"
    text += ("\nRelation error (mean over the relations; mean over the seeds and, in brackets, from best to worst), and what it took. "
             "\"One way\": scans from the start on for which all particles of the end have the same way.\n\n")
    rows = [(log, proposal, str(particles), str(len(some)), mean_text(some, "translation_mean_m", 4),
             mean_text(some, "rotation_mean_deg", 2), mean_text(some, "resampled", 0), mean_text(some, "single_ancestor", 0),
             str(some[0]["taken_in"]), mean_text(some, "most_tile_mib", 0), mean_text(some, "wall_s", 0))
            for (log, proposal, particles), some in groups(runs)]
    text += table(("log", "proposal", "particles", "seeds", "translation [m]", "rotation [deg]", "resampled", "one way", "scans taken in",
                   "tiles [MiB]", "time [s]"), rows)
    text += "\n\nPublished (Kuemmerle et al. 2009, translation [m]; from a secondary tabulation):\n\n"
    text += table(("log", "scan matching", "RBPF, 50 particles", "graph mapping"),
                  [(log, *(f"{v:.3f}" for v in PUBLISHED[log])) for log in PUBLISHED])
    return text + "\n\n" + measuring.circumstances_text(record)


def run(args, program, work):
    missing = [DATA / log / name for log in PUBLISHED for name in ("scans.log", "relations.txt") if not (DATA / log / name).is_file()]
    if missing:
        raise measuring.Failure(2, f"{missing[0]}: expected this file; PARLOC_DATA names the folder of the logs")
    keys = [(log, proposal, particles, seed) for log in PUBLISHED for proposal in args.proposals for particles in args.particles
            for seed in range(1, args.seeds + 1)]
    tasks = [(key, lambda key=key: one_run(program, work, *key)) for key in keys]
    results, end = measuring.measure(program, args.jobs, tasks, text_of)
    runs = list(results.values())
    code = measuring.finish(args, "slam", measuring.circumstances(program), len(keys), results, end, page)
    return code or (0 if all(holds for _, _, holds in judged(runs)) else 1)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=measuring.positive, default=5, metavar="N", help="from 1 on (5)")
    parser.add_argument("--proposals", nargs="+", default=["scan_match"], metavar="P", help="(scan_match)")
    parser.add_argument("--particles", nargs="+", type=measuring.positive, default=[30], metavar="N", help="(30)")
    measuring.add_arguments(parser)
    args = measuring.parse(parser)
    return measuring.run_tool("slam", args, lambda *all_of: run(*all_of))


if __name__ == "__main__":
    sys.exit(main())
