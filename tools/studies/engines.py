#!/usr/bin/env python3
"""What an engine costs: trials of the office by `parloc evaluate --jobs 2`, and as a sweep in Slurm and Dask with two workers
of which one is killed every so many seconds. All trials must be there, byte for byte. Needs the Python package and program
(PYTHONPATH, PARLOC_PROGRAM), distributed, Slurm and root (tools/install_deps --tests).

Usage: engines.py [--trials 10000] [--kill-every 30] [--engines local slurm dask]"""

import argparse
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

import parloc
from parloc.program import program_path

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tests" / "python"))
from slurm_here import Slurm  # noqa: E402
from sweep_here import processes, results  # noqa: E402

SWEEP = """scenarios: {scenario}
task: track
trials: {trials}
duration: 1
settings:
  particles: [50]
"""
PARTS = 8


class Killer:
    """A progress function that kills one worker every so many seconds; what that is, `victims` says."""

    def __init__(self, every_s, victims):
        self.every_s, self.victims = every_s, victims
        self.killed, self.next_s = 0, time.monotonic() + every_s

    def __call__(self, done, of):
        if time.monotonic() < self.next_s or done >= of:
            return
        self.next_s += self.every_s
        for victim in self.victims()[:1]:
            os.kill(victim, signal.SIGKILL)
            self.killed += 1


def busy_worker(dask_worker):
    return os.getpid() if dask_worker.state.executing_count else 0


def plain(plan, folder):
    """The unsharded run of the same words, and how long it takes."""
    parloc.sweep(plan, out=folder / "words", engine="none", parts=1)
    words = (folder / "words" / "parts.txt").read_text().split(" --quiet ")[0].split()
    begun = time.monotonic()
    own = ["--quiet", "--jobs", "2", "--out", folder / "plain"]
    subprocess.run([program_path(), *words, *own], cwd=folder / "words", check=True)
    return time.monotonic() - begun


def sweep(name, plan, folder, every_s):
    """Seconds that the trials take, the engine's start and the page apart, and how many workers were killed."""
    out = folder / name
    if name == "dask":
        import distributed

        with distributed.LocalCluster(n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None) as cluster, \
             distributed.Client(cluster) as client:
            killer = Killer(every_s, lambda: sorted(filter(None, client.run(busy_worker).values())))
            return timed(plan, out, client, killer), killer.killed
    killer = Killer(every_s, lambda: processes(out))
    return timed(plan, out, name, killer), killer.killed


def timed(plan, out, engine, killer):
    begun = time.monotonic()
    result = parloc.sweep(plan, out=out, engine=engine, jobs=2, parts=PARTS, progress=killer)
    assert not result.failed and not result.missing, result
    return time.monotonic() - begun


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=10_000)
    parser.add_argument("--kill-every", type=float, default=30.0, metavar="S")
    parser.add_argument("--engines", nargs="+", default=["slurm", "dask"], choices=["local", "slurm", "dask"])
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="parloc_engines_") as text:
        folder = pathlib.Path(text)
        folder.chmod(0o755)
        plan = folder / "office.yaml"
        plan.write_text(SWEEP.format(scenario=ROOT / "configs" / "office_scenario.yaml", trials=args.trials))
        (folder / "slurm").mkdir()
        slurm = Slurm(folder / "slurm") if "slurm" in args.engines else None
        try:
            os.environ.update(slurm.environment if slurm else {})
            alone_s = plain(plan, folder)
            print(f"{args.trials} trials: --jobs 2 takes {alone_s:.1f} s", flush=True)
            whole, code = results(folder / "plain" / "evaluate.json"), 0
            for name in args.engines:
                took_s, killed = sweep(name, plan, folder, args.kill_every)
                merged = folder / name / "runs" / "0001" / "merged" / "evaluate.json"
                equal, there = results(merged) == whole, len(json.loads(merged.read_text())["trials"])
                print(f"{name}: {took_s:.1f} s ({100 * (took_s / alone_s - 1):+.1f} %), {killed} killed, {there} trials, "
                      f"{'equal' if equal else 'NOT EQUAL'}", flush=True)
                code |= not equal or there != args.trials or took_s > 1.05 * alone_s
        finally:
            if slurm:
                slurm.stop()
    return int(code)


if __name__ == "__main__":
    sys.exit(main())
