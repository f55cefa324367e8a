#!/usr/bin/env python3
"""Runs `parloc compare` for docs/results/compare.md: writes that page (Markdown) with all values beside it (JSON).

    tools/studies/compare_filters.py [--seeds N] [--seed FIRST] [--jobs K] [--parts PART ...] [--out DIR] [--parloc FILE] [--data DIR]

Parts: house (the simulated drive at three noises of the wheels), followup (in the setting of the study's follow-up), speed (one seed, one
filter at a time), logs (recorded ones), troubles (wrong starts, a kidnapping, clutter). A part that is not asked for stays as the JSON
file has it. Errors are the same for any --jobs and on any machine. The first seed is 21, for settings were tuned on seeds 1 to 5.
Needs Python 3.10, a built program and the folder of the maps and logs.

Exit code: 0 all bars kept, 1 a bar missed, 2 wrong usage or a missing file, 3 a run of parloc failed, 130 interrupted: parts that
are finished are written in any case.
"""

import argparse
import json
import os
import pathlib
import sys

import accuracy
from accuracy import DATA, Failure, table

SCENARIO = "configs/tb3_house_scenario.yaml"
KAPPAS = ("1e-6", "1e-4", "5e-3")
TUNED = "1 to 5"  # seeds that settings were chosen on
FORMAT = 2  # of the JSON file: lost runs are not in the means
FOLLOWUP, FOLLOWUP_KAPPA = "configs/tb3_house_followup_scenario.yaml", "5e-4"
STUDY = "configs/csuzdi2021.yaml"
PARTICLES = (10, 100, 500)
FLOWS = ("edh", "naedh", "ledh", "gromov", "pfpf")
SLOW = (("ledh", 500), ("pfpf", 500))  # a quarter of the seeds
HOUSE = ",".join(["mcl", *[f"mcl@{n}" for n in PARTICLES], "amcl=configs/compare/turtlebot3.yaml", "amcl", f"ekf={STUDY}", "ekf",
                  "ekf_beams", f"edh@100={STUDY}", *[f"{kind}@{n}" for kind in FLOWS for n in PARTICLES if (kind, n) not in SLOW]])
SLOWEST = ",".join(f"{kind}@{n}" for kind, n in SLOW)
MANY = "edh@100000,edh@1000000"
FILTERS = ",".join(["mcl", "amcl", "ekf", "ekf_beams", *[f"{kind}@100" for kind in FLOWS]])
PUBLISHED = ",".join(["amcl=configs/compare/turtlebot3.yaml", f"ekf={STUDY}", f"edh@100={STUDY}"])
LOGS = {"tb3_house": "map_05.yaml", "intel": "map.yaml", "aces": "map.yaml"}
TROUBLE_KAPPA = "1e-4"
TROUBLES = {  # name: arguments
    "none": [],
    "start 0.2 m off": ["--start-error", "0.2,0", "--duration", 120],
    "0.5 m": ["--start-error", "0.5,0", "--duration", 120],
    "1 m": ["--start-error", "1,0", "--duration", 120],
    "start 10 deg off": ["--start-error", "0,10", "--duration", 120],
    "30 deg": ["--start-error", "0,30", "--duration", 120],
    "60 deg": ["--start-error", "0,60", "--duration", 120],
    "0.5 m (told)": ["--start-error", "0.5,0", "--sigma", "0.5,0.05", "--duration", 120],
    "1 m (told)": ["--start-error", "1,0", "--sigma", "1,0.05", "--duration", 120],
    "30 deg (told)": ["--start-error", "0,30", "--sigma", "0.1,0.52", "--duration", 120],
    "60 deg (told)": ["--start-error", "0,60", "--sigma", "0.1,1.05", "--duration", 120],
    "kidnapped by 2 m": ["--kidnap", "30..180,2", "--duration", 240],
    "clutter 5 %": ["--people", 1],
    "clutter 20 %": ["--people", 7],
}
BEST = {"position_rmse_m": 0.02, "heading_rmse_rad": 0.01}  # of any filter at kappa = 1e-4
SPEED = {"edh@100": 5000, "mcl": 20}  # times real time


