#!/usr/bin/env python3
"""Measures the sensor models of `parloc run` on simulated logs and writes a page (Markdown) with all values beside it
(JSON).

    tools/studies/sensor_models.py nees      whether each model's covariance says how far off the filter is, and how the number of
                                     effective beams was chosen
    tools/studies/sensor_models.py clutter   tracking among people and boxes that are not on the map

Needs Python 3.10 and a built program, nothing else; runs are deterministic. Exit codes as those of tools/studies/accuracy.py.
"""

import argparse
import math
import sys

import measuring
import track_errors
from measuring import table

OFFICE = ("configs/office_scenario.yaml", "maps/office.yaml")
CLUTTER = ("configs/office_clutter_scenario.yaml", "maps/office.yaml")
HALL = ("configs/paz2012_scenario.yaml", "maps/hall_obstacles.yaml")
SCENES = {"office": OFFICE, "clutter": CLUTTER, "hall": HALL}

PLAIN = "gaussian, plain product"  # the 2012 paper's: S1
MODELS = ("likelihood_field", "likelihood_field_prob", "beam", "class_conditional", "gaussian", "s5")
SWEEP = {"likelihood_field": (3, 6, 9, 15, 30), "beam": (2, 4, 6, 10, 30), "gaussian": (0.2, 0.4, 1, 3, 30)}
# 2.5 % and 97.5 % points of chi-square with 3 S degrees of freedom, over S: bounds of the mean NEES of S runs.
CHI_SQUARE = {5: (6.2621, 27.4884), 10: (16.7908, 46.9792), 20: (40.4817, 83.2977)}
RIGHT_NEES = 3.0
CLUTTER_BAR = 2.0  # times the clean error


def sensor_yaml(settings):
    return "sensor:\n" + "".join(f"  {key}: {value}\n" for key, value in settings.items())


def settings_of(model):
    return {"model": "gaussian", "sigma_hit": 0.1, "tempering": 1} if model == PLAIN else {"model": model}


class Bench:
    """Simulated logs in a folder, made when first asked for; runs on them."""

    def __init__(self, program, work):
        self.program, self.work = program, work

    def simulate(self, scene, seed):
        out = self.work / f"{scene}_{seed}"
        text = self.program("simulate", "--scenario", SCENES[scene][0], "--seed", seed, "--out", out)
        shares = [float(line.split()[1]) for line in text.splitlines() if line.startswith("clutter")]
        return shares[0] if shares else 0.0

    def run(self, scene, seed, label, settings):
        log = self.work / f"{scene}_{seed}"
        name = f"{scene}_{seed}_{label}".replace(" ", "_").replace(",", "")
        config = self.work / f"{name}.yaml"
        config.write_text(sensor_yaml(settings) + track_errors.FILTER_ALONE)
        metrics, _, _ = track_errors.localize(self.program, self.work, name, [
            "--map", SCENES[scene][1], "--log", log / "scans.log", "--truth", log / "truth.tum", "--config", config,
            "--seed", seed])
        nees = metrics["nees"]
        return {"scene": scene, "seed": seed, "model": label, "settings": settings,
                "effective_beams": metrics["config"]["sensor"]["effective_beams"],
                **track_errors.common_values(metrics), "nees_mean": nees["mean"], "nees_median": nees["median"],
                "nees_within_95": nees["within_95"], "nees_x": nees["x_mean"], "nees_y": nees["y_mean"],
                "nees_heading": nees["heading_mean"], "backend": metrics["backend"], "config": metrics["config"]}


def mean(runs, key):
    return sum(run[key] for run in runs) / len(runs)


def number(value):
    return f"{value:.2f}" if value < 1000 else f"{value:.1e}"


# ---- nees ----------------------------------------------------------------------------------------------------------------

NEES_TEXT = """
The error e of a filter over its own covariance P, e' P^-1 e in x, y and heading, is 3 in the mean if the covariance says how far off
it is; more is over-confident, less too careful. Beams are not independent, so that the plain product of their likelihoods is
over-confident, and the more so the more beams there are. `sensor.effective_beams` is how many independent ones a scan is worth.

Defaults, {seeds} seeds each, mean over all scans and seeds. The 95 % bounds of the mean of {seeds} independent values of chi-square with 3
degrees of freedom are {low:.2f} to {high:.2f}:

{defaults}

## How the number was chosen

{sweep_seeds} seeds. The number whose mean NEES is nearest to 3 in the office, where the map is further off
than in the hall, so that it is careful there. The bounds are those of the table above. It hardly changes the accuracy.

{sweep}

## What limits it

- The 5 cm cells of the map: an expected range is off by 2 cm in the median and 4.5 cm for the worst tenth in the office, by less in
  the hall. That error is the same for neighbouring beams and scans, so that no one number is right everywhere: the hall's NEES is
  below 3 with what is right for the office.
- Heading alone is too careful by a factor of about 3 (NEES about 0.1 instead of 1): beams all around fix it much
  better than they fix the place, and one exponent serves both.
- A Gaussian has no floor. A few beams past edges then weigh as much as all others together, and its covariance is right only if a
  whole scan is worth less than one beam. Use `beam` or `likelihood_field` where the covariance matters.
- Means of hundreds and more are those of a few steps whose covariance is next to nothing: too many effective beams leave too few
  particles.
- The mean is over all scans of a run, which are not independent; the bounds hold for one time step of {seeds} runs.
"""


