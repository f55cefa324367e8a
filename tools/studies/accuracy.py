#!/usr/bin/env python3
"""Measures the accuracy of `parloc run` and writes a page (Markdown) with all values beside it (JSON).

    tools/studies/accuracy.py paper     the experiment of Paz et al. 2012: 15 configurations, simulated logs
    tools/studies/accuracy.py logs      real logs with a known start

Every run has one thread and is deterministic, so the errors are the same for any --jobs and on any machine.
"""

import itertools
import math
import sys

import measuring
from logs import RECORDED
from measuring import JOBS, LOGS_FOLDER, ROOT, Failure, count, option
from pages import average, circumstances_text, first_lines, share_of, study, table, table_of_groups, where, within, worst
from runs import common_values, files_of, localize, rms, simulate

PARTICLES, BEAMS = (500, 1000, 2000, 3000, 4000), (50, 100, 200)
PAPER_MAP, PAPER_SCENARIO, PAPER_CONFIG = "maps/hall_obstacles.yaml", "configs/paz2012_scenario.yaml", "configs/paz2012.yaml"
SETTLING_S = 1.0  # the maximum counts from here on
PAPER_BARS = {"mean_m": 0.015, "max_settled_m": 0.06, "heading_rmse_deg": 0.6}

SLOW_RAD_S = 0.02  # below this yaw rate the interpolated truth of tb3_house is good in heading
LOG_BARS = {
    "intel": {"mean_m": 0.080, "max_m": 0.35, "relation_m": 0.045},
    "aces": {"mean_m": 0.075, "max_m": 0.40, "relation_m": 0.050},
    "tb3_house": {"rmse_m": 0.03, "heading_rmse_deg": 1.25, "heading_rmse_slow_deg": 0.8},
    "malaga_corridor": {},
    "malaga_faculty": {},
}


# ---- The paper's experiment --------------------------------------------------------------------------------------------


def paper_run(bench, particles, beams, seed):
    files = files_of(PAPER_MAP, bench.folder / f"log_{seed}")
    metrics, errors, _ = localize(bench, f"{particles}x{beams}_{seed}", seed, [
        *files, "--config", PAPER_CONFIG, "--particles", particles, "--beams", beams])
    settled = [e[1] for e in errors if e[0] >= errors[0][0] + SETTLING_S]
    values = {"particles": particles, "beams": beams, "seed": seed, **common_values(metrics), "max_settled_m": max(settled)}
    config = metrics["config"]
    del config["particles"], config["scan"]["max_beams"]  # differ between runs
    return {**values, "within_bars": within(values, PAPER_BARS), "config": config, "backend": metrics["backend"]}


def good_text(runs):
    return share_of(runs, lambda run: run["within_bars"])


def paper_table(runs):
    """One row per configuration, then the worst of all."""
    keys = sorted({(run["particles"], run["beams"]) for run in runs})
    groups = {(f"{n}", f"{b}"): where(runs, particles=n, beams=b) for n, b in keys}
    return table_of_groups(("particles", "beams"), {**groups, ("**all**", ""): runs}, {
        "mean of means": average("mean_m", 2, 100), "worst mean": worst("mean_m", 2, 100),
        f"worst maximum after {SETTLING_S:g} s": worst("max_settled_m", 2, 100),
        "worst heading RMSE": worst("heading_rmse_deg", 3), "runs within all bars": good_text})


