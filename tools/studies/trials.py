#!/usr/bin/env python3
"""Runs `parloc evaluate` on every scene of docs/results/evaluate.md: its values (JSON), and the rows of its table on
standard output.

--share 0.1 runs a tenth of the trials. Real logs are left out, with a line that says so, where they are not found. Rows that
are finished are written in any case.
"""

import argparse
import json
import os
import sys

import measuring
from logs import RECORDED
from measuring import LOGS_FOLDER, count, option, path, subset
from pages import fixed
from runs import report_of

OFFICE, WORKS = "configs/office_scenario.yaml", "configs/works_scenario.yaml"
SCENES = {  # row: arguments, trials
    "office360": (["--scenario", OFFICE, "--range", 8], 1000),
    "works": (["--scenario", WORKS, "--range", 8], 300),
    "fov180": (["--scenario", OFFICE, "--range", 8, "--fov", 180], 200),
    "fov100": (["--scenario", OFFICE, "--range", 8, "--fov", 100], 200),
    "people": (["--scenario", "configs/office_people_scenario.yaml", "--range", 8], 200),
    "clutter": (["--scenario", "configs/office_clutter_scenario.yaml", "--range", 8], 200),
    "kidnap": (["--scenario", OFFICE, "--range", 8, "--task", "kidnap"], 200),
    "track": (["--scenario", OFFICE, "--range", 8, "--task", "track", "--duration", 60], 50),
}


def share_of(rate):
    return rate["hits"] / rate["of"]


# The bars of localizing without a start: row: (what, holds).
def at_least(key, least):
    return f"{key} >= {least}", lambda s: share_of(s[key]) >= least


def at_most(key, most):
    return f"{key} <= {most}", lambda s: share_of(s[key]) <= most


BARS = {
    "office360": [at_least("success", 0.99), at_most("confident_wrong", 0.002)],
    "works": [at_least("success", 0.97), at_most("confident_wrong", 0.002)],
    "fov180": [at_most("confident_wrong_1s", 0.01)],
    "fov100": [at_most("confident_wrong_1s", 0.01)],
    "people": [at_most("confident_wrong_1s", 0.01)],
    "kidnap": [at_least("success", 0.97), at_least("noticed", 0.97),
               ("AUC >= 0.98", lambda s: s["calibration"]["auc"] >= 0.98),
               ("false lost < 1/h", lambda s: s["false_lost_per_hour"] < 1)],
    "track": [("NEES within 2.36 to 3.72", lambda s: 2.359690 <= s["nees"]["mean"] <= 3.716009)],  # chi-squared, 50 runs
    "intel": [at_least("success", 0.95), at_most("confident_wrong_1s", 0.0)],
    "aces": [at_most("confident_wrong_1s", 0.0)],
}


def rate(r):
    return f"{r['hits']} of {r['of']} ({100 * r['low']:.1f} to {100 * r['high']:.1f} %)" if r and r["of"] else "-"


def row(name, result):
    s, search_ms = result["summary"], result["times"]["search_step_ms"]
    late, nees, said = s["localize_s"], s["nees"], s["calibration"]
    return (f"| {name} | {rate(s['success'])} | {' / '.join(fixed(late[k], 1) for k in ('median', 'p95', 'most'))} s "
            f"| {s['confident_wrong']['hits']} / {s['confident_wrong_1s']['hits']} | {fixed(s['false_lost_per_hour'], 1)} "
            f"| {fixed(s['rmse_m'] and 100 * s['rmse_m'], 1)} cm "
            f"| {fixed(nees['mean'], 2)} ({fixed(nees['low'], 2)} to {fixed(nees['high'], 2)}) "
            f"| {fixed(said['brier'], 4)} | {fixed(said['auc'], 4)} "
            f"| {s['searches_mean']:.1f} | {fixed(search_ms['median'], 0)} / {fixed(search_ms['p95'], 0)} ms |")


def arguments_of(args, name):
    """What `parloc evaluate` gets for a row; None for a log that is not there."""
    if name in SCENES:
        arguments, trials = SCENES[name]
        return [*arguments, "--trials", max(1, round(trials * args.share))]
    folder = args.data / name
    if not (folder / "scans.log").exists():
        print(f"{name}: left out, {folder / 'scans.log'} is not there", file=sys.stderr)
        return None
    return ["--log", folder / "scans.log", "--map", folder / RECORDED[name], "--truth", folder / "reference.tum",
            "--starts", max(1, round(20 * args.share))]


def evaluate(bench, name, arguments):
    args, arguments = bench.args, [*arguments, "--jobs", bench.args.jobs]
    samples = ["--samples", args.samples / f"{name}.csv"] if args.samples else []
    result = report_of(bench, "evaluate", name, [*arguments, *samples])
    del result["trials"]
    result["command"] = f"parloc evaluate {' '.join(map(str, arguments))}".replace(str(args.data), "$PARLOC_DATA")
    return result


def run(bench):
    args = bench.args
    if args.samples:
        args.samples.mkdir(parents=True, exist_ok=True)
    path, results, kept = args.out / "evaluate.json", {}, True
    if path.exists() and len(args.only) < len(SCENES) + len(RECORDED):
        results = json.loads(path.read_text())  # the other rows stay
    for name in args.only:
        arguments = arguments_of(args, name)
        if arguments is None:
            continue
        results[name] = evaluate(bench, name, arguments)
        print(row(name, results[name]), flush=True)
        for what, holds in BARS.get(name, []):
            if not holds(results[name]["summary"]):
                kept = False
                print(f"{name}: missed: {what}", file=sys.stderr)
        path.write_text(json.dumps(results, indent=1) + "\n")
    return 0 if kept else 1


def share(text):
    if not 0.0 < float(text) <= 1.0:
        raise argparse.ArgumentTypeError("expected more than 0 and at most 1")
    return float(text)


if __name__ == "__main__":
    sys.exit(measuring.study(__doc__, {run: (
        option("--share", 1.0, "share of the trials, above 0 and at most 1", type=share, metavar="S"),
        subset("--only", [*SCENES, *RECORDED], "rows", "ROW"), count("--jobs", os.cpu_count(), "trials at a time"),
        path("--samples", None, "keep every scan's values here (ROW.csv)"), LOGS_FOLDER)}))