def nees_rows(runs, keys, seeds):
    low, high = (bound / seeds for bound in CHI_SQUARE[seeds]) if seeds in CHI_SQUARE else (math.nan, math.nan)
    rows = []
    for scene, model, beams in keys:
        group = [r for r in runs if (r["scene"], r["model"], r["effective_beams"]) == (scene, model, beams)]
        if not group:
            continue
        nees = mean(group, "nees_mean")
        verdict = "yes" if low <= nees <= high else "careful" if nees < low else "over-confident"
        rows.append((scene, model, f"{beams:g}", number(nees), number(mean(group, "nees_median")),
                     f"{100 * mean(group, 'nees_within_95'):.0f} %",
                     " / ".join(number(mean(group, key)) for key in ("nees_x", "nees_y", "nees_heading")),
                     f"{100 * mean(group, 'rmse_m'):.1f} cm", verdict))
    return rows


NEES_HEADER = ("scene", "model", "effective beams", "mean NEES", "median (2.37 is right)", "below 7.81 (95 % is right)",
               "x / y / heading alone", "RMSE", "mean within the bounds")


def nees(args, program, work):
    bench, seeds, sweep_seeds = Bench(program, work), args.seeds, min(args.seeds, args.sweep_seeds)
    for seed in range(1, seeds + 1):
        for scene in ("office", "hall"):
            bench.simulate(scene, seed)
    tasks = []
    for scene in ("office", "hall"):
        for seed in range(1, seeds + 1):
            tasks += [((scene, model, "default", seed), lambda s=scene, k=seed, m=model: bench.run(s, k, m, {"model": m}))
                      for model in MODELS]
        for seed in range(1, sweep_seeds + 1):
            for model, numbers in SWEEP.items():
                tasks += [((scene, model, beams, seed), lambda s=scene, k=seed, m=model, b=beams: {
                    **bench.run(s, k, f"{m}_{b}", {"model": m, "effective_beams": b}), "model": m, "sweep": True})
                    for beams in numbers]
    where = measuring.circumstances(program)  # before a break, after which nothing is run any more
    results, end = measuring.measure(program, args.jobs, tasks, lambda key, run: (
        f"{key}: NEES {number(run['nees_mean'])}, RMSE {100 * run['rmse_m']:.1f} cm"))
    low, high = (bound / seeds for bound in CHI_SQUARE[seeds])

    def page(record):
        own = [run for run in record["runs"] if not run.get("sweep")]
        swept = [run for run in record["runs"] if run.get("sweep")]
        keys = lambda runs: sorted({(r["scene"], r["model"], r["effective_beams"]) for r in runs},
                                   key=lambda k: (-ord(k[0][0]), MODELS.index(k[1]), k[2]))
        return measuring.first_lines("Whether the covariance says how far off the filter is (NEES)", record) + NEES_TEXT.format(
            seeds=seeds, sweep_seeds=sweep_seeds, low=low, high=high,
            defaults=table(NEES_HEADER, nees_rows(own, keys(own), seeds)),
            sweep=table(NEES_HEADER, nees_rows(swept, keys(swept), seeds))) + "\n" + measuring.circumstances_text(record)

    return measuring.finish(args, "nees", where, len(tasks), results, end, page)


# ---- clutter -------------------------------------------------------------------------------------------------------------

CLUTTER_MODELS = (PLAIN, "beam", "class_conditional", "likelihood_field_prob")
MUST_TRACK = "class_conditional"  # in every seed

