#!/usr/bin/env python3
"""Measures what deskewing is worth and writes a page (Markdown) with all values beside it (JSON).

Every seed is driven twice, with scans taken in an instant and with scans of 0.1 s, all noise being the same. The filter is
run on the first, and on the second without and with knowing the scan time.
"""

import math
import re
import statistics
import sys

import measuring
from measuring import ROOT, count
from pages import circumstances, circumstances_text, table, where, write_results
from runs import files_of, localize, rms, simulate

SCAN_TIME_S = 0.1
STAMPS = ("first", "middle", "last")
BAR = 0.8  # of the error that ignoring the scan time causes, wherever the stamp lies
TURNING_RAD_S = 0.9
# Scene: scenario, the filter's configuration, whether only scans while turning count.
SCENES = {
    "spin": ("configs/spin_scenario.yaml", "configs/spin.yaml", True),
    "office": ("configs/office_scenario.yaml", None, False),
}


def config_text(path, scan_time_s, stamp_at):
    text = (ROOT / path).read_text() if path else ""
    text = re.sub(r"^lidars:\n(?:[ #].*\n|\n)*", "", text, flags=re.MULTILINE)
    return f"{text}\nlidars:\n  robotlaser1: {{scan_time: {scan_time_s}, stamp_at: {stamp_at}}}\n"


def errors_of(bench, name, scene, seed, log, told_s, stamp_at):
    """RMSE of one run over the scans that count."""
    scenario, config, turning_only = SCENES[scene]
    grid = re.search(r"^localization_map: \.\./(\S+)", (ROOT / scenario).read_text(), re.MULTILINE)[1]
    metrics, errors, truth = localize(bench, name, seed, files_of(grid, log), config_text(config, told_s, stamp_at))
    if turning_only:
        errors = [e for e in errors if abs(truth.yaw_rate(e[0]) or 0.0) > TURNING_RAD_S]
    return {"heading_deg": math.degrees(rms([e[2] for e in errors])), "position_m": rms([e[1] for e in errors]),
            "scans": len(errors), "digest": metrics["digest"], "backend": metrics["backend"]}


def one_seed(bench, scene, seed):
    """{instant, ignored and deskewed by stamp} of one drive."""
    def errors(name, scan_time_s, stamp_at, told):
        """By what the filter is told of the scan time: {name: seconds}."""
        log, _ = simulate(bench, SCENES[scene][0], seed, f"{scene}_{seed}_{name}",
                          {"scan_time": scan_time_s, "stamp_at": stamp_at})
        return {kind: errors_of(bench, f"{log.name}_{kind}_run", scene, seed, log, told_s, stamp_at)
                for kind, told_s in told.items()}

    told = {"ignored": 0, "deskewed": SCAN_TIME_S}
    return {"scene": scene, "seed": seed, **errors("instant", 0, "first", {"instant": 0}),
            **{stamp_at: errors(stamp_at, SCAN_TIME_S, stamp_at, told) for stamp_at in STAMPS}}


def removed(instant, ignored, deskewed):
    """The share of the error that ignoring the scan time causes which is gone."""
    return (ignored - deskewed) / (ignored - instant)


def summary(runs, scene, stamp_at, key):
    """Mean over the seeds of the three errors, the share removed, and the worst seed's share."""
    rows = [(r["instant"][key], r[stamp_at]["ignored"][key], r[stamp_at]["deskewed"][key])
            for r in where(runs, scene=scene)]
    means = [statistics.fmean(column) for column in zip(*rows, strict=True)]
    return means, removed(*means), min(removed(*row) for row in rows)


def scene_table(runs, scene):
    rows = []
    for stamp_at in STAMPS:
        for key, unit, factor in (("heading_deg", "heading [deg]", 1), ("position_m", "position [cm]", 100)):
            means, share, worst = summary(runs, scene, stamp_at, key)
            costs = (means[1] - means[0]) / means[0]
            # Where ignoring costs next to nothing, a share of it says nothing.
            shares = [f"{100 * share:.0f} %", f"{100 * worst:.0f} %"] if costs > 0.25 else ["-", "-"]
            rows.append([stamp_at, unit, *(f"{factor * m:.2f}" for m in means), *shares])
    header = ("stamp at beam", "RMSE of", "instant scans", "0.1 s, ignored", "0.1 s, deskewed", "removed", "worst seed")
    return table(header, rows)


def page(record):
    runs = record["runs"]
    kept = record["within_bar"]
    return f"""# What deskewing is worth

{"The bar is kept" if kept else "**The bar is missed**"}: at 1 rad/s and 10 scans a second, deskewing removes at least
{100 * BAR:.0f} % of the error that ignoring the scan time causes, in heading and in position, wherever the stamp lies, mean over
the seeds.

## Turning on the spot at 1 rad/s, {len(where(runs, scene="spin"))} seeds

{scene_table(runs, "spin")}

The LiDAR sits 0.2 m ahead of the base and needs 0.1 s for a turn. Only scans while the robot turns count.

## Five minutes in the office, {len(where(runs, scene="office"))} seeds

{scene_table(runs, "office")}

An ordinary drive: straight at 0.7 m/s, stops to turn at 0.9 rad/s. The same LiDAR as in `configs/office_scenario.yaml`, but with 0.1 s
per scan. All scans count.

## What is measured

- Per seed one drive is simulated with scans taken in an instant, and with scans of 0.1 s whose stamp is the time of the first,
  middle or last beam; odometry and noise are the same. `parloc run` localizes it with the default filter
  (`configs/spin.yaml` for the spin).
- Ignored: `scan_time: 0`, as if the scan were an instant. Deskewed: `scan_time: 0.1`.
- Removed: (ignored - deskewed) / (ignored - instant), of the means over the seeds; then that of the worst seed. A dash where ignoring
  the scan time costs less than a quarter more than instant scans have: there is nothing to remove.
- With the stamp at the first or last beam, ignoring the scan time turns the whole scan by half of what the robot turns meanwhile: most
  of the error is an offset, which the stamp of the middle beam would not have. What is left there is the blur.

{circumstances_text(record)}
"""  # noqa: E501


def run(bench):
    seeds = {"spin": bench.args.seeds, "office": max(1, bench.args.seeds // 4)}
    keys = [(scene, seed) for scene in SCENES for seed in range(1, seeds[scene] + 1)]
    facts = circumstances(bench.program)
    results, end = bench.measure(one_seed, keys, lambda key, r: (
        f"{key[0]}, seed {key[1]}: heading {r['instant']['heading_deg']:.2f}, ignored "
        f"{r['first']['ignored']['heading_deg']:.2f}, deskewed {r['first']['deskewed']['heading_deg']:.2f} deg"))
    if end:
        raise end
    runs = list(results.values())
    within = all(summary(runs, "spin", stamp_at, key)[1] >= BAR for stamp_at in STAMPS for key in ("heading_deg", "position_m"))
    record = {"partial": False, **facts, "backend": runs[0]["instant"]["backend"], "bar": BAR, "within_bar": within,
              "runs": runs}
    return write_results(bench, "deskew", record, page, within)


if __name__ == "__main__":
    sys.exit(measuring.study(__doc__, {run: (count("--seeds", 20, "seeds 1 to N, of the office a quarter"),
                                             count("--jobs", 1, "seeds at a time"))}))
