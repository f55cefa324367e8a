#!/usr/bin/env python3
"""Are settings that `parloc tune` finds on a log better on drives that it never saw? Tunes on every log, with its truth and
without any, then holds old and found settings against the truth: on the pieces of that log that were kept back, and on all
pieces of the other logs, with other seeds. Prints tables (Markdown).

Needs the package and Optuna on PYTHONPATH. Usage: tuning.py OUT [TRIALS]       100; goes on with what is in OUT"""

import os
import pathlib
import subprocess
import sys
import time

import parloc
from parloc import tuning
from parloc.tuning import drives, verdict

DATA = pathlib.Path(os.environ.get("PARLOC_DATA", "../shared/data"))
LOGS = {"intel": "map.yaml", "aces": "map.yaml", "tb3_house": "map_05.yaml"}
SEEDS = [301, 302, 303]  # of neither search nor verdict


def files_of(log, with_truth=True):
    folder = DATA / log
    known = (str(folder / LOGS[log]), str(folder / "reference.tum")) if with_truth else (None, None)
    return tuning.DriveFiles(str(folder / "scans.log"), *known)


def tune(log, with_truth, out, trials):
    """The settings found, better or not, as the command leaves them; its sentence and its seconds."""
    f = files_of(log, with_truth)
    truth = ["--map", f.map, "--truth", f.truth] if with_truth else []
    begun = time.monotonic()
    command = [sys.executable, "-m", "parloc.tuning", "--log", f.log, *truth, "--out", str(out), "--trials", str(trials)]
    said = subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()
    found = [path for path in (out / "tuned.yaml", out / "not_better.yaml") if path.exists()]
    return (parloc.read_config(found[0]) if found else parloc.Config()), said, time.monotonic() - begun


def held_against_truth(found, pieces):
    places = [(p.drive, p.begin_s) for p in pieces]
    sides = []
    for config in (parloc.Config(), found):
        config.threads = 1
        sides.append(verdict.score_all(str(config), pieces, SEEDS))
    return tuning.Comparison(places, *sides)


def told(comparison):
    i = comparison.gain
    before = 1000 * sum(s.error_m for s in comparison.base) / len(comparison.base)
    return f"{1000 * i.mean:+.1f} [{1000 * i.low:+.1f}, {1000 * i.high:+.1f}] of {before:.1f}"


def main():
    out, trials = pathlib.Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 100
    base = parloc.Config(threads=1)
    pieces = {log: drives.read_pieces(files_of(log), base, str(out)) for log in LOGS}
    print("| tuned on | verdict of the command | s |", "|---|---|---|", sep="\n", flush=True)
    found = {}
    for log in LOGS:
        for with_truth in (True, False):
            name = f"{log}, {'truth' if with_truth else 'own map'}"
            config, said, seconds = tune(log, with_truth, out / name.replace(", ", "_").replace(" ", "_"), trials)
            found[name] = (log, config)
            print(f"| {name} | {said} | {seconds:.0f} |", flush=True)
    print("\n| tuned on |", " | ".join(LOGS), "|", "\n|---|" + "---|" * len(LOGS), sep="", flush=True)
    for name, (own, config) in found.items():
        cells = [told(held_against_truth(config, drives.split(p)[1] if log == own else p)) for log, p in pieces.items()]
        print(f"| {name} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
