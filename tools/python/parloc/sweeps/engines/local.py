"""Processes on this machine; where it has several GPUs, each process has one of them."""

from __future__ import annotations

import os
import re
import subprocess
import time
from collections import deque
from collections.abc import Sequence
from pathlib import Path

from ...program import program_path
from .processes import Ended, PartProcess


class LocalEngine:
    """`jobs` parts at once: as many as there are GPUs that parloc can use, else as many as cores."""

    def __init__(self, jobs: int | None = None):
        self._devices = cuda_devices()
        self.jobs = jobs or len(self._devices) or cores()
        self._waiting: deque[int] = deque()
        self._slots: list[PartProcess | None] = [None] * self.jobs

    def start(self, folder: Path, parts: int) -> None:
        self._folder = folder

    def submit(self, numbers: Sequence[int]) -> None:
        self._waiting.extend(numbers)

    def ended(self, wait_s: float) -> list[Ended]:
        until = time.monotonic() + wait_s
        while True:
            told = []
            for slot, process in enumerate(self._slots):
                ended = process.ended() if process else None
                if ended:
                    told.append(ended)
                    self._slots[slot] = process = None
                if process is None and self._waiting:
                    self._slots[slot] = PartProcess(self._folder, self._waiting.popleft(), self.environment(slot))
            if told or time.monotonic() >= until:
                return told
            time.sleep(0.02)

    def environment(self, slot: int) -> dict[str, str]:
        """Of the processes in a slot. On a GPU many trials step together, so that one process has all cores of its share."""
        if not self._devices:
            return {}
        trials = max(1, cores() // self.jobs)
        return {"CUDA_VISIBLE_DEVICES": self._devices[slot % len(self._devices)], "PARLOC_JOBS": str(trials)}

    def stop(self) -> None:
        self._waiting.clear()
        for process in filter(None, self._slots):
            process.stop()
        self._slots = [None] * self.jobs


def cores() -> int:
    """That this process may use."""
    return len(os.sched_getaffinity(0))


def cuda_devices() -> list[str]:
    """As CUDA_VISIBLE_DEVICES names them, those that this parloc can use."""
    said = subprocess.run([program_path(), "devices"], capture_output=True, text=True, check=False).stdout
    count = len(re.findall(r"^cuda \d+:", said, re.MULTILINE))
    visible = [name for name in os.environ.get("CUDA_VISIBLE_DEVICES", "").split(",") if name]
    return visible[:count] if visible else [str(k) for k in range(count)]
