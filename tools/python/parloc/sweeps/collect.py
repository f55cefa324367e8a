"""What all parts of a sweep say together: `parloc merge` of every run, and one table of all trials."""

from __future__ import annotations

import json
import math
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from ..program import program_path
from .compute import error_of
from .engines.local import cores
from .engines.processes import last_line
from .folder import Part, SweepFolder
from .plan import Run
from .table import Table

# Of a trial's numbers these two are in every table; the others are those of the command's JSON.
COMMON = ("success", "error_m")


def merge_runs(folder: SweepFolder) -> list[Run]:
    """Merges every run whose parts are all done, unless that was done before; gives these runs. Raises what `parloc merge`
    ends with: parts that do not belong together, of another version say, are named and never merged."""
    parts: dict[int, list[Part]] = {}
    for part in folder.parts:
        parts.setdefault(part.run.number, []).append(part)
    whole = [run for run in folder.plan.runs if all(part.is_done for part in parts[run.number])]
    with ThreadPoolExecutor(cores()) as pool:
        list(pool.map(lambda run: merge_run(folder, run, parts[run.number]), whole))
    return whole


def merge_run(folder: SweepFolder, run: Run, parts: list[Part]) -> None:
    merged = results_file(folder, run)
    if merged.exists():
        made_s = merged.stat().st_mtime
        if all((part.folder / "shard.parloc").stat().st_mtime <= made_s for part in parts):
            return
    folders = [str(part.folder.relative_to(folder.path)) for part in parts]
    into = str(folder.merged(run).relative_to(folder.path))
    done = subprocess.run([program_path(), "merge", *folders, "--out", into, "--quiet"], cwd=folder.path, capture_output=True,
                          text=True, check=False)
    if done.returncode != 0:
        raise error_of(done.returncode, last_line(done.stderr))


def results_file(folder: SweepFolder, run: Run) -> Path:
    return folder.merged(run) / f"{folder.plan.command}.json"


def table_of(folder: SweepFolder, runs: list[Run]) -> Table:
    """A row per trial (and filter): point, source, filter, the settings by their names, seed, success, error_m, and the numbers
    that the command gives for a trial."""
    rows: list[tuple[Run, str | None, dict[str, Any]]] = []
    for run in runs:
        results = json.loads(results_file(folder, run).read_text(encoding="utf-8"))
        if folder.plan.command == "evaluate":
            rows += [(run, None, evaluate_numbers(trial)) for trial in results["trials"]]
        else:
            rows += [(run, f["filter"], compare_numbers(each)) for f in results["filters"] for each in f["each"]]
    settings = [r.name for r in folder.plan.ranges]
    numbers = [name for name in (rows[0][2] if rows else {}) if name not in ("seed", *COMMON)]
    names = ("point", "source", "filter", *settings, "seed", *COMMON, *numbers)
    columns: dict[str, list[Any]] = {name: [] for name in names}
    for run, filter_name, trial in rows:
        point = folder.plan.points[run.point - 1]
        row = {"point": run.point, "source": run.source.name, "filter": filter_name, **point, **trial}
        for name, values in columns.items():
            values.append(row.get(name))
    if folder.plan.command == "evaluate":
        del columns["filter"]
    return Table(columns)


def evaluate_numbers(trial: dict[str, Any]) -> dict[str, Any]:
    """error_m: root of the mean squared distance to the truth since it was localized; None if it never was."""
    start = dict(zip(("start_x_m", "start_y_m", "start_theta_rad"), trial.pop("start"), strict=True))
    squared = trial.pop("mean_squared_error_m2")
    return {**trial, "error_m": None if squared is None else math.sqrt(squared), **start}


def compare_numbers(each: dict[str, Any]) -> dict[str, Any]:
    """success: not lost at its end."""
    return {**each, "success": not each["lost"], "error_m": each["position_rmse_m"]}
