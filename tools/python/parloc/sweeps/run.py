"""parloc.sweep(): reads a plan, has its parts computed, and says what came out."""

from __future__ import annotations

import contextlib
import datetime
import importlib.util
import platform
import shlex
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..program import expected_version
from .collect import merge_runs, table_of
from .compute import ATTEMPTS, Computation, FailedPart
from .engines import engine_of
from .engines.local import cores
from .folder import SweepFolder
from .page import page_of
from .plan import read_plan
from .table import Table

Progress = bool | Callable[[int, int], object]
"""False: nothing is told; True: a line on standard error; a function: called with the trials that are done, and all."""


@dataclass(frozen=True)
class SweepResult:
    """What a sweep has found. `table` has a row per trial; `failed` are parts that could not be computed, and `missing` is the
    number of runs that are therefore not in the table."""

    folder: Path
    table: Table = field(repr=False)
    failed: tuple[FailedPart, ...] = ()
    missing: int = 0

    @property
    def page(self) -> Path:
        """A page with plots, which stands alone."""
        return self.folder / "report.html"

    def save(self, path: str | Path) -> None:
        """The table as .csv or .parquet (which needs pyarrow). Raises OutputError, UsageError, BackendError."""
        self.table.save(path)


def sweep(plan: str | Path, *, out: str | Path, engine: Any = "local", jobs: int | None = None, parts: int | None = None,
          attempts: int = ATTEMPTS, options: Sequence[str] = (), progress: Progress = False) -> SweepResult:
    """Trials over ranges of settings, on one or many machines (docs/sweeps.md).

    `plan` is the sweep's file, `out` its folder. `engine` is "local" (`jobs` processes), "slurm" (`options` are sbatch's),
    "dask" (`jobs` workers on this machine), the address of a Dask scheduler, a Dask client, or "none", which
    prepares the folder for other schedulers and collects what these have computed. `parts` is into how many parts the trials
    of each point are divided. A part that is killed is tried again, `attempts` times without a new trial, and goes on where it
    was. The same sweep in the same folder goes on with what is missing. The results are the same for every engine, to the bit.

    Raises ConfigError or InputError before anything is run if the plan makes no sense, or another sweep is in the folder;
    OutputError if that cannot be written, BackendError if the engine is not there or a worker has another version.
    KeyboardInterrupt leaves all trials that were finished in the folder."""
    read = read_plan(plan)
    worker = None if engine == "none" else engine_of(engine, jobs, options)
    folder = SweepFolder(out, read, parts, 4 * (jobs or cores()))
    with folder.locked():
        failed: list[FailedPart] = []
        if worker:
            with told(progress) as tell:
                failed = Computation(folder, worker, attempts, tell).run()
        return collected(folder, failed)


def collected(folder: SweepFolder, failed: Sequence[FailedPart]) -> SweepResult:
    """Merges what is whole, and writes table and page."""
    runs = merge_runs(folder)
    table = table_of(folder, runs)
    result = SweepResult(folder.path, table, tuple(failed), len(folder.plan.runs) - len(runs))
    table.save(folder.path / "table.csv")
    if importlib.util.find_spec("pyarrow"):
        table.save(folder.path / "table.parquet")
    command = shlex.join(["parloc", "sweep", folder.plan.file, "--out", str(folder.path)])
    now = datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")
    machine = f"{expected_version()}, collected on {platform.node()} at {now}"
    folder.write("report.html", page_of(folder, table, result.failed, result.missing, command, machine))
    return result


@contextlib.contextmanager
def told(progress: Progress) -> Iterator[Callable[[int, int], object]]:
    """What is called with the trials that are done, and all."""
    if progress is True:
        line = ProgressLine()
        try:
            yield line.update
        finally:
            line.end()
    else:
        yield progress or (lambda done, of: None)


class ProgressLine:
    """On standard error: anew in place on a terminal, else a line every half minute."""

    def __init__(self) -> None:
        self._begun_s = time.monotonic()
        self._told_s = 0.0
        self._first: int | None = None
        self._last = -1
        self._is_terminal = sys.stderr.isatty()

    def update(self, done: int, of: int) -> None:
        now = time.monotonic()
        if self._first is None:
            self._first = done
        if not self._is_terminal and (done == self._last or (now < self._told_s + 30.0 and done < of)):
            return
        self._told_s, self._last = now, done
        text = f"{done} of {of} trials"
        new, took_s = done - self._first, now - self._begun_s
        if new and done < of:
            left_s = int(took_s * (of - done) / new)
            text += f", {left_s // 3600}:{left_s // 60 % 60:02d}:{left_s % 60:02d} left"
        sys.stderr.write(f"\r{text:<50}" if self._is_terminal else text + "\n")
        sys.stderr.flush()

    def end(self) -> None:
        if self._is_terminal:
            sys.stderr.write("\r" + " " * 50 + "\r")
