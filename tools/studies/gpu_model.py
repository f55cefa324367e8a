#!/usr/bin/env python3
"""How long a filter step would take on GPUs that are not here: an estimate, to hold a first measurement against.

The programs count_step and count_slam (tests/ptx) run one full step on nvcc's PTX and count what every warp issues.
cuobjdump, if it is found, says how many instructions of SASS the PTX became, in loops of each depth (a compiler that repeats
in a loop of PTX what the assembler moves out again would else be believed), and how many registers they take. A kernel takes
the longest of
  issue    all that its warps issue, over the schedulers of all multiprocessors;
  chain    what its longest warp issues, one after the other, with assumed latencies; or, if that is longer, what the longest
           warp of a block does in the mean, times the rounds in which the blocks fit, each beginning where another ends;
and from one node of the graph to the next passes a constant time. Not in it: caches, bandwidth of memory but for SLAM's tiles,
clocks that fall.

Usage: gpu_model.py [BUILD] [--cuobjdump FILE]         default: build/cuda-nogpu; writes docs/results/gpu_model.md"""

import argparse
import collections
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
    memory_gb_s: float
    multiprocessors: int
    clock_ghz: float
    float64_slots: int  # issue slots that one instruction of float64 takes
    node_us: float  # from one node of a graph to the next


GPUS = (Gpu("H200", 4800, 132, 1.98, 2, 1.0), Gpu("RTX 4090", 1000, 128, 2.52, 64, 1.0),
        Gpu("Jetson AGX Orin", 204, 16, 1.30, 64, 2.0))  # fmt: skip
SCHEDULERS, MOST_WARPS, REGISTERS, WARPS_OF_BLOCK = 4, 64, 65536, 8
# Assumed: cycles until what depends on an instruction can go on; of global memory two loads are in flight.
LATENCY = {"integer": 4.5, "float32": 4.5, "float64": 8, "control": 6, "other memory": 6, "shared": 25, "meeting": 25,
           "global": 120, "atomic": 200}  # fmt: skip

HALL, OFFICE = "configs/paz2012_scenario.yaml", "configs/office_scenario.yaml"
# Counted with so many particles, and said of so many: what grids of thousands of blocks issue grows with them. And of
# so many filters, whose kernels are started together (cuda/step_group.h).
CASES = [(place, path, model, counted, said, filters) for place, path in (("hall", HALL), ("office", OFFICE))
         for model, counted, said, filters in (("beam", 4000, 4000, 1), ("likelihood_field", 4000, 4000, 1),
                                               ("beam", 4000, 4000, 64), ("likelihood_field", 4000, 4000, 64),
                                               ("beam", 40000, 1000000, 1), ("gaussian", 40000, 1000000, 1),
                                               ("likelihood_field", 40000, 1000000, 1))]  # fmt: skip
BEAMS, NODES_OF_A_GROUP = 200, 2  # two copies are kernels then, beside the copies of what they copy


def by_depth(items):
    """How many instructions lie in so many loops: {depth: count}, and the depth of each item. `items`: (label in front or
    None, instructions, labels that its branches go to), in the order of the text. Branches back are loops."""
    at = {label: k for k, (label, _, _) in enumerate(items) if label is not None}
    end = {}  # of the loop that begins there
    for k, (_, _, targets) in enumerate(items):
        for head in (at[t] for t in targets if t in at and at[t] <= k):
            end[head] = max(end.get(head, 0), k)
    depths = [sum(head <= k <= last for head, last in end.items()) for k in range(len(items))]
    counts = collections.Counter()
    for depth, (_, count, _) in zip(depths, items, strict=True):
        counts[depth] += count
    return counts, depths


def sass_by_depth(function):
    """Without what lies behind the first address that is called: what divisions and roots do with denormal numbers,
    infinities and the like, one piece for all of them, hardly ever runs."""
    called = [int(at, 16) for at in re.findall(r"CALL\.REL\.NOINC (0x[0-9a-f]+)", function)]
    first = min(called, default=len(function) * 16)
    items = []
    for place, words in re.findall(r"/\*([0-9a-f]{4,})\*/ +([^/]*;)", function):
        at, branch = int(place, 16), re.search(r"\bBRA\b[^;]*0x([0-9a-f]+)", words)
        if at < first and "NOP" not in words:
            items.append((at, 1, [int(branch[1], 16)] if branch and int(branch[1], 16) != at else []))
    return by_depth(items)[0]