def compare(program, work, name, arguments):
    out = work / name
    program("compare", "--quiet", "--out", out, *arguments)
    text = (out / "compare.json").read_text()
    for folder, name_of in ((os.environ["PARLOC_DATA"], "$PARLOC_DATA"), (f"{accuracy.ROOT}/", ""), (f"{work}/", "")):
        text = text.replace(folder, name_of)
    return json.loads(text)


def slim(result):
    """Without what is the same in all, build, machine and whole configurations, and without the single runs: the command repeats them."""
    return {"command": result["command"], "plan": result["plan"], "published": result["published"],
            "filters": [{k: v for k, v in f.items() if k not in ("config", "each")} for f in result["filters"]],
            "times": {k: result["times"][k] for k in ("jobs", "wall_s", "filters")}}


# ---- Parts -------------------------------------------------------------------------------------------------------------


def house(args, run):
    results = {}
    for kappa in KAPPAS:
        common = ["--scenario", SCENARIO, "--kappa", kappa, "--config", f"configs/compare/kappa_{kappa}.yaml", "--seed", args.seed,
                  "--jobs", args.jobs]
        results[kappa] = run(f"house_{kappa}", [*common, "--filters", HOUSE, "--seeds", args.seeds])
        slow = run(f"house_{kappa}_slow", [*common, "--filters", SLOWEST, "--seeds", max(1, args.seeds // 4)])
        results[kappa]["filters"] += slow["filters"]
    return results


def followup(args, run):
    return run("followup", ["--scenario", FOLLOWUP, "--config", f"configs/compare/kappa_{FOLLOWUP_KAPPA}.yaml", "--filters",
                            f"{PUBLISHED},{FILTERS}", "--seed", args.seed, "--seeds", args.seeds, "--jobs", args.jobs])


def speed(args, run):
    return run("speed", ["--scenario", SCENARIO, "--config", f"configs/compare/kappa_{TROUBLE_KAPPA}.yaml", "--filters",
                         f"{HOUSE},{SLOWEST},{MANY}", "--seed", args.seed, "--seeds", 1])


def logs(args, run):
    results = {}
    for name, grid in LOGS.items():
        home = args.data / name
        results[name] = run(f"log_{name}", ["--log", home / "scans.log", "--truth", home / "reference.tum", "--map", home / grid,
                                            "--filters", FILTERS, "--seed", args.seed, "--seeds", min(5, args.seeds), "--jobs",
                                            args.jobs])
    return results


def troubles(args, run):
    return {name: run(f"trouble_{k}", ["--scenario", SCENARIO, "--kappa", TROUBLE_KAPPA, "--config",
                                       f"configs/compare/kappa_{TROUBLE_KAPPA}.yaml", "--filters", FILTERS, "--seed", args.seed,
                                       "--seeds", args.seeds, "--jobs", args.jobs, *more]) for k, (name, more) in enumerate(TROUBLES.items())}


PARTS = {"house": house, "followup": followup, "speed": speed, "logs": logs, "troubles": troubles}


# ---- Bars --------------------------------------------------------------------------------------------------------------


def by_name(result):
    return {f["filter"]: f for f in result["filters"]}


def published(result, kind, particles=0):
    return next(r for r in result["published"]["rows"] if r["filter"] == kind and r["particles"] in (0, particles))


def within(row, limits):
    """Its means are within the limits and no run was lost: the mean of the runs that were not is no figure of all."""
    return row["lost"] == 0 and all(row[key]["mean"] <= most for key, most in limits.items())


def best_of(filters):
    """The filter that keeps both limits best, None if none of them keeps both."""
    kept = [f for f in filters.values() if within(f, BEST)]
    return min(kept, key=lambda f: f["position_rmse_m"]["mean"] / 0.02 + f["heading_rmse_rad"]["mean"] / 0.01, default=None)


def judged(record):
    """[(what, figures, holds)]"""
    bars = []
    for kappa, result in record.get("house", {}).items():
        filters = by_name(result)
        for name, kind in (("edh@100", "edh"), ("ekf", "ekf")):
            theirs, ours = published(result, kind, 100), filters[name]
            limits = {key: theirs[key] for key in BEST}
            bars.append((f"{name} at kappa = {kappa} m: no run lost, at or under the published RMSE, {limits['position_rmse_m']:.4f} m and "
                         f"{limits['heading_rmse_rad']:.4f} rad",
                         f"{ours['lost']} lost, {number(ours['position_rmse_m']['mean'], 4)} m, "
                         f"{number(ours['heading_rmse_rad']['mean'], 4)} rad", within(ours, limits)))
        if kappa == "1e-4":
            best = best_of(filters)
            text = f"{best['filter']}: {best['position_rmse_m']['mean']:.4f} m, {best['heading_rmse_rad']['mean']:.4f} rad" if best else "none"
            bars.append((f"the best filter at kappa = {kappa} m: no run lost, RMSE at most 0.02 m and 0.01 rad", text, best is not None))
    for f in record.get("speed", {}).get("times", {}).get("filters", []):
        if f["filter"] in SPEED:
            # Of one step of the median time: other work on the machine makes a few steps long.
            median = 200.0 / f["step_median_ms"]
            bars.append((f"{f['filter']}, one thread: at least {SPEED[f['filter']]} times real time",
                         f"{f['real_time_factor']:.0f} times over all steps, {median:.0f} times by the median step",
                         median >= SPEED[f["filter"]]))
    return bars


# ---- Page --------------------------------------------------------------------------------------------------------------


def number(value, decimals):
    return "-" if value is None else f"{value:.{decimals}f}"


def spread(pair, decimals):
    if pair["mean"] is None or pair["deviation"] is None:
        return number(pair["mean"], decimals)
    return f"{pair['mean']:.{decimals}f} +- {pair['deviation']:.{decimals}f}"


def lost_text(f):
    when = f", after {f['lost_s']['mean']:.0f} s" if f["lost"] else ""
    return f"{f['lost']} of {f['runs']}{when}"


def error_rows(result):
    rows = []
    for f in result["filters"]:
        rows.append([f["filter"], lost_text(f), f"{100 * f['away']:.1f} %", spread(f["position_rmse_m"], 4), spread(f["position_mae_m"], 4),
                     spread(f["position_max_m"], 3), spread(f["heading_rmse_rad"], 4), spread(f["heading_mae_rad"], 4),
                     spread(f["nees"], 2)])
        if result["published"]:
            kind, particles = f["kind"], round(f["particles"])
            row = next((r for r in result["published"]["rows"] if r["filter"] == kind and r["particles"] in (0, particles)), None)
            rows[-1].append(f"{row['position_rmse_m']:.4f} / {row['heading_rmse_rad']:.4f}" if row else "")
    return rows


def error_table(result):
    header = ["filter", "lost", "> 0.5 m", "RMSE [m]", "MAE [m]", "largest [m]", "heading RMSE [rad]", "heading MAE [rad]", "NEES"]
    if result["published"]:
        header.append("published RMSE [m] / [rad]")
    return table(header, error_rows(result))


def seeds_text(result):
    first, count = result["plan"]["first_seed"], result["plan"]["seeds"]
    return f"seeds {first} to {first + count - 1}" if count > 1 else f"seed {first}"


def house_text(results):
    text = (f"\n## The drive through the house\n\nMean +- standard deviation over {seeds_text(next(iter(results.values())))}, which change the "
            f"odometry, the ranges and the filter. {SLOWEST.replace(',', ' and ')} have the first quarter of the seeds: they are slow.\n")
    for kappa, result in results.items():
        text += f"\n### kappa = {kappa} m\n\n{error_table(result)}\n"
    return text


def followup_text(result):
    rows = [(r["name"], f"{r['position_rmse_m']:.4f}", f"{r['heading_rmse_rad']:.4f}", number(r["step_ms"], 2))
            for r in result["published"]["rows"]]
    return (f"\n## The setting of the follow-up\n\nThe same drive with kappa = {FOLLOWUP_KAPPA} m, ranges of 2 cm noise and the 1 cm map, "
            f"{seeds_text(result)}. No bar was set for it.\n\n{error_table(result)}\n\nPublished, all rows (AMCL+ weighs every scan, as `amcl` "
            f"here; times are theirs, in ROS):\n\n{table(('filter', 'RMSE [m]', 'heading RMSE [rad]', 'step [ms]'), rows)}\n")


def growth_text(result):
    """How the cost grows with very many particles."""
    median_ms = {f["filter"]: f["step_median_ms"] for f in result["times"]["filters"]}
    fewer, more = MANY.split(",")
    if fewer not in median_ms or more not in median_ms:
        return ""
    return f"\nTen times the particles: a step of {more} takes {median_ms[more] / median_ms[fewer]:.1f} times as long as one of {fewer}.\n"


def speed_text(result):
    rows = [(f["filter"], f"{f['step_median_ms']:.4f}", f"{f['step_p99_ms']:.4f}", f"{f['real_time_factor']:.0f}")
            for f in result["times"]["filters"]]
    return ("\n## Times of a step\n\nOne seed of the drive, one filter at a time, one thread. Other work ran on the machine; it is in p99 and "
            "in the last column.\n\n" + table(("filter", "median [ms]", "p99 [ms]", "times real time"), rows) + "\n" + growth_text(result))


def logs_text(results):
    return f"\n## Recorded logs\n\nOf the filter only: {seeds_text(next(iter(results.values())))}.\n" + "".join(f"\n### {name}\n\n{error_table(result)}\n" for name, result in results.items())


def clutter_cells(f):
    return spread(f["position_rmse_m"], 4), f"{100 * f['away']:.1f} %"


def troubles_text(results):
    names = list(by_name(results["none"]))
    rows, limits = [], []
    for name in names:
        cells = [by_name(result)[name] for result in results.values()]
        rows.append([name, *[f"{f['lost']}" for f in cells]])
        broken = [trouble for trouble, f in zip(results, cells) if 2 * f["lost"] > f["runs"]]
        some = [f"{trouble} ({f['lost']})" for trouble, f in zip(results, cells) if 0 < f["lost"] and 2 * f["lost"] <= f["runs"]]
        limits.append([name, ", ".join(broken) or "nothing", ", ".join(some) or "nothing"])
    runs = cells[0]["runs"]
    hits = ", ".join(f"{name}: {100 * r['plan']['unmapped_hits']:.1f} %" for name, r in results.items() if r["plan"]["unmapped_hits"])
    text = (f"\n## Where each filter breaks\n\nRuns lost of {runs}, {seeds_text(results['none'])}, at kappa = {TROUBLE_KAPPA} m. \"Told\": the spread that the filter starts "
            f"with is as large as the error; else it is 0.1 m and 0.05 rad. Robots are kidnapped at 30 to 180 s, by the seed. Hits on what is not on the map: {hits}.\n\n")
    text += table(["filter", *results], rows) + "\n\n" + table(["filter", "loses most runs to", "loses some runs to"], limits) + "\n"
    clutter = [name for name in results if name.startswith("clutter") or name == "none"]
    rows = [[name, *[cell for c in clutter for cell in clutter_cells(by_name(results[c])[name])]] for name in names]
    header = ["filter", *[text for c in clutter for text in (c, "> 0.5 m")]]
    return text + ("\nPosition RMSE in m of the runs that kept their robot, and the share of all scans at which a run was farther than 0.5 m "
                   "off, lost or not:\n\n" + table(header, rows) + "\n")


def where_text(record):
    keys = ("command", "date", "commit", "program", "compiler", "machine", "system")
    rows = [(part, *[f"`{where[key]}`" if key == "command" else where[key] for key in keys])
            for part, where in record["where"].items()]
    return f"\n## Where and when\n\n{table(('part', *keys), rows)}\n\nBackend: {record['backend']}.\n"


TEXTS = {"house": house_text, "followup": followup_text, "speed": speed_text, "logs": logs_text, "troubles": troubles_text}


def page(record):
    text = ("# Filters compared\n\nWhat this is, how to read it and when to choose which filter: [compare](../compare.md). Settings were tuned on "
            f"seeds {TUNED}; each part says of which ones its figures are. A run is lost if it is farther than 0.5 m off at its end. The means of errors and NEES are "
            "of the runs that kept their robot; a bar is kept only without a lost run.\n")
    rows = [(what, figures, "kept" if holds else "**missed**") for what, figures, holds in judged(record)]
    if rows:
        text += "\n" + table(("bar", "measured", ""), rows) + "\n"
    for part, text_of in TEXTS.items():
        if part in record:
            text += text_of(record[part])
    return text + where_text(record)


def earlier_parts(path):
    """What the file has of earlier measurements; nothing if its figures mean something else."""
    record = json.loads(path.read_text()) if path.is_file() else {"format": FORMAT}
    if record.get("format") == FORMAT:
        return record
    print(f"{path}: of an earlier format, its parts are dropped", file=sys.stderr)
    return {"format": FORMAT}


def run(args, program, work):
    path = args.out / "compare.json"
    record = earlier_parts(path)
    os.environ["PARLOC_DATA"] = str(args.data)
    if not (args.data / "tb3_house" / "map_01.yaml").is_file():
        raise Failure(2, f"{args.data}/tb3_house: not found; give the folder of the maps and logs with --data or PARLOC_DATA")
    here = accuracy.circumstances(program)  # before the first result changes a file
    here["command"] = "tools/studies/compare_filters.py " + " ".join(sys.argv[1:])
    for part in args.parts:
        def timed(name, arguments):
            result = compare(program, work, name, arguments)
            record["backend"] = result["times"]["filters"][0]["backend"]
            print(f"{part}: {name} done in {result['times']['wall_s']:.0f} s", file=sys.stderr, flush=True)
            return slim(result)
        record[part] = PARTS[part](args, timed)
        record.setdefault("where", {})[part] = here
        path.write_text(json.dumps(record, indent=1) + "\n")
        (args.out / "compare.md").write_text(page(record).rstrip() + "\n")
        print(path, file=sys.stderr)
    return 0 if all(holds for _, _, holds in judged(record)) else 1


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=accuracy.positive, default=20, metavar="N", help="how many (20)")
    parser.add_argument("--seed", type=accuracy.positive, default=21, metavar="FIRST", help="first seed (21)")
    parser.add_argument("--jobs", type=accuracy.positive, default=1, metavar="K", help="seeds at a time, but for speed (1)")
    parser.add_argument("--parts", nargs="+", choices=PARTS, default=list(PARTS), metavar="PART", help="what to run (all)")
    parser.add_argument("--out", type=pathlib.Path, default=accuracy.OUT, metavar="DIR", help="folder for the page (docs/results)")
    parser.add_argument("--parloc", default=accuracy.ROOT / "build/cpu/parloc", metavar="FILE", help="the program (build/cpu/parloc)")
    parser.add_argument("--data", type=pathlib.Path, default=DATA, metavar="DIR", help="folder of the logs (PARLOC_DATA, else ../shared/data)")
    args = parser.parse_args()
    args.out, args.data, args.parloc = args.out.absolute(), args.data.absolute(), pathlib.Path(args.parloc).absolute()
    return args


def main():
    args = parse_arguments()
    return accuracy.run_tool("compare_filters", args, run)


if __name__ == "__main__":
    sys.exit(main())
