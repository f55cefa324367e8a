#!/usr/bin/env python3
"""How long a filter step would take on GPUs that are not here: an estimate, to hold a first measurement against.

The program count_step (tests/ptx) runs one full step on nvcc's PTX and counts what every warp issues. cuobjdump, if it is
found, says how many instructions of SASS the PTX became and how many registers they take. A kernel takes the longest of
  issue    all that its warps issue, over the schedulers of all multiprocessors;
  chain    what its longest warp issues, one after the other, with assumed latencies, times the rounds in which its warps fit;
and from one node of the graph to the next passes a constant time. Not in it: caches, bandwidth of memory, clocks that fall.

Usage: gpu_model.py [BUILD] [--cuobjdump FILE]         default: build/cuda-nogpu; writes docs/results/gpu_model.md"""

import argparse
import dataclasses
import datetime
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/ptx/generator"))
from write import plain  # noqa: E402


@dataclasses.dataclass(frozen=True)
class Gpu:
    name: str
    multiprocessors: int
    clock_ghz: float
    float64_slots: int  # issue slots that one instruction of float64 takes
    node_us: float  # from one node of a graph to the next


GPUS = (Gpu("H200", 132, 1.98, 2, 1.0), Gpu("RTX 4090", 128, 2.52, 64, 1.0), Gpu("Jetson AGX Orin", 16, 1.30, 64, 2.0))
SCHEDULERS, MOST_WARPS, REGISTERS, WARPS_OF_BLOCK = 4, 64, 65536, 8
# Assumed: cycles until what depends on an instruction can go on; of global memory two loads are in flight.
LATENCY = {"integer": 4.5, "float32": 4.5, "float64": 8, "control": 6, "other memory": 6, "shared": 25, "meeting": 25,
           "global": 120, "atomic": 200}  # fmt: skip

HALL, OFFICE = "configs/paz2012_scenario.yaml", "configs/office_scenario.yaml"
# Counted with so many particles, and said of so many: what grids of thousands of blocks issue grows with them.
CASES = [(place, path, model, counted, said) for place, path in (("hall", HALL), ("office", OFFICE))
         for model, counted, said in (("beam", 4000, 4000), ("likelihood_field", 4000, 4000), ("beam", 40000, 1000000),
                                      ("gaussian", 40000, 1000000), ("likelihood_field", 40000, 1000000))]  # fmt: skip
BEAMS = 200


def static_counts(build, cuobjdump):
    """By kernel: instructions of SASS for one of PTX, and registers."""
    ptx = {}
    for file in (build / "tests/ptx/parloc_kernels_on_ptx").glob("*.ptx"):
        for name, body in re.findall(r"\.entry\s+(\S+?)\(.*?\n\{\n(.*?)\n\}\n", file.read_text(), re.S):
            ptx[plain(name)] = len(re.findall(r"^\t(?!\.|//).*;", body, re.M))
    if not cuobjdump:
        return {name: (1.0, 64) for name in ptx}
    sass, registers = {}, {}
    for file in (build / "CMakeFiles/parloc.dir/cuda").glob("*.o"):
        text = subprocess.run([cuobjdump, "-sass", "-arch", "sm_90", file], capture_output=True, text=True, check=True).stdout
        for function in text.split("Function : ")[1:]:
            name = plain(function.split(None, 1)[0])
            sass[name] = sum(" NOP" not in line for line in re.findall(r"/\*[0-9a-f]{4,}\*/ +[^/]*;", function))
        text = subprocess.run([cuobjdump, "-res-usage", file], capture_output=True, text=True, check=True).stdout
        for name, count in re.findall(r"Function (\S+):\s+REG:(\d+)", text):
            registers[plain(name)] = int(count)
    return {name: (sass.get(name, ptx[name]) / max(ptx[name], 1), registers.get(name, 64)) for name in ptx}


