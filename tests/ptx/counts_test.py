#!/usr/bin/env python3
"""Fails if a kernel has grown: what its warps issue in a step, counted on PTX, against tests/ptx/counts.json.

Usage: counts_test.py COUNT_STEP NVCC_VERSION [--pin]      --pin writes the file anew: say why in the commit"""

import json
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
PINNED = ROOT / "tests/ptx/counts.json"
SCENARIO = "configs/paz2012_scenario.yaml"
CASES = {"beam": 2000, "gaussian": 500, "likelihood_field": 2000}  # particles
BEAMS, MOST_GROWTH, SKIPPED = 200, 1.05, 77


def counted(program, model, particles):
    command = [program, SCENARIO, model, str(particles), str(BEAMS)]
    environment = {**os.environ, "PTX_RACES": "0"}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=True)
    kernels = json.loads(done.stdout)["kernels"]
    return {name: sum(kernel["issued"].values()) for name, kernel in sorted(kernels.items())}


def main():
    program, version = sys.argv[1], sys.argv[2]
    counts = {model: counted(program, model, particles) for model, particles in CASES.items()}
    if "--pin" in sys.argv:
        PINNED.write_text(json.dumps({"nvcc": version, "issued": counts}, indent=1) + "\n")
        return 0
    pinned = json.loads(PINNED.read_text())
    if pinned["nvcc"] != version:
        print(f"counted with nvcc {pinned['nvcc']}; this one is {version}, whose PTX may differ")
        return SKIPPED
    grown = 0
    for model, kernels in counts.items():
        for name, issued in kernels.items():
            before = pinned["issued"][model].get(name)
            if before is None or issued > before * MOST_GROWTH:
                print(f"{model}: {name} issues {issued}, {'new' if before is None else f'{before} before'}")
                grown += 1
    print(f"{sum(map(len, counts.values()))} kernels counted, {grown} have grown")
    return 1 if grown else 0


if __name__ == "__main__":
    sys.exit(main())
