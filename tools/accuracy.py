#!/usr/bin/env python3
"""Measures the accuracy of `parloc run` and writes a page (Markdown) with all values beside it (JSON).

    tools/accuracy.py paper     the experiment of Paz et al. 2012: 15 configurations, simulated logs
    tools/accuracy.py logs      real logs with a known start

Needs Python 3.10 and a built program, nothing else. Every run has one thread and is deterministic, so the errors are
the same for any --jobs and on any machine. An interrupted measurement (Ctrl-C) writes what it has as NAME.partial.*
and leaves the page of an earlier one alone.

Exit code: 0 all bars kept, 1 a bar missed, 2 wrong usage or a missing file, 3 a run of parloc failed, 130 interrupted.
"""

import argparse
import bisect
import concurrent.futures
import datetime
import json
import math
import os
import pathlib
import platform
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading

ROOT = pathlib.Path(__file__).resolve().parent.parent
OUT = ROOT / "docs" / "results"
DATA = pathlib.Path(os.environ.get("PARLOC_DATA", ROOT.parent / "shared" / "data"))

PARTICLES, BEAMS = (500, 1000, 2000, 3000, 4000), (50, 100, 200)
FILTER_ALONE = "localize: {health: false}\n"  # of a configuration: no search helps the filter
PAPER_MAP, PAPER_SCENARIO, PAPER_CONFIG = "maps/hall_obstacles.yaml", "configs/paz2012_scenario.yaml", "configs/paz2012.yaml"
SETTLING_S = 1.0  # the maximum counts from here on
PAPER_BARS = {"mean_m": 0.015, "max_settled_m": 0.06, "heading_rmse_deg": 0.6}

SLOW_RAD_S = 0.02  # below this yaw rate the interpolated truth of tb3_house is good in heading
MAX_TRUTH_GAP_S = 1.5  # as parloc itself interpolates
# Name: folder under --data, or None for the logs that ship in maps/logs; map; bars.
LOGS = {
    "intel": ("intel", "map.yaml", {"mean_m": 0.080, "max_m": 0.35, "relation_m": 0.045}),
    "aces": ("aces", "map.yaml", {"mean_m": 0.075, "max_m": 0.40, "relation_m": 0.050}),
    "tb3_house": ("tb3_house", "map_05.yaml", {"rmse_m": 0.03, "heading_rmse_deg": 1.25, "heading_rmse_slow_deg": 0.8}),
    "malaga_corridor": (None, "maps/malaga_corridor.yaml", {}),
    "malaga_faculty": (None, "maps/malaga_faculty.yaml", {}),
}


class Failure(Exception):
    """Ends the measurement with one line and an exit code."""

    def __init__(self, code, text):
        super().__init__(text)
        self.code = code


# ---- Trajectories ------------------------------------------------------------------------------------------------------


def wrap(angle_rad):
    return (angle_rad + math.pi) % (2 * math.pi) - math.pi


def read_tum(path):
    """[(stamp [s], x [m], y [m], heading [rad])] in file order."""
    rows = []
    for number, line in enumerate(open(path), 1):
        if line.startswith("#") or not line.strip():
            continue
        try:
            stamp, x, y, _, _, _, qz, qw = map(float, line.split())
        except ValueError:
            raise Failure(2, f"{path}:{number}: expected 8 numbers: timestamp x y z qx qy qz qw")
        rows.append((stamp, x, y, 2 * math.atan2(qz, qw)))
    return rows