def ptx_by_depth(text):
    """By symbol, of the C++ that was written of a module's PTX: instructions by depth, and the depth of each piece."""
    symbols = re.findall(r'^    \{"(\w+)", "\w+\.ptx", kernel\d+', text, re.M)
    result = {}
    for number, symbol in enumerate(symbols):
        table = re.search(rf"pieces{number}\[\] = \{{\n(.*?)\{{\}}\}};", text, re.S)[1]
        sizes = [sum(map(int, row.split(","))) for row in re.findall(r"\{([\d, ]+)\}", table)]
        body = re.search(rf"^Outcome kernel{number}\(.*?^\}}", text, re.S | re.M)[0]
        items, label = [], None
        for name, piece, target in re.findall(r"^(\w+):;|thread\.visit\((\d+)\)|goto (\w+);", body, re.M):
            if name:
                label = name
            elif piece:
                items.append((label, sizes[int(piece)], []))
                label = None
            elif items:
                items[-1][2].append(target)
        result[symbol] = by_depth(items)
    return result


def ratios_by_piece(ptx, sass):
    """Instructions of SASS for one of PTX, of each piece: that of its depth of loops, where both have loops as deep."""
    counts, depths = ptx
    if sass is None:
        return [1.0] * len(depths)
    if set(counts) != set(sass):
        return [sum(sass.values()) / max(sum(counts.values()), 1)] * len(depths)
    return [sass[depth] / max(counts[depth], 1) for depth in depths]


def of_many(symbol):
    """What both run_kernel<K> and run_many<K> (cuda/launch.h) have in their symbols, and which of them it is."""
    found = re.match(r"(.*?)(10run_kernel|8run_many)(I.*E)E+v", symbol)
    return (found[1] + found[3].rstrip("E"), found[2] == "8run_many") if found else (symbol, False)
# SLAM: scans of a recorded log, each counted with two numbers of particles. What is counted is a straight line through them.
SLAM_LOG, SLAM_SCANS, SLAM_LAST = "maps/logs/malaga_faculty.log.gz", 36, 4
SLAM_COUNTED, SLAM_SAID = (10, 20), 1000
TILE_WORDS, TILE_BYTES = 1040, 8320


def static_counts(build, cuobjdump):
    """By kernel: instructions of SASS for one of PTX, of each piece of it, and registers: alone and as one of many."""
    ptx, sass, registers = {}, {}, {}
    for file in (build / "tests/ptx/parloc_kernels_on_ptx").glob("*.ptx.cpp"):
        ptx.update((plain(symbol), counts) for symbol, counts in ptx_by_depth(file.read_text()).items())
    for file in (build / "CMakeFiles/parloc.dir/cuda").glob("*.o") if cuobjdump else ():
        text = subprocess.run([cuobjdump, "-sass", "-arch", "sm_90", file], capture_output=True, text=True, check=True).stdout
        for function in text.split("Function : ")[1:]:
            sass[plain(function.split(None, 1)[0])] = sass_by_depth(function)
        text = subprocess.run([cuobjdump, "-res-usage", file], capture_output=True, text=True, check=True).stdout
        for name, count in re.findall(r"Function (\S+):\s+REG:(\d+)", text):
            registers[of_many(plain(name))] = int(count)
    result = {}
    for name, counts in ptx.items():
        kernel, _ = of_many(name)
        alone = registers.get((kernel, False), 64)
        result[name] = (ratios_by_piece(counts, sass.get(name)), (alone, registers.get((kernel, True), alone)))
    return result


def of_kernel(kernel, statics):
    """Instructions of SASS for one of PTX, as the kernel has run, and its registers."""
    ratios, registers = statics[plain(kernel["symbol"])]
    in_sass = sum(ratio * n for ratio, n in zip(ratios, kernel["issued_in"], strict=True))
    return in_sass / max(sum(kernel["issued_in"]), 1), registers


