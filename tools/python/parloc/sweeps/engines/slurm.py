"""Array jobs of Slurm. What has ended is told by files in the sweep's folder and by squeue, so that no accounting is needed."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ...errors import BackendError
from ..folder import writing
from .processes import Ended, last_line

_SQUEUE_EVERY_S = 2.0
_PATIENCE_S = 30.0  # for jobs that are cancelled
_MAX_ARRAY_SIZE = 1001  # Slurm's own, where it does not say another

_SCRIPT = """#!/bin/sh
#SBATCH --job-name=parloc-sweep
#SBATCH --array=1-@LAST@@LIMIT@
#SBATCH --requeue
#SBATCH --output=/dev/null
#SBATCH --error=@FOLDER@/%a.err
cd @SWEEP@ || exit 5
part=$(sed -n "${SLURM_ARRAY_TASK_ID}p" @FOLDER@/parts)
PARLOC_JOBS=${SLURM_CPUS_PER_TASK:-1} sh part.sh "$part"
code=$?
echo "$code" > @FOLDER@/"$SLURM_ARRAY_TASK_ID.code"
exit "$code"
"""


@dataclass
class ArrayJob:
    """An array whose task k computes the kth of these parts, counted from 1."""

    job: str
    folder: Path
    at_work: dict[int, int]  # {task: part}


class SlurmEngine:
    """`jobs` tasks at once at most; `options` are sbatch's own, such as --partition=short. All nodes see the sweep's folder at
    the same place. What an earlier sweep that was killed has left in the queue is waited for."""

    def __init__(self, jobs: int | None = None, options: Sequence[str] = ()):
        self._limit = f"%{jobs}" if jobs else ""
        self._options = list(options)
        self._arrays: list[ArrayJob] = []
        self._asked_s = 0.0
        self._unseen: set[tuple[str, int]] = set()

    def start(self, folder: Path, parts: int) -> None:
        for program in ("sbatch", "squeue", "scancel"):
            if not shutil.which(program):
                raise BackendError(f"engine slurm: expected sbatch, squeue and scancel on PATH, found no {program}")
        self._sweep = folder
        said = subprocess.run(["scontrol", "show", "config"], capture_output=True, text=True, check=False).stdout
        found = re.search(r"MaxArraySize\s*=\s*(\d+)", said)
        self._most = max(1, int(found[1]) - 1 if found else _MAX_ARRAY_SIZE - 1)
        for of_job in sorted((folder / "slurm").glob("*/job")):
            numbers = (of_job.parent / "parts").read_text().split()
            job = of_job.read_text().strip()
            left = self._in_queue([job])
            if left:
                at_work = {k: int(n) for k, n in enumerate(numbers, 1) if (job, k) in left}
                self._arrays.append(ArrayJob(job, of_job.parent, at_work))

    def submit(self, numbers: Sequence[int]) -> None:
        adopted = {part for array in self._arrays for part in array.at_work.values()}
        left = [number for number in numbers if number not in adopted]
        for k in range(0, len(left), self._most):
            self._arrays.append(self._submit(left[k : k + self._most]))

    def _submit(self, numbers: Sequence[int]) -> ArrayJob:
        above = self._sweep / "slurm"
        with writing(above):
            above.mkdir(exist_ok=True)
            folder = above / str(1 + max((int(f.name) for f in above.iterdir() if f.name.isdecimal()), default=0))
            folder.mkdir()
            (folder / "parts").write_text("".join(f"{number}\n" for number in numbers))
            script = _SCRIPT.replace("@LAST@", str(len(numbers))).replace("@LIMIT@", self._limit)
            script = script.replace("@FOLDER@", f"slurm/{folder.name}").replace("@SWEEP@", shlex.quote(str(self._sweep)))
            (folder / "job.sh").write_text(script)
        done = subprocess.run(["sbatch", "--parsable", f"--chdir={self._sweep}", *self._options, str(folder / "job.sh")],
                              capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise BackendError(f"engine slurm: {last_line(done.stderr) or 'sbatch failed'}")
        job = done.stdout.strip().split(";")[0]
        with writing(folder):
            (folder / "job").write_text(job + "\n")
        return ArrayJob(job, folder, dict(enumerate(numbers, 1)))

    def ended(self, wait_s: float) -> list[Ended]:
        until = time.monotonic() + wait_s
        while True:
            told = self._told_by_files() + self._told_by_queue()
            if told or time.monotonic() >= until:
                self._arrays = [array for array in self._arrays if array.at_work]
                return told
            time.sleep(0.2)

    def _told_by_files(self) -> list[Ended]:
        told = []
        for array in self._arrays:
            names = [entry.name for entry in os.scandir(array.folder) if entry.name.endswith(".code")]
            for task in {int(name.removesuffix(".code")) for name in names} & array.at_work.keys():
                text = (array.folder / f"{task}.code").read_text().strip()
                if text:
                    told.append(self._end(array, task, int(text)))
        return told

    def _told_by_queue(self) -> list[Ended]:
        """Tasks that are neither in the queue nor have left an exit code: cancelled, or killed with their script. They are
        asked for twice, as a file may come later than the news."""
        if time.monotonic() < self._asked_s + _SQUEUE_EVERY_S or not self._arrays:
            return []
        self._asked_s = time.monotonic()
        queued = self._in_queue([array.job for array in self._arrays])
        if queued is None:
            return []
        gone = {(a.job, task) for a in self._arrays for task in a.at_work} - queued
        told = [self._end(array, task, None) for array in self._arrays for task in list(array.at_work)
                if (array.job, task) in gone & self._unseen]
        self._unseen = gone
        return told

    def _end(self, array: ArrayJob, task: int, code: int | None) -> Ended:
        part = array.at_work.pop(task)
        try:
            said = last_line((array.folder / f"{task}.err").read_text(errors="replace")[-2000:])
        except OSError:
            said = ""
        return Ended(part, code, said or f"task {task} of job {array.job} has left no word")

    @staticmethod
    def _in_queue(jobs: Sequence[str]) -> set[tuple[str, int]] | None:
        """(job, task) of what waits or runs; None if the controller does not answer, while all goes on without it."""
        queued = set()
        for job in jobs:
            words = ["squeue", "-h", "-r", "-j", job, "-o", "%F %K"]
            done = subprocess.run(words, capture_output=True, text=True, check=False)
            if done.returncode != 0 and "Invalid job id" not in done.stderr:
                return None
            for line in done.stdout.splitlines():
                array, task = line.split()
                if task.isdecimal():
                    queued.add((array, int(task)))
        return queued

    def stop(self) -> None:
        jobs = [array.job for array in self._arrays]
        if not jobs:
            return
        subprocess.run(["scancel", *jobs], capture_output=True, check=False)
        until = time.monotonic() + _PATIENCE_S
        while self._in_queue(jobs) and time.monotonic() < until:
            time.sleep(0.5)