CLUTTER_TEXT = """
The office drive ([office_clutter_scenario.yaml]({scenario})) with boxes beside the path and people around the robot, none of them
on the map: {share_low:.1f} to {share_high:.1f} % of the beams that hit something hit them. The same drive without them is the clean one.
{seeds} seeds; each is another noise, other boxes and other people. A seed is tracked if the RMSE of the position is below {bar:g} times
that of the same model on the clean log of the same seed.

{summary}

`{plain}` is the model of Paz et al. 2012 with sigma 0.1 m. The others have their defaults.

`likelihood_field_prob` has nav2's `beam_skip_distance` of 0.5 m, within which a person beside a wall passes for the wall. With 0.2 m
seeds 1 to 3 give 3.5, 3.3 and 3.8 cm instead of 4.7, 4.7 and 5.9 cm (measured apart from the table).

## Every seed

RMSE of the position among people, and in brackets without them [cm]:

{every}
"""


def clutter(args, program, work):
    bench, seeds = Bench(program, work), range(1, args.seeds + 1)
    shares = {}
    for seed in seeds:
        bench.simulate("office", seed)
        shares[seed] = bench.simulate("clutter", seed)
    tasks = [((model, scene, seed), lambda m=model, s=scene, k=seed: bench.run(s, k, m, settings_of(m)))
             for model in CLUTTER_MODELS for seed in seeds for scene in ("office", "clutter")]
    where = measuring.circumstances(program)  # before a break, after which nothing is run any more
    results, end = measuring.measure(program, args.jobs, tasks, lambda key, run: (
        f"{key[0]}, {key[1]}, seed {key[2]}: RMSE {100 * run['rmse_m']:.1f} cm, maximum {run['max_m']:.2f} m"))
    for (model, scene, seed), run in results.items():
        run["clutter_share_percent"] = shares[seed] if scene == "clutter" else 0.0
        clean = results.get((model, "office", seed))
        if scene == "clutter" and clean:
            run["times_clean"] = run["rmse_m"] / clean["rmse_m"]
            if model == MUST_TRACK:
                run["within_bars"] = run["times_clean"] < CLUTTER_BAR

    def page(record):
        runs = {(r["model"], r["scene"], r["seed"]): r for r in record["runs"]}
        summary, every = [], []
        for model in CLUTTER_MODELS:
            group = [r for r in record["runs"] if r["model"] == model and "times_clean" in r]
            if not group:
                continue
            cleans = [runs[model, "office", r["seed"]] for r in group]
            tracked = sum(r["times_clean"] < CLUTTER_BAR for r in group)
            summary.append((model, f"{tracked} of {len(group)}", f"{100 * mean(cleans, 'rmse_m'):.1f} cm",
                            f"{100 * sorted(r['rmse_m'] for r in group)[len(group) // 2]:.1f} cm",
                            f"{100 * max(r['rmse_m'] for r in group):.1f} cm", f"{max(r['max_m'] for r in group):.2f} m",
                            f"{max(r['times_clean'] for r in group):.2f}"))
        for seed in seeds:
            cells = [f"{100 * runs[m, 'clutter', seed]['rmse_m']:.1f} ({100 * runs[m, 'office', seed]['rmse_m']:.1f})"
                     if {(m, "clutter", seed), (m, "office", seed)} <= runs.keys() else "" for m in CLUTTER_MODELS]
            every.append((str(seed), f"{shares[seed]:.1f} %", *cells))
        return measuring.first_lines("Among people and boxes that are not on the map", record) + CLUTTER_TEXT.format(
            scenario="../../" + CLUTTER[0], seeds=len(shares), bar=CLUTTER_BAR, plain=PLAIN, share_low=min(shares.values()),
            share_high=max(shares.values()),
            summary=table(("model", "tracked", "mean RMSE, clean", "median RMSE", "worst RMSE", "largest error",
                           "worst, times clean"), summary),
            every=table(("seed", "share", *CLUTTER_MODELS), every)) + "\n" + measuring.circumstances_text(record)

    return measuring.finish(args, "clutter", where, len(tasks), results, end, page)


# ---- Command line ----------------------------------------------------------------------------------------------------------


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True, metavar="nees|clutter")
    for run, seeds, text in ((nees, 10, "NEES of each model"), (clutter, 20, "tracking among unmapped things")):
        command = commands.add_parser(run.__name__, help=text, description=text)
        command.set_defaults(run=run, sweep_seeds=0)
        choices = {"choices": sorted(CHI_SQUARE)} if run is nees else {}
        command.add_argument("--seeds", type=measuring.positive, default=seeds, metavar="N", help=f"seeds 1 to N ({seeds})",
                             **choices)
        if run is nees:
            command.add_argument("--sweep-seeds", type=measuring.positive, default=2, metavar="N",
                                 help="seeds of the table of effective beams (2)")
        measuring.add_arguments(command)
    return measuring.parse(parser)


def main():
    args = parse_arguments()
    return measuring.run_tool("sensor_models", args, args.run)


if __name__ == "__main__":
    sys.exit(main())
