"""Workers of Dask: those of a client (of a dask-jobqueue cluster, say), of a scheduler's address, or processes started here."""

from __future__ import annotations

import logging
import queue
import time
import uuid
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ...errors import BackendError
from .processes import Ended, run_part

_PATIENCE_S = 15.0  # for parts that are told to stop


class DaskEngine:
    """`client`: a distributed.Client, the address of a scheduler, or None for `jobs` worker processes on this machine. Workers
    need this package, and see the sweep's folder at the same place."""

    def __init__(self, client: Any = None, jobs: int | None = None):
        self._given = client
        self._jobs = jobs
        self._client: Any = None
        self._cluster: Any = None
        self._at_work: dict[Any, int] = {}
        self._ended: queue.SimpleQueue[Any] = queue.SimpleQueue()

    def start(self, folder: Path, parts: int) -> None:
        try:
            import distributed
        except ImportError:
            raise BackendError("engine dask: expected the package distributed (pip install 'parloc[dask]')") from None
        self._folder = folder
        self._stop_file = folder / f"stop.{uuid.uuid4().hex[:8]}"
        if self._given is not None and not isinstance(self._given, str):
            self._client = self._given
            return
        try:
            if self._given is None:
                self._cluster = distributed.LocalCluster(
                    n_workers=self._jobs, threads_per_worker=1, processes=True, host="127.0.0.1", dashboard_address=None,
                    silence_logs=logging.CRITICAL,
                )
            self._client = distributed.Client(self._cluster or self._given, timeout=5)
        except (OSError, ValueError, RuntimeError) as error:
            raise BackendError(f"engine dask: expected a scheduler at {self._given or 'this machine'}: {error}") from None

    def submit(self, numbers: Sequence[int]) -> None:
        for number in numbers:
            future = self._client.submit(run_part, str(self._folder), number, str(self._stop_file),
                                         key=f"parloc-part-{number}-{uuid.uuid4().hex[:8]}", pure=False)
            self._at_work[future] = number
            future.add_done_callback(self._ended.put)

    def ended(self, wait_s: float) -> list[Ended]:
        told = []
        until = time.monotonic() + wait_s
        while not told or not self._ended.empty():
            try:
                future = self._ended.get(timeout=max(0.0, until - time.monotonic()))
            except queue.Empty:
                break
            told.append(self._told(future, self._at_work.pop(future)))
        if self._client.status != "running":
            raise BackendError(f"engine dask: the scheduler does not answer any more; {len(self._at_work)} parts were at work")
        return told

    @staticmethod
    def _told(future: Any, number: int) -> Ended:
        if future.status == "finished":
            return future.result()
        error = future.exception() if future.status == "error" else None
        if isinstance(error, ImportError):
            return Ended(number, BackendError.exit_code, f"parloc: a worker of Dask has no such package parloc: {error}")
        lines = str(error).splitlines() if error else []
        return Ended(number, None, lines[0] if lines else f"its worker was lost ({future.status})")

    def stop(self) -> None:
        if self._at_work:
            self._stop_file.touch()  # parts at work look for it; those that wait end as soon as they begin
            until = time.monotonic() + _PATIENCE_S
            while any(f.status == "pending" for f in self._at_work) and time.monotonic() < until:
                time.sleep(0.1)
            self._client.cancel(list(self._at_work))
            self._at_work.clear()
            self._stop_file.unlink()
        if self._client is not self._given:
            for closing in filter(None, (self._client, self._cluster)):
                closing.close()