def kernel_us(gpu, kernel, growth, ratio, registers):
    issued = kernel["issued"]
    slots = sum(n * (gpu.float64_slots if kind == "float64" else 1) for kind, n in issued.items()) * ratio * growth
    issue_us = slots / (gpu.multiprocessors * SCHEDULERS * gpu.clock_ghz * 1e3)
    latency = sum(n * LATENCY[kind] for kind, n in issued.items()) / sum(issued.values())
    chain_us = ratio * latency / (gpu.clock_ghz * 1e3)
    mean = kernel["block_chains"] / kernel["blocks"]
    resident = gpu.multiprocessors * min(MOST_WARPS, REGISTERS // (32 * registers) // WARPS_OF_BLOCK * WARPS_OF_BLOCK)
    rounds = max(1.0, kernel["threads"] / 32 * growth / resident)
    return issue_us, chain_us * max(kernel["longest_warp"], mean * rounds)


def count_step(build, path, model, particles):
    command = [build / "tests/ptx/count_step", path, model, str(particles), str(BEAMS)]
    done = subprocess.run(command, cwd=ROOT, env={**os.environ, "PTX_RACES": "0"}, capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def count_slam(build, proposal, particles):
    command = [build / "tests/ptx/count_slam", SLAM_LOG, proposal, str(particles), str(SLAM_SCANS), str(SLAM_LAST)]
    done = subprocess.run(command, cwd=ROOT, env={**os.environ, "PTX_RACES": "0"}, capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def extrapolated(few, many):
    """A kernel's counts with SLAM_SAID particles."""
    low, high = SLAM_COUNTED

    def line(a, b):
        return max(0.0, a + (b - a) * (SLAM_SAID - low) / (high - low))

    kinds = {**few["issued"], **many["issued"]}
    issued = {kind: line(few["issued"].get(kind, 0), many["issued"].get(kind, 0)) for kind in kinds}
    return {**many, "issued": issued, "threads": line(few["threads"], many["threads"]),
            "longest_warp": max(few["longest_warp"], many["longest_warp"])}  # fmt: skip


def copied_bytes(few, many):
    """To and fro by CopyTiles: of every word 5 accesses are counted, where it is and the word itself."""
    low, high = (kernel["issued"]["global"] for kernel in (few, many))
    words = (high - low) / (SLAM_COUNTED[1] - SLAM_COUNTED[0]) * SLAM_SAID * 32 / 5
    return 2 * TILE_BYTES * max(0.0, words) / TILE_WORDS


def model_slam(build, proposal, statics):
    """Means over the counted scans."""
    few, many = (count_slam(build, proposal, particles) for particles in SLAM_COUNTED)
    rows, totals = {}, dict.fromkeys(GPUS, 0.0)
    for a, b in zip(few, many, strict=True):
        for name, kernel in b["kernels"].items():
            moved = copied_bytes(a["kernels"][name], kernel) if name == "CopyTiles" else 0.0
            kernel = extrapolated(a["kernels"][name], kernel)
            ratio, (registers, _) = of_kernel(kernel, statics)
            times = {gpu: kernel_us(gpu, kernel, 1.0, ratio, registers) for gpu in GPUS}
            for gpu in GPUS:
                totals[gpu] += max(*times[gpu], moved / (gpu.memory_gb_s * 1e3)) / len(many)
            row = rows.setdefault(name, [name, 0.0, ratio, registers, 0.0, 0.0])
            for k, value in ((1, sum(kernel["issued"].values())), (4, times[GPUS[0]][0]), (5, times[GPUS[0]][1])):
                row[k] += value / len(many)
    nodes = len(rows) + 2  # the copies of input and report
    for gpu in GPUS:
        totals[gpu] += nodes * gpu.node_us
    return {"place": "faculty", "model": proposal, "particles": SLAM_SAID, "nodes": nodes, "rows": list(rows.values()),
            "totals": totals, "resampled": sum(scan["resampled"] for scan in many)}  # fmt: skip


def model_case(case, counts, statics):
    place, _, model, counted, said, filters = case
    growth, rows, totals = said / counted, [], dict.fromkeys(GPUS, 0.0)
    for name, kernel in counts["kernels"].items():
        ratio, registers = of_kernel(kernel, statics)
        registers = registers[filters > 1]
        grows = growth if kernel["blocks"] > 16 or kernel["threads"] >= counted // 8 else 1.0
        grows *= filters
        times = {gpu: kernel_us(gpu, kernel, grows, ratio, registers) for gpu in GPUS}
        for gpu in GPUS:
            totals[gpu] += max(times[gpu])
        rows.append((name, sum(kernel["issued"].values()) * grows, ratio, registers, *times[GPUS[0]]))
    nodes = sum(kernel["launches"] for kernel in counts["kernels"].values()) + counts["copies"]
    nodes += NODES_OF_A_GROUP if filters > 1 else 0
    for gpu in GPUS:
        totals[gpu] += nodes * gpu.node_us
    size = str(said) if filters == 1 else f"{filters} x {said}"
    return {"place": place, "model": model, "particles": size, "nodes": nodes, "rows": rows, "totals": totals}


def table_row(r):
    times = " | ".join(f"{r['totals'][gpu]:.0f}" for gpu in GPUS)
    return f"| {r['place']} | {r['model']} | {r['particles']} | {r['nodes']} | {times} |\n"


def slam_part(results):
    low, high = SLAM_COUNTED
    text = f"\n## Grid SLAM, {SLAM_SAID} particles\n\nScans {SLAM_SCANS - SLAM_LAST + 1} to {SLAM_SCANS} that "
    text += f"`{SLAM_LOG}` has taken in, 180 beams, the mean. Counted with {low} and with {high} particles, and said of "
    text += f"{SLAM_SAID} by a straight line through both (the executor is slow); tiles that are copied take the bandwidth of "
    text += "memory, if that is longer. The host waits once in a scan. The bar is 2 ms on an H200.\n\n| log | proposal | "
    text += "particles | nodes | " + " | ".join(f"{gpu.name} [us]" for gpu in GPUS) + " |\n"
    text += "|" + "---|" * (4 + len(GPUS)) + "\n" + "".join(table_row(r) for r in results)
    for r in results:
        us = r["totals"][GPUS[0]]
        text += f"\n{r['model']}: {us / 1000:.2f} ms on {GPUS[0].name}, the bar is {'met' if us <= 2000 else 'not met'}"
        text += f" (of {SLAM_LAST} scans {r['resampled']} resampled).\n"
    return text


def page(results, cuobjdump):
    text = "# How long a step would take on a GPU: an estimate\n\n**Nothing here was measured on a GPU.** "
    text += "`tools/studies/gpu_model.py` makes this page: " + __doc__.split("\n\n")[1].replace("\n", " ") + "\n\n"
    if not cuobjdump:
        text += "Without cuobjdump: an instruction of SASS for one of PTX, 64 registers.\n\n"
    text += f"A full step, {BEAMS} beams, tracking:\n\n| place | model | particles | nodes | "
    text += " | ".join(f"{gpu.name} [us]" for gpu in GPUS) + " |\n|" + "---|" * (4 + len(GPUS)) + "\n"
    text += "".join(table_row(r) for r in results if r["place"] != "faculty")
    text += slam_part([r for r in results if r["place"] == "faculty"])
    for r in results:
        if r["place"] == "office" or (r["place"] == "hall" and r["model"] == "gaussian"):
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
    for program in ("count_step", "count_slam"):
        if not (build / "tests/ptx" / program).exists():
            sys.exit(f"{build}: no tests/ptx/{program}; cmake --preset cuda-nogpu and ninja -C {build} {program} make it")
    statics = static_counts(build, chosen.cuobjdump)
    results = [model_slam(build, proposal, statics) for proposal in ("scan_match", "gaussian")]
    results += [model_case(case, count_step(build, case[1], case[2], case[3]), statics) for case in CASES]
    (ROOT / "docs/results/gpu_model.md").write_text(page(results, chosen.cuobjdump))
    for r in results:
        times = ", ".join(f"{gpu.name} {r['totals'][gpu]:.0f} us" for gpu in GPUS)
        print(f"{r['place']} {r['model']} {r['particles']}: {r['nodes']} nodes; estimated {times}")


if __name__ == "__main__":
    main()
