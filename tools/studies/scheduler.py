#!/usr/bin/env python3
"""How many parts should a million trials have on a thousand workers? A simulation for docs/results/shards.md.

What it takes from measurements: how long trials take (--times, the shard.parloc of a real run), and what files and
`parloc merge` take. What it assumes of the machines is in Cluster, and said with the table that it prints. Equal seeds give
equal numbers.
"""

import argparse
import heapq
import math
import random
import statistics
import struct
from dataclasses import dataclass, field

TRIALS, WORKERS = 1_000_000, 1000
PARTS = (1000, 2000, 5000, 10_000, 20_000, 50_000, 100_000)  # --shard takes up to 100,000
BYTES_OF_TRIAL, BYTES_OF_HEAD = 755, 18_000  # of a shard of `evaluate`: its head has all settings
MERGE_S_PER_TRIAL, MERGE_BYTES_PER_TRIAL = 59e-6, 149.0  # of docs/results/shards.md: clock, memory

LOSSES = ("starting", "appending", "dying", "waiting", "last")


@dataclass
class Cluster:
    """The machines and their scheduler. A worker dies at random: at any time with the same probability."""
    workers: int = WORKERS
    dying: float = 0.01  # probability of a worker to die within the time that the work would take without any loss
    restart_s: float = 300.0  # from a worker's death until another is there in its place
    notice_s: float = 60.0  # ... until the part that it was at is given to the next worker that is free
    dispatch_s: float = 0.1  # of the scheduler per part: it starts one after the other
    start_s: float = 1.0  # of a part before its first trial
    append_s: float = 0.005  # of the file system per finished trial


@dataclass
class Run:
    """What came of it: times in seconds, `lost` ones over all workers together."""
    makespan_s: float = 0.0
    work_s: float = 0.0  # of trials that count
    lost: dict = field(default_factory=lambda: dict.fromkeys(LOSSES, 0.0))
    deaths: int = 0
    starts: int = 0


