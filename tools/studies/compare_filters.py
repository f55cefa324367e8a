#!/usr/bin/env python3
"""Runs `parloc compare` for docs/results/compare.md: writes that page (Markdown) with all values beside it (JSON).

Parts: house (the simulated drive at three noises of the wheels), followup (in the setting of the study's follow-up), speed
(one seed, one filter at a time), logs (recorded ones), troubles (wrong starts, a kidnapping, clutter). A part that is not
asked for stays as the JSON file has it, and parts that are finished are written in any case. Errors are the same for any
--jobs and on any machine. The first seed is 21, for settings were tuned on seeds 1 to 5.
"""

import json
import os
import sys

import measuring
from logs import RECORDED
from measuring import LOGS_FOLDER, Failure, count, subset
from pages import CIRCUMSTANCES, bars_table, circumstance_cells, circumstances, fixed, table, table_of
from runs import report_of

SCENARIO = "configs/tb3_house_scenario.yaml"
KAPPAS = ("1e-6", "1e-4", "5e-3")
TUNED = "1 to 5"  # seeds that settings were chosen on
FORMAT = 2  # of the JSON file: lost runs are not in the means
FOLLOWUP, FOLLOWUP_KAPPA = "configs/tb3_house_followup_scenario.yaml", "5e-4"
STUDY = "configs/csuzdi2021.yaml"
PARTICLES = (10, 100, 500)
FLOWS = ("edh", "naedh", "ledh", "gromov", "pfpf")
SLOW = (("ledh", 500), ("pfpf", 500))  # a quarter of the seeds
TURTLEBOT = "amcl=configs/compare/turtlebot3.yaml"
HOUSE = ",".join(["mcl", *[f"mcl@{n}" for n in PARTICLES], TURTLEBOT, "amcl", f"ekf={STUDY}", "ekf", "ekf_beams",
                  f"edh@100={STUDY}", *[f"{kind}@{n}" for kind in FLOWS for n in PARTICLES if (kind, n) not in SLOW]])
SLOWEST = ",".join(f"{kind}@{n}" for kind, n in SLOW)
MANY = "edh@100000,edh@1000000"
FILTERS = ",".join(["mcl", "amcl", "ekf", "ekf_beams", *[f"{kind}@100" for kind in FLOWS]])
PUBLISHED = ",".join([TURTLEBOT, f"ekf={STUDY}", f"edh@100={STUDY}"])
TROUBLE_KAPPA = "1e-4"
TROUBLES = {  # name: arguments
    "none": [],
    **{name: ["--start-error", error, "--duration", 120] for name, error in (
        ("start 0.2 m off", "0.2,0"), ("0.5 m", "0.5,0"), ("1 m", "1,0"), ("start 10 deg off", "0,10"), ("30 deg", "0,30"),
        ("60 deg", "0,60"))},
    **{f"{name} (told)": ["--start-error", error, "--sigma", sigma, "--duration", 120] for name, error, sigma in (
        ("0.5 m", "0.5,0", "0.5,0.05"), ("1 m", "1,0", "1,0.05"), ("30 deg", "0,30", "0.1,0.52"),
        ("60 deg", "0,60", "0.1,1.05"))},
    "kidnapped by 2 m": ["--kidnap", "30..180,2", "--duration", 240],
    "clutter 5 %": ["--people", 1],
    "clutter 20 %": ["--people", 7],
}
BEST = {"position_rmse_m": 0.02, "heading_rmse_rad": 0.01}  # of any filter at kappa = 1e-4
SPEED = {"edh@100": 5000, "mcl": 20}  # times real time


def slim(result):
    """Without what is the same in all, build, machine and whole configurations, and without the single runs: the command
    repeats them."""
    return {"command": result["command"], "plan": result["plan"], "published": result["published"],
            "filters": [{k: v for k, v in f.items() if k not in ("config", "each")} for f in result["filters"]],
            "times": {k: result["times"][k] for k in ("jobs", "wall_s", "filters")}}


# ---- Parts -------------------------------------------------------------------------------------------------------------


def seeds_of(args, seeds, jobs=True):
    return ["--seed", args.seed, "--seeds", seeds, *(["--jobs", args.jobs] if jobs else [])]


def settings_at(kappa):
    return ["--config", f"configs/compare/kappa_{kappa}.yaml"]