def paper_page(record):
    runs, config = record["runs"], record["config"]
    title = f"The experiment of Paz et al. 2012: 15 configurations, {len({run['seed'] for run in runs})} seeds"
    return f"""{first_lines(title, record)}
Position errors in cm, heading errors in degrees. "Worst" is the worst of the seeds.

{paper_table(runs)}

Bars: mean position error at most {100 * PAPER_BARS["mean_m"]:.1f} cm, never more than {100 * PAPER_BARS["max_settled_m"]:.0f} cm after the first second, heading RMSE at most {PAPER_BARS["heading_rmse_deg"]}
degrees; in every run.

## What is measured

- A log per seed: `parloc simulate --scenario {PAPER_SCENARIO} --seed S`, a 17 m path with stops to turn in a map
  of 20 x 10 m. Rays are cast in the 1 cm map, the filter gets the 5 cm one ([the simulator](../simulator.md)).
- On it, per configuration: `parloc run --map {PAPER_MAP} --config {PAPER_CONFIG} --particles N --beams B --seed S
  --log LOG --truth TRUTH --threads 1 --json`. The filter starts at the true pose with a spread of
  {config["initial_sigma_xy"]} m and {config["initial_sigma_theta"]} rad.
- An error is the distance, or the heading's difference, between the reported pose and the true one at the stamp of a scan. The
  mean and the RMSE are over all scans of a run, the first second included.
- The configuration is [{PAPER_CONFIG}](../../{PAPER_CONFIG}); its sensor model is `{config["sensor"]["model"]}`, sigma {config["sensor"]["sigma_hit"]} m,
  tempering {config["sensor"]["tempering"]}. [How it was chosen](README.md#how-the-configuration-of-the-papers-experiment-was-chosen). The JSON file has every value of
  it, and every run with the digest of its particles.

{circumstances_text(record)}"""  # noqa: E501


def paper(bench):
    """the experiment of Paz et al. 2012"""
    seeds = range(1, bench.args.seeds + 1)
    for seed in seeds:
        simulate(bench, PAPER_SCENARIO, seed, f"log_{seed}")
    return study(bench, "paz2012_accuracy", paper_run, list(itertools.product(PARTICLES, BEAMS, seeds)), lambda key, run: (
        f"{key[0]} particles x {key[1]} beams, seed {key[2]}: mean {100 * run['mean_m']:.2f} cm, maximum "
        f"{100 * run['max_settled_m']:.2f} cm, heading {run['heading_rmse_deg']:.3f} deg"
        f"{'' if run['within_bars'] else '  MISSED'}"), paper_page, what="paper", bars=PAPER_BARS)


# ---- Real logs ---------------------------------------------------------------------------------------------------------


def log_files(name, data):
    """Options of `parloc run` for one log."""
    home, shipped = data / name, ROOT / "maps/logs"
    if name in RECORDED:
        files = {"--map": home / RECORDED[name], "--log": home / "scans.log", "--truth": home / "reference.tum"}
    else:
        files = {"--map": ROOT / f"maps/{name}.yaml", "--log": shipped / f"{name}.log.gz", "--truth": shipped / f"{name}.tum"}
    if "relation_m" in LOG_BARS[name]:
        files["--relations"] = home / "relations.txt"
    for path in files.values():
        if not path.is_file():
            raise Failure(2, f"{path}: not found; give the folder of the real logs with --data or PARLOC_DATA, or --shipped "
                             "for the logs in maps/logs alone")
    return [part for option in files.items() for part in option]


def log_run(bench, name, seed):
    metrics, errors, truth = localize(bench, f"{name}_{seed}", seed, log_files(name, bench.args.data))
    values = {"log": name, "seed": seed, **common_values(metrics)}
    if metrics["relations"]:
        values["relation_m"] = metrics["relations"]["translation_mean_m"]
        values["relation_std_m"] = metrics["relations"]["translation_std_m"]
        values["relations"] = metrics["relations"]["compared"]
    bars = LOG_BARS[name]
    if "heading_rmse_slow_deg" in bars:
        rates = [truth.yaw_rate(e[0]) for e in errors]
        slow = [e[2] for e, rate in zip(errors, rates, strict=True) if rate is not None and abs(rate) < SLOW_RAD_S]
        values.update(heading_rmse_slow_deg=math.degrees(rms(slow)), slow_scans=len(slow))
    if bars:
        values["within_bars"] = within(values, bars)
    return {**values, "config": metrics["config"], "backend": metrics["backend"]}


LOG_COLUMNS = (("mean_m", "mean [m]", 4), ("max_m", "maximum [m]", 3), ("rmse_m", "RMSE [m]", 4),
               ("heading_rmse_deg", "heading RMSE [deg]", 3), ("heading_rmse_slow_deg", "the same, hardly turning [deg]", 3),
               ("relation_m", "relation error [m]", 4))