def kernel_us(gpu, kernel, growth, ratio, registers):
    issued = kernel["issued"]
    slots = sum(n * (gpu.float64_slots if kind == "float64" else 1) for kind, n in issued.items()) * ratio * growth
    issue_us = slots / (gpu.multiprocessors * SCHEDULERS * gpu.clock_ghz * 1e3)
    latency = sum(n * LATENCY[kind] for kind, n in issued.items()) / sum(issued.values())
    chain_us = kernel["longest_warp"] * ratio * latency / (gpu.clock_ghz * 1e3)
    resident = gpu.multiprocessors * min(MOST_WARPS, REGISTERS // (32 * registers) // WARPS_OF_BLOCK * WARPS_OF_BLOCK)
    rounds = max(1.0, kernel["threads"] / 32 * growth / resident)
    return issue_us, chain_us * rounds


def count_step(build, path, model, particles):
    command = [build / "tests/ptx/count_step", path, model, str(particles), str(BEAMS)]
    done = subprocess.run(command, cwd=ROOT, env={**os.environ, "PTX_RACES": "0"}, capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def model_case(case, counts, statics):
    place, _, model, counted, said = case
    growth, rows, totals = said / counted, [], dict.fromkeys(GPUS, 0.0)
    for name, kernel in counts["kernels"].items():
        ratio, registers = statics.get(kernel["symbol"], (1.0, 64))
        grows = growth if kernel["blocks"] > 16 or kernel["threads"] >= counted // 8 else 1.0
        times = {gpu: kernel_us(gpu, kernel, grows, ratio, registers) for gpu in GPUS}
        for gpu in GPUS:
            totals[gpu] += max(times[gpu])
        rows.append((name, sum(kernel["issued"].values()) * grows, ratio, registers, *times[GPUS[0]]))
    nodes = sum(kernel["launches"] for kernel in counts["kernels"].values()) + counts["copies"]
    for gpu in GPUS:
        totals[gpu] += nodes * gpu.node_us
    return {"place": place, "model": model, "particles": said, "nodes": nodes, "rows": rows, "totals": totals}


def page(results, cuobjdump):
    text = "# How long a step would take on a GPU: an estimate\n\n**Nothing here was measured on a GPU.** "
    text += "`tools/studies/gpu_model.py` makes this page: " + __doc__.split("\n\n")[1].replace("\n", " ") + "\n\n"
    if not cuobjdump:
        text += "Without cuobjdump: an instruction of SASS for one of PTX, 64 registers.\n\n"
    text += f"A full step, {BEAMS} beams, tracking:\n\n| place | model | particles | nodes | "
    text += " | ".join(f"{gpu.name} [us]" for gpu in GPUS) + " |\n|" + "---|" * (4 + len(GPUS)) + "\n"
    for r in results:
        text += f"| {r['place']} | {r['model']} | {r['particles']} | {r['nodes']} | "
        text += " | ".join(f"{r['totals'][gpu]:.0f}" for gpu in GPUS) + " |\n"
    for r in results:
        if r["place"] != "hall" or r["model"] == "gaussian":
            continue
        text += f"\n## {r['model']}, {r['particles']} particles, on {GPUS[0].name}, by kernel\n\n"
        text += "| kernel | issued by warps | SASS for PTX | registers | issue [us] | chain [us] |\n|---|---|---|---|---|---|\n"
        for name, issued, ratio, registers, issue, chain in sorted(r["rows"], key=lambda row: -max(row[4:])):
            text += f"| {name} | {issued:,.0f} | {ratio:.2f} | {registers} | {issue:.1f} | {chain:.1f} |\n"
    text += f"\nAssumed latencies [cycles]: {', '.join(f'{kind} {n:g}' for kind, n in LATENCY.items())}.\n"
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True).stdout.strip()
    return text + f"\n{datetime.date.today()}, on top of {commit}; PTX and SASS of sm_90.\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("build", nargs="?", type=pathlib.Path, default=ROOT / "build/cuda-nogpu")
    parser.add_argument("--cuobjdump", default=shutil.which("cuobjdump"))
    chosen = parser.parse_args()
    build = chosen.build.resolve()
    if not (build / "tests/ptx/count_step").exists():
        sys.exit(f"{build}: no tests/ptx/count_step; cmake --preset cuda-nogpu and ninja -C {build} count_step make it")
    statics = static_counts(build, chosen.cuobjdump)
    results = [model_case(case, count_step(build, case[1], case[2], case[3]), statics) for case in CASES]
    (ROOT / "docs/results/gpu_model.md").write_text(page(results, chosen.cuobjdump))
    for r in results:
        times = ", ".join(f"{gpu.name} {r['totals'][gpu]:.0f} us" for gpu in GPUS)
        print(f"{r['place']} {r['model']} {r['particles']}: {r['nodes']} nodes; estimated {times}")


if __name__ == "__main__":
    main()
