#!/usr/bin/env python3
"""Runs `parloc evaluate` on every scene of docs/results/evaluate.md: its values (JSON), and the rows of its table on standard output.

    tools/studies/trials.py [--share S] [--only ROW ...] [--jobs K] [--out DIR] [--samples DIR] [--parloc FILE] [--data DIR]

--share 0.1 runs a tenth of the trials. Real logs are left out, with a line that says so, where they are not found. Needs Python 3.10
and a built program. Exit code: 0 every bar kept, 1 one missed, 2 wrong usage or a missing file, 3 a run of parloc failed, 130
interrupted: rows that are finished are written in any case.
"""

import argparse
import json
import pathlib
import sys

import measuring
from measuring import DATA, ROOT

OFFICE, WORKS = "configs/office_scenario.yaml", "configs/works_scenario.yaml"
SCENES = {  # row: arguments, trials; real logs: folder, map
    "office360": (["--scenario", OFFICE, "--range", 8], 1000),
    "works": (["--scenario", WORKS, "--range", 8], 300),
    "fov180": (["--scenario", OFFICE, "--range", 8, "--fov", 180], 200),
    "fov100": (["--scenario", OFFICE, "--range", 8, "--fov", 100], 200),
    "people": (["--scenario", "configs/office_people_scenario.yaml", "--range", 8], 200),
    "clutter": (["--scenario", "configs/office_clutter_scenario.yaml", "--range", 8], 200),
    "kidnap": (["--scenario", OFFICE, "--range", 8, "--task", "kidnap"], 200),
    "track": (["--scenario", OFFICE, "--range", 8, "--task", "track", "--duration", 60], 50),
}
LOGS = {"intel": "map.yaml", "aces": "map.yaml", "tb3_house": "map_05.yaml"}


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
               ("AUC >= 0.98", lambda s: s["calibration"]["auc"] >= 0.98), ("false lost < 1/h", lambda s: s["false_lost_per_hour"] < 1)],
    "track": [("NEES within 2.36 to 3.72", lambda s: 2.359690 <= s["nees"]["mean"] <= 3.716009)],  # chi-squared, 50 runs
    "intel": [at_least("success", 0.95), at_most("confident_wrong_1s", 0.0)],
    "aces": [at_most("confident_wrong_1s", 0.0)],
}


def rate(r):
    return f"{r['hits']} of {r['of']} ({100 * r['low']:.1f} to {100 * r['high']:.1f} %)" if r and r["of"] else "-"


def number(value, form):
    return "-" if value is None else format(value, form)


def row(name, result):
    s, search_ms = result["summary"], result["times"]["search_step_ms"]
    late, nees, said = s["localize_s"], s["nees"], s["calibration"]
    return (f"| {name} | {rate(s['success'])} | {' / '.join(number(late[k], '.1f') for k in ('median', 'p95', 'most'))} s "
            f"| {s['confident_wrong']['hits']} / {s['confident_wrong_1s']['hits']} | {number(s['false_lost_per_hour'], '.1f')} "
            f"| {number(s['rmse_m'] and 100 * s['rmse_m'], '.1f')} cm "
            f"| {number(nees['mean'], '.2f')} ({number(nees['low'], '.2f')} to {number(nees['high'], '.2f')}) "
            f"| {number(said['brier'], '.4f')} | {number(said['auc'], '.4f')} "
            f"| {s['searches_mean']:.1f} | {number(search_ms['median'], '.0f')} / {number(search_ms['p95'], '.0f')} ms |")


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--share", type=float, default=1.0, metavar="S", help="share of the trials, above 0 and at most 1 (1)")
    parser.add_argument("--only", nargs="+", choices=[*SCENES, *LOGS], default=[*SCENES, *LOGS], metavar="ROW",
                        help=f"these of {', '.join([*SCENES, *LOGS])}")
    measuring.add_arguments(parser, jobs="trials at a time", all_cores=True)
    parser.add_argument("--samples", type=pathlib.Path, metavar="DIR", help="keep every scan's values here (ROW.csv)")
    parser.add_argument("--data", type=pathlib.Path, default=DATA, metavar="DIR", help="real logs (PARLOC_DATA, else ../shared/data)")
    args = measuring.parse(parser)
    if not 0.0 < args.share <= 1.0:
        parser.error("--share: expected more than 0 and at most 1")
    return args


def arguments_of(args, name):
    """What `parloc evaluate` gets for a row; None for a log that is not there."""
    if name in SCENES:
        arguments, trials = SCENES[name]
        return [*arguments, "--trials", max(1, round(trials * args.share))]
    folder = args.data / name
    if not (folder / "scans.log").exists():
        print(f"{name}: left out, {folder / 'scans.log'} is not there", file=sys.stderr)
        return None
    return ["--log", folder / "scans.log", "--map", folder / LOGS[name], "--truth", folder / "reference.tum",
            "--starts", max(1, round(20 * args.share))]


def evaluate(args, program, work, name, arguments):
    samples = ["--samples", args.samples / f"{name}.csv"] if args.samples else []
    program("evaluate", *arguments, "--jobs", args.jobs, "--quiet", "--out", work / name, *samples)
    text = (work / name / "evaluate.json").read_text().replace(str(args.data), "$PARLOC_DATA")
    result = json.loads(text.replace(f"{ROOT}/", ""))
    del result["trials"]
    result["command"] = "parloc evaluate " + " ".join(str(a) for a in [*arguments, "--jobs", args.jobs]).replace(
        str(args.data), "$PARLOC_DATA")
    return result


def run(args, program, work):
    if args.samples:
        args.samples.mkdir(parents=True, exist_ok=True)
    path, results, kept = args.out / "evaluate.json", {}, True
    if path.exists() and len(args.only) < len(SCENES) + len(LOGS):
        results = json.loads(path.read_text())  # the other rows stay
    for name in args.only:
        arguments = arguments_of(args, name)
        if arguments is None:
            continue
        results[name] = evaluate(args, program, work, name, arguments)
        print(row(name, results[name]), flush=True)
        for what, holds in BARS.get(name, []):
            if not holds(results[name]["summary"]):
                kept = False
                print(f"{name}: missed: {what}", file=sys.stderr)
        path.write_text(json.dumps(results, indent=1) + "\n")
    return 0 if kept else 1


def main():
    args = parse_arguments()
    return measuring.run_tool("trials", args, run)


if __name__ == "__main__":
    sys.exit(main())
