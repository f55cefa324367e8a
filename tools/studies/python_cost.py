#!/usr/bin/env python3
"""What Python costs: the closed loop over Intel's log with 2000 particles, one thread, by turns in C++ (localize_log of
tests/bench) and in Python (Localizer.run), in processor time of the loop; then a scan made from numpy, and the import.
Needs the package: that of BUILD/python with build/python on PYTHONPATH, or an installed one.

Usage: python_cost.py [BUILD] [TURNS]       defaults: build/cpu, 5"""

import math
import os
import pathlib
import statistics
import subprocess
import sys
import time

DATA = pathlib.Path(os.environ.get("PARLOC_DATA", "../shared/data")) / "intel"
PARTICLES = 2000


def in_python(start):
    """In a process of its own: scans, seconds, digest."""
    import parloc

    localizer = parloc.Localizer(parloc.read_map(DATA / "map.yaml"), parloc.Config(particles=PARTICLES, threads=1))
    localizer.start_at(start)
    begun = time.process_time()
    track = localizer.run(DATA / "scans.log")
    took_s = time.process_time() - begun
    print(len(track), f"{took_s:.4f}", track.digest)


def output_of(*command):
    return subprocess.run([str(c) for c in command], capture_output=True, text=True, check=True).stdout.split()


def run_by_turns(build, turns, start):
    """Seconds of each."""
    commands = {
        "C++": [build / "tests/bench/localize_log", DATA / "map.yaml", DATA / "scans.log", *start, PARTICLES],
        "Python": [sys.executable, __file__, "--in-python", *start],
    }
    taken = {name: [] for name in commands}
    digests = set()
    for turn in range(turns):
        for name in list(commands)[:: 1 if turn % 2 == 0 else -1]:
            scans, seconds, digest = output_of(*commands[name])
            taken[name].append(float(seconds))
            digests.add(digest)
    assert len(digests) == 1, "C++ and Python gave different bits"
    print(f"{scans} scans, digest {digests.pop()}")
    return taken


def scan_from_numpy():
    import numpy as np

    import parloc

    ranges = np.random.default_rng(1).uniform(0.5, 30, 1080).astype(np.float32)
    times = []
    for _ in range(7):
        begun = time.process_time()
        for _ in range(20_000):
            parloc.Scan(ranges, -2.356, 0.00436, stamp_s=1.0, range_max_m=30.0)
        times.append((time.process_time() - begun) / 20_000)
    return 1e6 * statistics.median(times)


def import_ms(statement):
    code = f"import time; t = time.process_time(); {statement}; print(1000 * (time.process_time() - t))"
    return statistics.median(float(output_of(sys.executable, "-c", code)[0]) for _ in range(15))


def main():
    if sys.argv[1:2] == ["--in-python"]:
        return in_python(tuple(map(float, sys.argv[2:])))
    build = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "build/cpu")
    turns = int(sys.argv[2]) if len(sys.argv) > 2 else 5
    first = (DATA / "reference.tum").read_text().split("\n")
    row = next(line for line in first if line and not line.startswith("#")).split()
    x, y, z, w = row[1], row[2], float(row[6]), float(row[7])


    taken = run_by_turns(build, turns, (x, y, 2 * math.atan2(z, w)))
    for name, seconds in taken.items():
        print(f"{name}: median {statistics.median(seconds):.3f} s, least {min(seconds):.3f} s, of {turns}")
    share = [p / c - 1 for p, c in zip(taken["Python"], taken["C++"], strict=True)]
    print(f"Python over C++: median of the turns {100 * statistics.median(share):+.2f} %, of the least "
          f"{100 * (min(taken['Python']) / min(taken['C++']) - 1):+.2f} %")
    print(f"a Scan of 1080 ranges from numpy: {scan_from_numpy():.2f} us")
    numpy_ms = import_ms("import numpy")
    print(f"import parloc: {import_ms('import parloc'):.0f} ms, of which numpy is {numpy_ms:.0f} ms")


if __name__ == "__main__":
    main()
