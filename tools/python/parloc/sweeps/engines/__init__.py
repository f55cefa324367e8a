"""Who computes the parts of a sweep. An engine takes parts in, tells which have ended, and stops when it is told to."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Protocol

from ...errors import UsageError
from .processes import Ended


class Engine(Protocol):
    """What a sweep needs of an engine. Whether a part is done is told from its folder, never from an exit code."""

    def start(self, folder: Path, parts: int) -> None:
        """Before all else, with the sweep's folder and how many parts are to come. Raises BackendError where the engine is not
        there."""

    def submit(self, numbers: Sequence[int]) -> None:
        """These parts are to be computed: lines of parts.txt."""

    def ended(self, wait_s: float) -> list[Ended]:
        """Parts that have come to an end since the last call, done or not; waits so long for the first."""

    def stop(self) -> None:
        """Ends what is at work; trials that are finished stay."""


def engine_of(engine: Any, jobs: int | None, options: Sequence[str] = ()) -> Engine:
    """By name ("local", "slurm", "dask"), or of a Dask client, the address of its scheduler ("tcp://..."), or an engine."""
    from . import local, slurm

    if hasattr(engine, "submit") and hasattr(engine, "ended"):
        return engine
    if not isinstance(engine, str) or engine == "dask" or "://" in engine:
        from . import dask

        return dask.DaskEngine(None if engine == "dask" else engine, jobs)
    if engine == "local":
        return local.LocalEngine(jobs)
    if engine == "slurm":
        return slurm.SlurmEngine(jobs, options)
    raise UsageError(f"engine: expected local, slurm, dask, none, or the address or client of a Dask scheduler, got '{engine}'")