def part_sizes(trials, parts):
    """As --shard I/N has them."""
    return [(trials - k + parts - 1) // parts for k in range(parts)]


def simulate(trial_s, parts, cluster, seed=1):
    """`trial_s`: of each trial. Worker after worker asks for a part; the parts that were broken off come first."""
    drawn = random.Random(seed)
    run = Run(work_s=math.fsum(trial_s))
    rate = -math.log1p(-cluster.dying) * cluster.workers / run.work_s if cluster.dying > 0 else 0.0
    death_s = [drawn.expovariate(rate) if rate > 0 else math.inf for _ in range(cluster.workers)]
    free = [(0.0, k) for k in range(cluster.workers)]  # when which worker asks: a heap
    broken = []  # (from when on, first trial, end): a heap
    sizes = part_sizes(len(trial_s), parts)
    first = next_part = 0
    dispatcher_s = 0.0  # when the scheduler has started all before
    ended_s, finished_s = [0.0] * cluster.workers, 0.0
    while next_part < parts or broken:
        asked_s, worker = heapq.heappop(free)
        if next_part == parts and broken[0][0] > asked_s:  # nothing to do yet but what is to be noticed
            heapq.heappush(free, (broken[0][0], worker))
            continue
        if broken and broken[0][0] <= asked_s:
            _, begin, end = heapq.heappop(broken)
        else:
            begin, end = first, first + sizes[next_part]
            first, next_part = end, next_part + 1
        dispatcher_s = max(asked_s, dispatcher_s) + cluster.dispatch_s
        run.starts += 1
        at_s = dispatcher_s + cluster.start_s
        trial = begin
        while trial < end and at_s + trial_s[trial] + cluster.append_s <= death_s[worker]:
            at_s += trial_s[trial] + cluster.append_s
            trial += 1
        done_s = math.fsum(trial_s[begin:trial])
        run.lost["appending"] += (trial - begin) * cluster.append_s
        if trial == end:
            run.lost["starting"] += cluster.start_s
            ended_s[worker] = at_s
            finished_s = max(finished_s, at_s)
            heapq.heappush(free, (at_s, worker))
            continue
        died_s = max(death_s[worker], dispatcher_s)
        run.deaths += 1
        run.lost["dying"] += cluster.restart_s + died_s - dispatcher_s - done_s - (trial - begin) * cluster.append_s
        heapq.heappush(broken, (died_s + cluster.notice_s, trial, end))
        ended_s[worker] = died_s + cluster.restart_s
        death_s[worker] = ended_s[worker] + drawn.expovariate(rate)
        heapq.heappush(free, (ended_s[worker], worker))
    return closed(run, ended_s, finished_s, cluster)


def closed(run, ended_s, finished_s, cluster):
    """Nothing after the last trial counts; what no other cause explains is waiting for the scheduler."""
    run.makespan_s = finished_s
    run.lost["last"] = math.fsum(max(finished_s - end_s, 0.0) for end_s in ended_s)
    run.lost["dying"] -= math.fsum(max(end_s - finished_s, 0.0) for end_s in ended_s)
    told = run.work_s + math.fsum(run.lost.values())
    run.lost["waiting"] = finished_s * cluster.workers - told
    return run


def times_of_shard(path):
    """Seconds of each trial in the file of a shard (tools/shards/shard_file.cpp)."""
    with open(path, "rb") as file:
        data = file.read()
    magic = b"parloc shard\n"
    if not data.startswith(magic):
        raise SystemExit(f"{path}: expected the shard.parloc of a run with --shard")
    at = len(magic) + 4
    at += 8 + struct.unpack_from("<Q", data, at)[0]
    times_s = []
    while at + 24 <= len(data):
        _, _, took_s, size = struct.unpack_from("<IQdI", data, at)
        times_s.append(took_s)
        at += 24 + size + 4
    return times_s


def drawn_times(measured_s, mean_s, trials, seed):
    """Of the measured ones, scaled to that mean."""
    scale = mean_s / statistics.fmean(measured_s)
    return [scale * time_s for time_s in random.Random(seed).choices(measured_s, k=trials)]


def percents(runs):
    """What each loss adds to the time of the work alone, as means over the runs [%]."""
    return {name: 100.0 * statistics.fmean(run.lost[name] / run.work_s for run in runs) for name in runs[0].lost}


def table(found, trials):
    """As Markdown."""
    columns = ("parts", "trials of each", "time [s]", "lost in all", *LOSSES, "deaths", "appends/s", "files [MB]")
    lines = ["| " + " | ".join(columns) + " |", "|" + "---:|" * len(columns)]
    for parts, runs in found.items():
        time_s = statistics.fmean(run.makespan_s for run in runs)
        lost = percents(runs)
        cells = [f"{parts:,}", f"{trials // parts:,}", f"{time_s:,.0f}", f"{sum(lost.values()):.1f} %"]
        cells += [f"{lost[name]:.1f}" for name in LOSSES]
        cells += [f"{statistics.fmean(run.deaths for run in runs):.0f}", f"{trials / time_s:,.0f}",
                  f"{(trials * BYTES_OF_TRIAL + parts * BYTES_OF_HEAD) / 1e6:,.0f}"]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def draw(found_by_name, path):
    """Time lost over the number of parts; needs matplotlib."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, len(found_by_name), figsize=(5.2 * len(found_by_name), 3.8), sharey=True, squeeze=False)
    names = {"starting": "starting parts", "appending": "writing trials", "dying": "dead workers", "waiting": "scheduler",
             "last": "waiting for the last"}
    for axis, (title, found) in zip(axes[0], found_by_name.items(), strict=True):
        lost = [percents(runs) for runs in found.values()]
        places = range(len(found))
        below = [0.0] * len(lost)
        for name, label in names.items():
            heights = [one[name] for one in lost]
            axis.bar(places, heights, bottom=below, label=label, width=0.7)
            below = [a + b for a, b in zip(below, heights, strict=True)]
        axis.set_xticks(list(places), [f"{parts:,}" for parts in found], rotation=45, ha="right")
        axis.set_xlabel("parts")
        axis.set_title(title, fontsize=10)
        axis.set_ylim(0, 120)
        axis.grid(axis="y", alpha=0.3)
    axes[0][0].set_ylabel("added to the time of the work alone [%]")
    axes[0][-1].legend(fontsize=8, loc="upper left")
    figure.tight_layout()
    figure.savefig(path, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--times", required=True, metavar="SHARD", help="a shard.parloc: how long trials take")
    parser.add_argument("--mean", type=float, nargs="+", metavar="S", help="scale them to these means, one table each")
    parser.add_argument("--workers", type=int, default=WORKERS, metavar="N", help=f"so many ({WORKERS})")
    parser.add_argument("--runs", type=int, default=3, metavar="N", help="of each number of parts (3)")
    parser.add_argument("--dispatch", type=float, default=Cluster.dispatch_s, metavar="S", help="of the scheduler per part")
    parser.add_argument("--plot", metavar="PNG", help="draw it there")
    options = parser.parse_args()
    cluster = Cluster(workers=options.workers, dispatch_s=options.dispatch)
    measured_s = times_of_shard(options.times)
    found_by_name = {}
    for mean_s in options.mean or [statistics.fmean(measured_s)]:
        found = {}
        for parts in PARTS:
            found[parts] = [simulate(drawn_times(measured_s, mean_s, TRIALS, seed), parts, cluster, seed)
                            for seed in range(1, options.runs + 1)]
        title = f"trials of {mean_s:g} s: {TRIALS * mean_s / options.workers:,.0f} s of work for each worker"
        found_by_name[title] = found
        print(f"{title}\n\n{table(found, TRIALS)}\n", flush=True)
    print(cluster)
    merge_s, merge_mb = TRIALS * MERGE_S_PER_TRIAL, TRIALS * MERGE_BYTES_PER_TRIAL / 1e6
    print(f"merge (scaled from docs/results/shards.md): {merge_s:.0f} s, {merge_mb:.0f} MB")
    if options.plot:
        draw(found_by_name, options.plot)


if __name__ == "__main__":
    main()
