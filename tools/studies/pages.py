"""What a study writes: a page (Markdown) with all values beside it (JSON), and where and how they were measured."""

import datetime
import json
import os
import pathlib
import platform
import re
import statistics
import subprocess
import sys

from measuring import ROOT

# ---- Where and how it was measured -------------------------------------------------------------------------------------


def commit():
    """The commit of this tree; -dirty if a file that git knows differs from it."""
    command = ["git", "--no-optional-locks", "describe", "--always", "--dirty", "--exclude=*"]  # by its hash, never by a tag
    try:
        return subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return "unknown (no git repository)"


def cpu_model():
    try:
        found = re.search(r"^model name\s*:\s*(.+)$", pathlib.Path("/proc/cpuinfo").read_text(), re.MULTILINE)
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
        "command": " ".join([f"tools/studies/{pathlib.Path(sys.argv[0]).name}", *sys.argv[1:]]),
        "date": datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%d"),
        "commit": commit(),
        "program": program("--version").strip(),
        "compiler": compiler(program.path.resolve().parent),
        "machine": f"{cpu_model()}, {os.cpu_count()} cores",
        "system": operating_system(),
    }


CIRCUMSTANCES = ("command", "date", "commit", "program", "compiler", "machine", "system")


def circumstance_cells(record, keys):
    return [f"`{record[key]}`" if key == "command" else record[key] for key in keys]


def circumstances_text(record, keys=(*CIRCUMSTANCES, "backend")):
    return "## Where and when\n\n" + table(("", ""), zip(keys, circumstance_cells(record, keys), strict=True))


# ---- Tables ------------------------------------------------------------------------------------------------------------


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def table_of(items, columns):
    """A row per item; columns {title: text of an item}."""
    return table(columns, ([text_of(item) for text_of in columns.values()] for item in items))


def table_of_groups(names, groups, columns):
    """A row per group of runs: its names, a column each, then columns {title: text of the runs}. groups {names: runs}."""
    return table([*names, *columns], ([*key, *(text_of(runs) for text_of in columns.values())] for key, runs in groups.items()))


def bars_table(bars):
    """Of [(what, figures, holds)]."""
    return table(("bar", "measured", ""), [(what, figures, "kept" if holds else "**missed**") for what, figures, holds in bars])


def fixed(value, decimals):
    return "-" if value is None else f"{value:.{decimals}f}"


def where(runs, **values):
    """Those of the runs that have these values."""
    return [run for run in runs if all(run[key] == value for key, value in values.items())]


def mean(runs, key):
    return statistics.fmean(run[key] for run in runs)


def average(key, decimals, factor=1, unit=""):
    """The column of a mean over runs."""
    return lambda runs: f"{factor * mean(runs, key):.{decimals}f}{unit}"


def worst(key, decimals, factor=1, unit=""):
    """The column of the largest among runs."""
    return lambda runs: f"{factor * max(run[key] for run in runs):.{decimals}f}{unit}"


def share_of(runs, holds):
    return f"{sum(map(bool, map(holds, runs)))} of {len(runs)}"


def within(values, bars):
    return all(values[key] <= bar for key, bar in bars.items())


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
    share = f"All {good}" if good == len(judged) else f"**{good} of {len(judged)}**"
    return f"{text}\n{share} {which} are within all bars.\n"


# ---- Files -------------------------------------------------------------------------------------------------------------


def json_text(record):
    """The record with one line per run."""
    head = json.dumps({key: value for key, value in record.items() if key != "runs"}, indent=1)
    runs = ",\n  ".join(map(json.dumps, record["runs"]))
    return f'{head[:-2]},\n "runs": [\n  {runs}\n ]\n}}\n'


def write_results(bench, name, record, page, kept=True, end=None):
    """Writes NAME.md and NAME.json and gives the exit code, by whether the bars are kept, or raises what ended the runs. A
    partial result gets its own name so that it replaces no complete one."""
    stem = name + (".partial" if record["partial"] else "")
    for suffix, content in ((".json", json_text(record)), (".md", page(record).rstrip() + "\n")):
        path = bench.args.out / (stem + suffix)
        draft = path.with_name(path.name + ".tmp")
        draft.write_text(content)
        draft.replace(path)
        print(path, file=sys.stderr)
    if end:
        raise end
    return 0 if kept else 1


def study(bench, name, run, keys, text_of, page, refine=None, holds=None, **facts):
    """Measures run(bench, *key) of all keys, writes what there is, and gives the exit code. refine(results) may add to them
    before, and holds(record) says whether bars are kept that are not those of a single run."""
    facts = circumstances(bench.program) | facts  # before a break, after which nothing is run any more
    results, end = bench.measure(run, keys, text_of)
    if refine:
        refine(results)
    runs = list(results.values())
    if not runs:
        raise end
    backends, configs = {run.pop("backend") for run in runs}, [run.pop("config") for run in runs]
    record = {"partial": end is not None, "ended_by": str(end) if end else None, "runs_planned": len(set(keys)),
              **facts, "backend": ", ".join(sorted(backends)),
              "config": {key: value for key, value in configs[0].items() if key != "seed"}, "runs": runs}
    kept = all(run.get("within_bars", True) for run in runs) and (holds is None or holds(record))
    return write_results(bench, name, record, page, kept, end)