class Truth:
    """The true pose and yaw rate at any stamp, by the rule of `parloc run`: the row of that stamp, else interpolated."""

    def __init__(self, rows):
        self.exact = {}
        for row in rows:
            self.exact.setdefault(round(row[0] * 1e6), row)
        self.rows = sorted(rows, key=lambda row: row[0])
        self.stamps = [row[0] for row in self.rows]

    def _around(self, stamp_s):
        after = bisect.bisect_right(self.stamps, stamp_s)
        if not 0 < after < len(self.rows):
            return None
        a, b = self.rows[after - 1], self.rows[after]
        return (a, b) if 0 < b[0] - a[0] <= MAX_TRUTH_GAP_S else None

    def pose(self, stamp_s):
        row = self.exact.get(round(stamp_s * 1e6))
        if row:
            return row[1:]
        if not (around := self._around(stamp_s)):
            return None
        a, b = around
        u = (stamp_s - a[0]) / (b[0] - a[0])
        return a[1] + u * (b[1] - a[1]), a[2] + u * (b[2] - a[2]), a[3] + u * wrap(b[3] - a[3])

    def yaw_rate(self, stamp_s):
        """[rad/s] between the two rows around the stamp, None where there are none."""
        if not (around := self._around(stamp_s)):
            return None
        a, b = around
        return wrap(b[3] - a[3]) / (b[0] - a[0])


def pose_errors(trajectory, truth):
    """[(stamp [s], position error [m], heading error [rad])] of the poses that have a truth."""
    errors = []
    for stamp, x, y, heading in trajectory:
        if true := truth.pose(stamp):
            errors.append((stamp, math.hypot(x - true[0], y - true[1]), wrap(heading - true[2])))
    return errors


def rms(values):
    return math.sqrt(sum(v * v for v in values) / len(values)) if values else math.nan


# ---- Running the program -----------------------------------------------------------------------------------------------


class Program:
    """Runs parloc; stop() ends all runs in progress and refuses new ones."""

    def __init__(self, path):
        self.path = pathlib.Path(path)
        self.lock, self.running, self.stopped = threading.Lock(), set(), False
        if not os.access(self.path, os.X_OK) or self.path.is_dir():
            raise Failure(2, f"{self.path}: expected the parloc program; build it (cmake --preset cpu && cmake --build "
                             "--preset cpu) or give --parloc")

    def __call__(self, *arguments):
        command = [str(self.path), *map(str, arguments)]
        with self.lock:
            if self.stopped:
                raise Failure(130, "interrupted")
            # Its own session: Ctrl-C at the terminal reaches this script only, which then ends the runs itself.
            process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT,
                                       start_new_session=True)
            self.running.add(process)
        try:
            out, err = process.communicate()
        except BaseException:
            process.kill()
            raise
        finally:
            with self.lock:
                self.running.discard(process)
        if process.returncode != 0:
            last = (err.strip().splitlines() or ["no message"])[-1]
            raise Failure(130 if self.stopped else 3, f"exit code {process.returncode} of {' '.join(command)}: {last}")
        return out

    def stop(self):
        with self.lock:
            self.stopped = True
            for process in self.running:
                process.kill()


def localize(program, work, name, arguments):
    """The metrics of one run, its pose errors, and the truth."""
    out = work / name
    try:
        metrics = json.loads(program("run", *arguments, "--threads", 1, "--json", "--quiet", "--out", out))
        trajectory = read_tum(out / "trajectory.tum")
    finally:
        shutil.rmtree(out, ignore_errors=True)
    truth = Truth(read_tum(arguments[arguments.index("--truth") + 1]))
    errors = pose_errors(trajectory, truth)
    mean_m = sum(e[1] for e in errors) / max(1, len(errors))
    # Two programs, one answer; files have 6 decimals.
    if len(errors) != metrics["compared_with_truth"] or abs(mean_m - metrics["position_mae_m"]) > 5e-6:
        raise Failure(3, f"{name}: parloc says {metrics['position_mae_m']} m over {metrics['compared_with_truth']} scans, "
                         f"its trajectory says {mean_m} m over {len(errors)}")
    return metrics, errors, truth


def common_values(metrics):
    return {"mean_m": metrics["position_mae_m"], "rmse_m": metrics["position_rmse_m"], "max_m": metrics["position_max_m"],
            "heading_rmse_deg": math.degrees(metrics["heading_rmse_rad"]), "scans": metrics["scans"],
            "digest": metrics["digest"]}