def log_cells(run, bars):
    """Values of a run, each with its bar if it has one."""
    texts = {key: f"{run[key]:.{decimals}f}" if key in run else "" for key, _, decimals in LOG_COLUMNS}
    return [f"{text} (<= {bars[key]:g})" if key in bars else text for key, text in texts.items()]


def log_tables(runs):
    """The worst of each log beside its bars, and every run."""
    header = [title for _, title, _ in LOG_COLUMNS]
    worst_rows = []
    for name in dict.fromkeys(run["log"] for run in runs):
        group, bars = where(runs, log=name), LOG_BARS[name]
        worsts = {key: max(run[key] for run in group) for key, _, _ in LOG_COLUMNS if key in group[0]}
        worst_rows.append((name, *log_cells(worsts, bars), good_text(group) if bars else "no bars"))
    all_rows = [(run["log"], str(run["seed"]), *log_cells(run, {})) for run in runs]
    return (table(("log", *header, "runs within all bars"), worst_rows), table(("log", "seed", *header), all_rows))


def logs_page(record):
    runs, config = record["runs"], record["config"]
    worst_of_each, every = log_tables(runs)
    relations = {run["log"]: run["relations"] for run in runs if "relations" in run}
    slow = next((run["slow_scans"] for run in runs if "slow_scans" in run), None)
    return f"""{first_lines("Real logs, known start, default configuration", record)}
The default configuration, unchanged, for every log: sensor model `{config["sensor"]["model"]}`, {config["particles"]} particles, {config["scan"]["max_beams"]} beams. The worst of
{len({run["seed"] for run in runs})} seeds, and in brackets the bar:

{worst_of_each}

## Every run

{every}

## What is measured

- `parloc run --map MAP --log LOG --truth TRUTH [--relations RELATIONS] --seed S --threads 1 --json`; no configuration file. The
  start is the truth's pose at the first scan, with the default spread. tb3_house runs on `map_05`.
- Mean, maximum and RMSE are over every scan: the distance between the reported pose and the truth at the stamp of the scan.
- The relation error (Kuemmerle et al. 2009) compares the motion between two scans with verified relations, and needs no global
  truth: the mean over {" and ".join(f"{count} relations of {log}" for log, count in relations.items()) or "all relations"}.
- "Hardly turning" is where the truth turns by less than {SLOW_RAD_S} rad/s{f" ({slow} of the scans)" if slow else ""}. The truth of tb3_house has one row per second;
  while the robot turns, a pose between two rows is itself wrong by about a degree.

## How good the truths are

- intel, aces: published trajectories of a SLAM program, 3 to 6 cm from the true ones; the maps were built from the same drives.
  Claim nothing below 5 cm here: the relation error is the better figure.
- tb3_house: exact, it is a simulation by others.
- malaga_*: nobody surveyed these drives. The reference is every scan laid on the map, good to 2 to 3 cm and 0.1 degrees within the
  map. **The faculty's map holds the very scans that are localized on it**: an error measured there is flattering. The corridor's
  map is from the day before. [maps/logs/README.md](../../maps/logs/README.md) says more.

{circumstances_text(record)}"""  # noqa: E501


def logs(bench):
    """real logs, known start"""
    names = [name for name in LOG_BARS if name not in RECORDED or not bench.args.shipped]
    for name in names:
        log_files(name, bench.args.data)  # says what is missing before anything is measured
    keys = list(itertools.product(names, range(1, bench.args.seeds + 1)))
    return study(bench, "real_logs", log_run, keys, lambda key, run: (
        f"{key[0]}, seed {key[1]}: mean {run['mean_m']:.4f} m, maximum {run['max_m']:.3f} m, heading "
        f"{run['heading_rmse_deg']:.3f} deg{'' if run.get('within_bars', True) else '  MISSED'}"), logs_page,
        what="logs", bars={name: LOG_BARS[name] for name in names})


if __name__ == "__main__":
    sys.exit(measuring.study(__doc__, {
        paper: (count("--seeds", 20, "seeds 1 to N"), JOBS),
        logs: (count("--seeds", 5, "seeds 1 to N"), JOBS, LOGS_FOLDER,
               option("--shipped", False, "only the logs that ship in maps/logs", action="store_true"))}))