def house(args, run):
    results = {}
    for kappa in KAPPAS:
        common = ["--scenario", SCENARIO, "--kappa", kappa, *settings_at(kappa)]
        results[kappa] = run(f"house_{kappa}", [*common, "--filters", HOUSE, *seeds_of(args, args.seeds)])
        slow = run(f"house_{kappa}_slow", [*common, "--filters", SLOWEST, *seeds_of(args, max(1, args.seeds // 4))])
        results[kappa]["filters"] += slow["filters"]
    return results


def followup(args, run):
    return run("followup", ["--scenario", FOLLOWUP, *settings_at(FOLLOWUP_KAPPA), "--filters", f"{PUBLISHED},{FILTERS}",
                            *seeds_of(args, args.seeds)])


def speed(args, run):
    return run("speed", ["--scenario", SCENARIO, *settings_at(TROUBLE_KAPPA), "--filters", f"{HOUSE},{SLOWEST},{MANY}",
                         *seeds_of(args, 1, jobs=False)])


def logs(args, run):
    results = {}
    for name in ("tb3_house", "intel", "aces"):
        home = args.data / name
        results[name] = run(f"log_{name}", [
            "--log", home / "scans.log", "--truth", home / "reference.tum", "--map", home / RECORDED[name],
            "--filters", FILTERS, *seeds_of(args, min(5, args.seeds))])
    return results


def troubles(args, run):
    common = ["--scenario", SCENARIO, "--kappa", TROUBLE_KAPPA, *settings_at(TROUBLE_KAPPA), "--filters", FILTERS,
              *seeds_of(args, args.seeds)]
    return {name: run(f"trouble_{k}", [*common, *more]) for k, (name, more) in enumerate(TROUBLES.items())}


PARTS = {"house": house, "followup": followup, "speed": speed, "logs": logs, "troubles": troubles}


# ---- Bars --------------------------------------------------------------------------------------------------------------


def by_name(result):
    return {f["filter"]: f for f in result["filters"]}


def published(result, kind, particles=0):
    """The published figures of a filter, None if there are none."""
    rows = result["published"]["rows"]
    return next((r for r in rows if r["filter"] == kind and r["particles"] in (0, particles)), None)


def within(row, limits):
    """Its means are within the limits and no run was lost: the mean of the runs that were not is no figure of all."""
    return row["lost"] == 0 and all(row[key]["mean"] <= most for key, most in limits.items())


def best_of(filters):
    """The filter that keeps both limits best, None if none of them keeps both."""
    kept = [f for f in filters.values() if within(f, BEST)]
    return min(kept, key=lambda f: f["position_rmse_m"]["mean"] / 0.02 + f["heading_rmse_rad"]["mean"] / 0.01, default=None)


def judged_speed(f):
    """Of one step of the median time: other work on the machine makes a few steps long."""
    least, median = SPEED[f["filter"]], 200.0 / f["step_median_ms"]
    return (f"{f['filter']}, one thread: at least {least} times real time",
            f"{f['real_time_factor']:.0f} times over all steps, {median:.0f} times by the median step", median >= least)


def judged(record):
    """[(what, figures, holds)]"""
    bars = []
    for kappa, result in record.get("house", {}).items():
        filters = by_name(result)
        for name, kind in (("edh@100", "edh"), ("ekf", "ekf")):
            theirs, ours = published(result, kind, 100), filters[name]
            limits = {key: theirs[key] for key in BEST}
            bars.append((f"{name} at kappa = {kappa} m: no run lost, at or under the published RMSE, "
                         f"{limits['position_rmse_m']:.4f} m and {limits['heading_rmse_rad']:.4f} rad",
                         f"{ours['lost']} lost, {fixed(ours['position_rmse_m']['mean'], 4)} m, "
                         f"{fixed(ours['heading_rmse_rad']['mean'], 4)} rad", within(ours, limits)))
        if kappa == "1e-4":
            best = best_of(filters)
            text = (f"{best['filter']}: {best['position_rmse_m']['mean']:.4f} m, {best['heading_rmse_rad']['mean']:.4f} rad"
                    if best else "none")
            bars.append((f"the best filter at kappa = {kappa} m: no run lost, RMSE at most 0.02 m and 0.01 rad", text,
                         best is not None))
    times = record.get("speed", {}).get("times", {}).get("filters", [])
    return bars + [judged_speed(f) for f in times if f["filter"] in SPEED]


# ---- Page --------------------------------------------------------------------------------------------------------------


def spread(key, decimals):
    """The column of a figure, mean and deviation."""
    def text(f):
        deviation = "" if None in f[key].values() else f" +- {f[key]['deviation']:.{decimals}f}"
        return fixed(f[key]["mean"], decimals) + deviation
    return text


def lost_text(f):
    when = f", after {f['lost_s']['mean']:.0f} s" if f["lost"] else ""
    return f"{f['lost']} of {f['runs']}{when}"


def away_text(f):
    return f"{100 * f['away']:.1f} %"


def error_table(result):
    def published_text(f):
        row = published(result, f["kind"], round(f["particles"]))
        return f"{row['position_rmse_m']:.4f} / {row['heading_rmse_rad']:.4f}" if row else ""

    return table_of(result["filters"], {
        "filter": lambda f: f["filter"], "lost": lost_text, "> 0.5 m": away_text, "RMSE [m]": spread("position_rmse_m", 4),
        "MAE [m]": spread("position_mae_m", 4), "largest [m]": spread("position_max_m", 3),
        "heading RMSE [rad]": spread("heading_rmse_rad", 4), "heading MAE [rad]": spread("heading_mae_rad", 4),
        "NEES": spread("nees", 2), **({"published RMSE [m] / [rad]": published_text} if result["published"] else {})})


def seeds_text(result):
    first, count = result["plan"]["first_seed"], result["plan"]["seeds"]
    return f"seeds {first} to {first + count - 1}" if count > 1 else f"seed {first}"


def first_of(results):
    return next(iter(results.values()))


def house_text(results):
    text = ("\n## The drive through the house\n\nMean +- standard deviation over "
            f"{seeds_text(first_of(results))}, which change the odometry, the ranges and the filter. "
            f"{SLOWEST.replace(',', ' and ')} have the first quarter of the seeds: they are slow.\n")
    return text + "".join(f"\n### kappa = {kappa} m\n\n{error_table(result)}\n" for kappa, result in results.items())


def followup_text(result):
    rows = table_of(result["published"]["rows"], {
        "filter": lambda r: r["name"], "RMSE [m]": lambda r: f"{r['position_rmse_m']:.4f}",
        "heading RMSE [rad]": lambda r: f"{r['heading_rmse_rad']:.4f}", "step [ms]": lambda r: fixed(r["step_ms"], 2)})
    return (f"\n## The setting of the follow-up\n\nThe same drive with kappa = {FOLLOWUP_KAPPA} m, ranges of 2 cm noise and "
            f"the 1 cm map, {seeds_text(result)}. No bar was set for it.\n\n{error_table(result)}\n\nPublished, all rows "
            f"(AMCL+ weighs every scan, as `amcl` here; times are theirs, in ROS):\n\n{rows}\n")


def growth_text(result):
    """How the cost grows with very many particles."""
    median_ms = {f["filter"]: f["step_median_ms"] for f in result["times"]["filters"]}
    fewer, more = MANY.split(",")
    if fewer not in median_ms or more not in median_ms:
        return ""
    ratio = median_ms[more] / median_ms[fewer]
    return f"\nTen times the particles: a step of {more} takes {ratio:.1f} times as long as one of {fewer}.\n"


def speed_text(result):
    rows = table_of(result["times"]["filters"], {
        "filter": lambda f: f["filter"], "median [ms]": lambda f: f"{f['step_median_ms']:.4f}",
        "p99 [ms]": lambda f: f"{f['step_p99_ms']:.4f}", "times real time": lambda f: f"{f['real_time_factor']:.0f}"})
    return ("\n## Times of a step\n\nOne seed of the drive, one filter at a time, one thread. Other work ran on the machine; "
            f"it is in p99 and in the last column.\n\n{rows}\n{growth_text(result)}")


def logs_text(results):
    return (f"\n## Recorded logs\n\nOf the filter only: {seeds_text(first_of(results))}.\n" +
            "".join(f"\n### {name}\n\n{error_table(result)}\n" for name, result in results.items()))


def troubles_text(results):
    names = list(by_name(results["none"]))
    of = {name: {trouble: by_name(result)[name] for trouble, result in results.items()} for name in names}
    runs = first_of(first_of(of))["runs"]

    def loses(holds, text="{0}"):
        return lambda name: ", ".join(
            text.format(trouble, f["lost"]) for trouble, f in of[name].items() if holds(f["lost"])) or "nothing"

    def clutter_cells(name):
        rows = [of[name][trouble] for trouble in clutter]
        return [cell for f in rows for cell in (spread("position_rmse_m", 4)(f), away_text(f))]

    clutter = [trouble for trouble in results if trouble.startswith("clutter") or trouble == "none"]
    header = ["filter", *(text for trouble in clutter for text in (trouble, "> 0.5 m"))]
    hits = ", ".join(f"{name}: {100 * hits:.1f} %" for name, r in results.items() if (hits := r["plan"]["unmapped_hits"]))
    limits = {"filter": str, "loses most runs to": loses(lambda lost: 2 * lost > runs),
              "loses some runs to": loses(lambda lost: 0 < 2 * lost <= runs, "{0} ({1})")}
    return f"""
## Where each filter breaks

Runs lost of {runs}, {seeds_text(results["none"])}, at kappa = {TROUBLE_KAPPA} m. "Told": the spread that the filter starts with is as large as the error; \
else it is 0.1 m and 0.05 rad. Robots are kidnapped at 30 to 180 s, by the seed. Hits on what is not on the map: {hits}.

{table(["filter", *results], [[name, *(str(f["lost"]) for f in of[name].values())] for name in names])}

{table_of(names, limits)}

Position RMSE in m of the runs that kept their robot, and the share of all scans at which a run was farther than 0.5 m off, \
lost or not:

{table(header, [[name, *clutter_cells(name)] for name in names])}
"""  # noqa: E501


def where_text(record):
    rows = [(part, *circumstance_cells(where, CIRCUMSTANCES)) for part, where in record["where"].items()]
    return f"\n## Where and when\n\n{table(('part', *CIRCUMSTANCES), rows)}\n\nBackend: {record['backend']}.\n"


TEXTS = {"house": house_text, "followup": followup_text, "speed": speed_text, "logs": logs_text, "troubles": troubles_text}


def page(record):
    text = f"""# Filters compared

What this is, how to read it and when to choose which filter: [compare](../compare.md). Settings were tuned on seeds {TUNED}; \
each part says of which ones its figures are. A run is lost if it is farther than 0.5 m off at its end. The means of errors \
and NEES are of the runs that kept their robot; a bar is kept only without a lost run.
"""
    if bars := judged(record):
        text += f"\n{bars_table(bars)}\n"
    return text + "".join(text_of(record[part]) for part, text_of in TEXTS.items() if part in record) + where_text(record)


def earlier_parts(path):
    """What the file has of earlier measurements; nothing if its figures mean something else."""
    record = json.loads(path.read_text()) if path.is_file() else {"format": FORMAT}
    if record.get("format") == FORMAT:
        return record
    print(f"{path}: of an earlier format, its parts are dropped", file=sys.stderr)
    return {"format": FORMAT}


def run(bench):
    args, path = bench.args, bench.args.out / "compare.json"
    record = earlier_parts(path)
    os.environ["PARLOC_DATA"] = str(args.data)
    if not (args.data / "tb3_house" / "map_01.yaml").is_file():
        raise Failure(2, f"{args.data}/tb3_house: not found; give the folder of the maps and logs with --data or PARLOC_DATA")
    here = circumstances(bench.program)  # before the first result changes a file
    for part in args.parts:
        def timed(name, arguments, part=part):
            result = report_of(bench, "compare", name, arguments)
            record["backend"] = result["times"]["filters"][0]["backend"]
            print(f"{part}: {name} done in {result['times']['wall_s']:.0f} s", file=sys.stderr, flush=True)
            return slim(result)
        record[part] = PARTS[part](args, timed)
        record.setdefault("where", {})[part] = here
        path.write_text(json.dumps(record, indent=1) + "\n")
        (args.out / "compare.md").write_text(page(record).rstrip() + "\n")
        print(path, file=sys.stderr)
    return 0 if all(holds for _, _, holds in judged(record)) else 1


if __name__ == "__main__":
    sys.exit(measuring.study(__doc__, {run: (
        count("--seeds", 20, "how many"), count("--seed", 21, "first seed"),
        count("--jobs", 1, "seeds at a time, but for speed"),
        subset("--parts", PARTS, "what to run", "PART"), LOGS_FOLDER)}))