def within(values, bars):
    return all(values[key] <= bar for key, bar in bars.items())


def measure(program, jobs, tasks, text_of):
    """The results of tasks [(key, function)] by key, `jobs` at a time, and how it ended: None or a Failure."""
    results, end = {}, None
    pool = concurrent.futures.ThreadPoolExecutor(jobs)
    try:
        futures = {pool.submit(function): key for key, function in tasks}
        for future in concurrent.futures.as_completed(futures):
            key = futures[future]
            results[key] = future.result()
            print(f"[{len(results):3}/{len(tasks)}] {text_of(key, results[key])}", file=sys.stderr, flush=True)
    except (KeyboardInterrupt, Failure) as stop:
        end = stop if isinstance(stop, Failure) else Failure(130, "interrupted")
        program.stop()
    pool.shutdown(cancel_futures=True)
    return {key: results[key] for key, _ in tasks if key in results}, end


# ---- Where and how it was measured -------------------------------------------------------------------------------------


def git(*arguments):
    try:
        return subprocess.run(["git", *arguments], cwd=ROOT, check=True, capture_output=True, text=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return None


def commit():
    """The commit of this tree; -dirty if a file that git knows differs from it."""
    short = git("rev-parse", "--short", "HEAD")
    if short is None:
        return "unknown (no git repository)"
    return short + ("-dirty" if git("--no-optional-locks", "status", "--porcelain", "--untracked-files=no") else "")


def cpu_model():
    try:
        found = re.search(r"^model name\s*:\s*(.+)$", open("/proc/cpuinfo").read(), re.MULTILINE)
    except OSError:
        found = None
    return found[1] if found else platform.processor() or platform.machine()


def operating_system():
    try:
        return platform.freedesktop_os_release()["PRETTY_NAME"]
    except (OSError, KeyError):
        return platform.platform()


def compiler(build):
    """Compiler and build type from CMake's files in the program's folder, if it lies in its build folder."""
    try:
        rules = next(build.glob("CMakeFiles/*/CMakeCXXCompiler.cmake")).read_text()
        cache = (build / "CMakeCache.txt").read_text()
    except (StopIteration, OSError):
        return "unknown (the program does not lie in its build folder)"
    names = [re.search(pattern, text, re.MULTILINE) for pattern, text in (
        (r'^set\(CMAKE_CXX_COMPILER_ID "(.*)"\)', rules), (r'^set\(CMAKE_CXX_COMPILER_VERSION "(.*)"\)', rules),
        (r"^CMAKE_BUILD_TYPE:\w+=(.*)$", cache))]
    return " ".join(name[1] for name in names if name)


def circumstances(program):
    return {
        "command": " ".join(["tools/accuracy.py", *sys.argv[1:]]),
        "date": datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%d"),
        "commit": commit(),
        "program": program("--version").strip(),
        "compiler": compiler(program.path.resolve().parent),
        "machine": f"{cpu_model()}, {os.cpu_count()} cores",
        "system": operating_system(),
    }


# ---- Pages -------------------------------------------------------------------------------------------------------------


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def circumstances_text(record):
    rows = [(key, f"`{record[key]}`" if key == "command" else record[key])
            for key in ("command", "date", "commit", "program", "compiler", "machine", "system", "backend")]
    return "## Where and when\n\n" + table(("", ""), rows)


def first_lines(title, record):
    """Title, a warning if partial, and how many runs kept their bars."""
    judged = [run for run in record["runs"] if "within_bars" in run]
    good = sum(run["within_bars"] for run in judged)
    text = f"# {title}\n"
    if record["partial"]:
        text += (f"\n**Partial: ended after {len(record['runs'])} of {record['runs_planned']} runs "
                 f"({record['ended_by']}).**\n")
    if not judged:
        return text
    which = "runs" if len(judged) == len(record["runs"]) else "runs on logs that have bars"
    return text + (f"\nAll {good}" if good == len(judged) else f"\n**{good} of {len(judged)}**") + f" {which} are within all bars.\n"


def json_text(record):
    """The record with one line per run."""
    head = json.dumps({key: value for key, value in record.items() if key != "runs"}, indent=1)
    runs = ",\n  ".join(map(json.dumps, record["runs"]))
    return f'{head[:-2]},\n "runs": [\n  {runs}\n ]\n}}\n'


def write_results(folder, name, record, text):
    """NAME.md and NAME.json; a partial result gets its own name so that it replaces no complete one."""
    stem = name + (".partial" if record["partial"] else "")
    for suffix, content in ((".json", json_text(record)), (".md", text.rstrip() + "\n")):
        path = folder / (stem + suffix)
        draft = path.with_name(path.name + ".tmp")
        draft.write_text(content)
        draft.replace(path)
        print(path, file=sys.stderr)


def finish(args, name, program_record, planned, results, end, page):
    """Writes what there is, and gives the exit code."""
    runs = list(results.values())
    if not runs:
        raise end
    backends, configs = {run.pop("backend") for run in runs}, [run.pop("config") for run in runs]
    record = {"partial": end is not None, "ended_by": str(end) if end else None, "runs_planned": planned,
              **program_record, "backend": ", ".join(sorted(backends)),
              "config": {key: value for key, value in configs[0].items() if key != "seed"}, "runs": runs}
    write_results(args.out, name, record, page(record))
    if end:
        raise end
    return 0 if all(run.get("within_bars", True) for run in runs) else 1


# ---- The paper's experiment --------------------------------------------------------------------------------------------


def paper_run(program, work, particles, beams, seed):
    log = work / f"log_{seed}"
    metrics, errors, _ = localize(program, work, f"{particles}x{beams}_{seed}", [
        "--map", PAPER_MAP, "--log", log / "scans.log", "--truth", log / "truth.tum", "--config", PAPER_CONFIG,
        "--particles", particles, "--beams", beams, "--seed", seed])
    settled = [e[1] for e in errors if e[0] >= errors[0][0] + SETTLING_S]
    values = {"particles": particles, "beams": beams, "seed": seed, **common_values(metrics), "max_settled_m": max(settled)}
    config = metrics["config"]
    del config["particles"], config["scan"]["max_beams"]  # differ between runs
    return {**values, "within_bars": within(values, PAPER_BARS), "config": config, "backend": metrics["backend"]}


def paper_rows(runs):
    """One row per configuration, then the worst of all."""
    keys = sorted({(run["particles"], run["beams"]) for run in runs})
    groups = [(f"{n}", f"{b}", [r for r in runs if (r["particles"], r["beams"]) == (n, b)]) for n, b in keys]
    rows = []
    for particles, beams, group in groups + [("**all**", "", runs)]:
        worst = {key: max(run[key] for run in group) for key in PAPER_BARS}
        rows.append((particles, beams, f"{100 * sum(run['mean_m'] for run in group) / len(group):.2f}",
                     f"{100 * worst['mean_m']:.2f}", f"{100 * worst['max_settled_m']:.2f}",
                     f"{worst['heading_rmse_deg']:.3f}", f"{sum(run['within_bars'] for run in group)} of {len(group)}"))
    return rows


PAPER_TEXT = """
Position errors in cm, heading errors in degrees. "Worst" is the worst of the seeds.

{table}

Bars: mean position error at most {mean:.1f} cm, never more than {max:.0f} cm after the first second, heading RMSE at most {heading}
degrees; in every run.

## What is measured

- A log per seed: `parloc simulate --scenario {scenario} --seed S`, a 17 m path with stops to turn in a map
  of 20 x 10 m. Rays are cast in the 1 cm map, the filter gets the 5 cm one ([the simulator](../simulator.md)).
- On it, per configuration: `parloc run --map {map} --config {config} --particles N --beams B --seed S
  --log LOG --truth TRUTH --threads 1 --json`. The filter starts at the true pose with a spread of
  {spread_m} m and {spread_rad} rad.
- An error is the distance, or the heading's difference, between the reported pose and the true one at the stamp of a scan. The
  mean and the RMSE are over all scans of a run, the first second included.
- The configuration is [{config}](../../{config}); its sensor model is `{model}`, sigma {sigma} m,
  tempering {tempering}. [How it was chosen](README.md#how-the-configuration-of-the-papers-experiment-was-chosen). The JSON file has every value of
  it, and every run with the digest of its particles.
"""


def paper_page(record):
    config = record["config"]
    seeds = len({run["seed"] for run in record["runs"]})
    return first_lines(f"The experiment of Paz et al. 2012: 15 configurations, {seeds} seeds", record) + PAPER_TEXT.format(
        table=table(("particles", "beams", "mean of means", "worst mean", f"worst maximum after {SETTLING_S:g} s",
                     "worst heading RMSE", "runs within all bars"), paper_rows(record["runs"])),
        mean=100 * PAPER_BARS["mean_m"], max=100 * PAPER_BARS["max_settled_m"], heading=PAPER_BARS["heading_rmse_deg"],
        scenario=PAPER_SCENARIO, map=PAPER_MAP, config=PAPER_CONFIG, spread_m=config["initial_sigma_xy"],
        spread_rad=config["initial_sigma_theta"], model=config["sensor"]["model"], sigma=config["sensor"]["sigma_hit"],
        tempering=config["sensor"]["tempering"]) + "\n" + circumstances_text(record)


def paper(args, program, work):
    record = {"what": "paper", **circumstances(program), "bars": PAPER_BARS}
    seeds = range(1, args.seeds + 1)
    for seed in seeds:
        program("simulate", "--scenario", PAPER_SCENARIO, "--seed", seed, "--out", work / f"log_{seed}", "--quiet")
        print(f"log {seed} of {args.seeds} simulated", file=sys.stderr, flush=True)
    keys = [(n, b, seed) for n in PARTICLES for b in BEAMS for seed in seeds]
    tasks = [(key, lambda key=key: paper_run(program, work, *key)) for key in keys]
    results, end = measure(program, args.jobs, tasks, lambda key, run: (
        f"{key[0]} particles x {key[1]} beams, seed {key[2]}: mean {100 * run['mean_m']:.2f} cm, maximum "
        f"{100 * run['max_settled_m']:.2f} cm, heading {run['heading_rmse_deg']:.3f} deg"
        f"{'' if run['within_bars'] else '  MISSED'}"))
    return finish(args, "paz2012_accuracy", record, len(tasks), results, end, paper_page)


# ---- Real logs ---------------------------------------------------------------------------------------------------------


def log_files(name, data):
    """Options of `parloc run` for one log."""
    folder, grid, _ = LOGS[name]
    if folder is None:
        files = {"--map": ROOT / grid, "--log": ROOT / f"maps/logs/{name}.log.gz", "--truth": ROOT / f"maps/logs/{name}.tum"}
    else:
        home = data / folder
        files = {"--map": home / grid, "--log": home / "scans.log", "--truth": home / "reference.tum"}
        if "relation_m" in LOGS[name][2]:
            files["--relations"] = home / "relations.txt"
    for path in files.values():
        if not path.is_file():
            raise Failure(2, f"{path}: not found; give the folder of the real logs with --data or PARLOC_DATA, or --shipped "
                             "for the logs in maps/logs alone")
    return [part for option in files.items() for part in option]


def log_run(program, work, files, name, seed):
    metrics, errors, truth = localize(program, work, f"{name}_{seed}", [*files, "--seed", seed])
    values = {"log": name, "seed": seed, **common_values(metrics)}
    if metrics["relations"]:
        values["relation_m"] = metrics["relations"]["translation_mean_m"]
        values["relation_std_m"] = metrics["relations"]["translation_std_m"]
        values["relations"] = metrics["relations"]["compared"]
    bars = LOGS[name][2]
    if "heading_rmse_slow_deg" in bars:
        rates = [truth.yaw_rate(e[0]) for e in errors]
        slow = [e[2] for e, rate in zip(errors, rates) if rate is not None and abs(rate) < SLOW_RAD_S]
        values.update(heading_rmse_slow_deg=math.degrees(rms(slow)), slow_scans=len(slow))
    if bars:
        values["within_bars"] = within(values, bars)
    return {**values, "config": metrics["config"], "backend": metrics["backend"]}


LOG_COLUMNS = (("mean_m", "mean [m]", 4), ("max_m", "maximum [m]", 3), ("rmse_m", "RMSE [m]", 4),
               ("heading_rmse_deg", "heading RMSE [deg]", 3), ("heading_rmse_slow_deg", "the same, hardly turning [deg]", 3),
               ("relation_m", "relation error [m]", 4))


def log_cells(run, bars):
    """Values of a run, each with its bar if it has one."""
    cells = []
    for key, _, decimals in LOG_COLUMNS:
        text = f"{run[key]:.{decimals}f}" if key in run else ""
        cells.append(f"{text} (<= {bars[key]:g})" if key in bars else text)
    return cells


def log_tables(runs):
    """The worst of each log beside its bars, and every run."""
    header = [title for _, title, _ in LOG_COLUMNS]
    worst_rows = []
    for name in dict.fromkeys(run["log"] for run in runs):
        group = [run for run in runs if run["log"] == name]
        worst = {key: max(run[key] for run in group) for key, _, _ in LOG_COLUMNS if key in group[0]}
        good = f"{sum(run['within_bars'] for run in group)} of {len(group)}" if LOGS[name][2] else "no bars"
        worst_rows.append((name, *log_cells(worst, LOGS[name][2]), good))
    all_rows = [(run["log"], str(run["seed"]), *log_cells(run, {})) for run in runs]
    return (table(("log", *header, "runs within all bars"), worst_rows), table(("log", "seed", *header), all_rows))


LOG_TEXT = """
The default configuration, unchanged, for every log: sensor model `{model}`, {particles} particles, {beams} beams. The worst of
{seeds} seeds, and in brackets the bar:

{worst}

## Every run

{all}

## What is measured

- `parloc run --map MAP --log LOG --truth TRUTH [--relations RELATIONS] --seed S --threads 1 --json`; no configuration file. The
  start is the truth's pose at the first scan, with the default spread. tb3_house runs on `map_05`.
- Mean, maximum and RMSE are over every scan: the distance between the reported pose and the truth at the stamp of the scan.
- The relation error (Kuemmerle et al. 2009) compares the motion between two scans with verified relations, and needs no global
  truth: the mean over {relations}.
- "Hardly turning" is where the truth turns by less than {slow} rad/s{slow_scans}. The truth of tb3_house has one row per second;
  while the robot turns, a pose between two rows is itself wrong by about a degree.

## How good the truths are

- intel, aces: published trajectories of a SLAM program, 3 to 6 cm from the true ones; the maps were built from the same drives.
  Claim nothing below 5 cm here: the relation error is the better figure.
- tb3_house: exact, it is a simulation by others.
- malaga_*: nobody surveyed these drives. The reference is every scan laid on the map, good to 2 to 3 cm and 0.1 degrees within the
  map. **The faculty's map holds the very scans that are localized on it**: an error measured there is flattering. The corridor's
  map is from the day before. [maps/logs/README.md](../../maps/logs/README.md) says more.
"""


def logs_page(record):
    runs, config = record["runs"], record["config"]
    worst, every = log_tables(runs)
    relations = {run["log"]: run["relations"] for run in runs if "relations" in run}
    slow = next((run["slow_scans"] for run in runs if "slow_scans" in run), None)
    return first_lines("Real logs, known start, default configuration", record) + LOG_TEXT.format(
        model=config["sensor"]["model"], particles=config["particles"], beams=config["scan"]["max_beams"],
        seeds=len({run["seed"] for run in runs}), worst=worst, all=every, slow=SLOW_RAD_S,
        relations=" and ".join(f"{count} relations of {log}" for log, count in relations.items()) or "all relations",
        slow_scans=f" ({slow} of the scans)" if slow else "") + "\n" + circumstances_text(record)


def logs(args, program, work):
    names = [name for name, (folder, _, _) in LOGS.items() if folder is None or not args.shipped]
    files = {name: log_files(name, args.data) for name in names}
    record = {"what": "logs", **circumstances(program), "bars": {name: LOGS[name][2] for name in names}}
    keys = [(name, seed) for name in names for seed in range(1, args.seeds + 1)]
    tasks = [(key, lambda key=key: log_run(program, work, files[key[0]], *key)) for key in keys]
    results, end = measure(program, args.jobs, tasks, lambda key, run: (
        f"{key[0]}, seed {key[1]}: mean {run['mean_m']:.4f} m, maximum {run['max_m']:.3f} m, heading "
        f"{run['heading_rmse_deg']:.3f} deg{'' if run.get('within_bars', True) else '  MISSED'}"))
    return finish(args, "real_logs", record, len(tasks), results, end, logs_page)


# ---- Command line ------------------------------------------------------------------------------------------------------


def positive(text):
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"expected a whole number of at least 1, got '{text}'")
    return int(text)


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True, metavar="paper|logs")
    for run, seeds, text in ((paper, 20, "the experiment of Paz et al. 2012"), (logs, 5, "real logs, known start")):
        command = commands.add_parser(run.__name__, help=text, description=text)
        command.set_defaults(run=run)
        command.add_argument("--seeds", type=positive, default=seeds, metavar="N", help=f"seeds 1 to N ({seeds})")
        command.add_argument("--jobs", type=positive, default=1, metavar="K", help="runs at a time (1)")
        command.add_argument("--out", type=pathlib.Path, default=OUT, metavar="DIR", help="folder for the page (docs/results)")
        command.add_argument("--parloc", default=ROOT / "build/cpu/parloc", metavar="FILE", help="the program (build/cpu/parloc)")
    command.add_argument("--data", type=pathlib.Path, default=DATA, metavar="DIR",
                         help="folder with intel, aces and tb3_house (PARLOC_DATA, else ../shared/data)")
    command.add_argument("--shipped", action="store_true", help="only the logs that ship in maps/logs")
    args = parser.parse_args()
    args.out = args.out.absolute()
    args.parloc = pathlib.Path(args.parloc).absolute()  # the program runs in the repository's folder
    if "data" in args:
        args.data = args.data.absolute()
    return args


def interrupt(*_):
    raise KeyboardInterrupt


def run_tool(name, args, run):
    """run(args, program, work folder), with one line and an exit code for what goes wrong; the same for every tool."""
    signal.signal(signal.SIGTERM, interrupt)
    try:
        program = Program(args.parloc)
        args.out.mkdir(parents=True, exist_ok=True)
        if not os.access(args.out, os.W_OK):
            raise Failure(2, f"{args.out}: expected a folder that can be written")
        with tempfile.TemporaryDirectory(prefix=f"parloc_{name}_") as work:
            return run(args, program, pathlib.Path(work))
    except Failure as failure:
        print(f"{name}.py: {failure}", file=sys.stderr)
        return failure.code
    except KeyboardInterrupt:
        print(f"{name}.py: interrupted", file=sys.stderr)
        return 130
    except OSError as error:
        print(f"{name}.py: {error}", file=sys.stderr)
        return 2


def main():
    args = parse_arguments()
    return run_tool("accuracy", args, args.run)


if __name__ == "__main__":
    sys.exit(main())
