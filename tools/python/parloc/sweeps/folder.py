"""The folder of a sweep: what is to be computed, as files that any scheduler can work on, and whether it is done.

    sweep.yaml          the plan
    configs/0001.yaml   all settings at a point
    parts.txt           a part of the work per line: the words of a `parloc` command
    part.sh             `part.sh N` computes line N
    runs/0001/parts/1/  the results of a part (shard.parloc)
    runs/0001/merged/   what all parts of a run say together
"""

from __future__ import annotations

import fcntl
import math
import shlex
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from ..errors import InputError, OutputError, UsageError
from ..program import expected_version, program_path
from .plan import Plan, Run, config_name, shell_line
from .shard_file import ShardCount

MOST_PARTS = 1_000_000

_PART_SH = """#!/bin/sh
# Computes one part of this sweep: line $1 of parts.txt, counted from 1. Run again it goes on with the trials that are missing.
# PARLOC_PROGRAM: another program; PARLOC_JOBS: trials at once (1).
cd "$(dirname "$0")" || exit 5
program=${PARLOC_PROGRAM:-@PROGRAM@}
command -v "$program" > /dev/null || program=parloc
found=$("$program" --version 2>&1)
if [ "$found" != '@VERSION@' ]; then
  echo "parloc: expected @VERSION@ on $(uname -n), found: $found" >&2
  exit 6
fi
line=$(sed -n "${1:?expected the number of a part}{p;q;}" parts.txt)
if [ -z "$line" ]; then echo "parloc: expected a part from 1 to $(($(wc -l < parts.txt))), got '$1'" >&2; exit 2; fi
eval "set -- $line"
exec "$program" "$@" --jobs "${PARLOC_JOBS:-1}"
"""


@dataclass(frozen=True)
class Part:
    """A shard of a run: line `number` of parts.txt, counted from 1."""

    number: int
    run: Run
    shard: int
    count: ShardCount
    folder: Path

    @property
    def is_done(self) -> bool:
        return self.count.is_whole


class SweepFolder:
    """Made, or found as it was left. Raises InputError if another sweep is there, OutputError if it cannot be written,
    UsageError for another number of parts than it was begun with."""

    def __init__(self, path: str | Path, plan: Plan, parts_per_run: int | None, least_parts: int):
        self.path = Path(path).absolute()
        self.plan = plan
        begun = self._parts_begun_with()
        if begun and parts_per_run and begun != parts_per_run:
            raise UsageError(f"{path}: was begun with {begun} parts per run: expected --parts {begun}, or none")
        self.parts_per_run = begun or parts_per_run or max(1, math.ceil(least_parts / len(plan.runs)))
        self.parts = list(self._parts())
        if len(self.parts) > MOST_PARTS:
            raise UsageError(f"expected at most {MOST_PARTS} parts, found {len(self.parts)}: expected fewer --parts")
        self._write()

    @contextmanager
    def locked(self) -> Iterator[None]:
        """While it is worked on. Raises OutputError if another sweep does."""
        with (self.path / "lock").open("w") as file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                raise OutputError(f"{self.path}: another parloc sweep is at work here") from None
            yield

    def merged(self, run: Run) -> Path:
        """Where the results of a run are, once all its parts are done and merged."""
        return self.path / "runs" / f"{run.number:04d}" / "merged"

    def write(self, name: str, text: str) -> None:
        """A file, whole or not at all. Raises OutputError."""
        path = self.path / name
        draft = path.with_name(path.name + ".tmp")
        with writing(path):
            draft.write_text(text, encoding="utf-8")
            draft.replace(path)

    def _parts_begun_with(self) -> int:
        try:
            with (self.path / "parts.txt").open(encoding="utf-8") as file:
                words = shlex.split(file.readline())
            return int(words[words.index("--shard") + 1].split("/")[1])
        except (OSError, ValueError, IndexError):
            return 0

    def _parts(self) -> Iterator[Part]:
        number = 0
        for run in self.plan.runs:
            for shard in range(1, self._parts_of(run) + 1):
                number += 1
                folder = self.path / self._part_name(run, shard)
                yield Part(number, run, shard, ShardCount(folder / "shard.parloc"), folder)

    def _parts_of(self, run: Run) -> int:
        return min(self.parts_per_run, run.source.trials)

    @staticmethod
    def _part_name(run: Run, shard: int) -> str:
        return f"runs/{run.number:04d}/parts/{shard}"

    def _line(self, part: Part) -> str:
        shard = f"{part.shard}/{self._parts_of(part.run)}"
        into = self._part_name(part.run, part.shard)
        return shell_line((*part.run.words, "--quiet", "--shard", shard, "--out", into))

    def _write(self) -> None:
        texts = {"sweep.yaml": self.plan.text}
        for k, config in enumerate(self.plan.configs, 1):
            texts[config_name(k)] = config.to_yaml()
        texts["parts.txt"] = "".join(self._line(part) + "\n" for part in self.parts)
        missing = [name for name, text in texts.items() if not self._is_there(name, text)]
        if missing:
            with writing(self.path):
                (self.path / "configs").mkdir(parents=True, exist_ok=True)
        for name in missing:
            self.write(name, texts[name])
        script = _PART_SH.replace("@PROGRAM@", shlex.quote(program_path())).replace("@VERSION@", expected_version())
        self.write("part.sh", script)  # says whether the folder can be written, too

    def _is_there(self, name: str, text: str) -> bool:
        try:
            found = (self.path / name).read_text(encoding="utf-8")
        except FileNotFoundError:
            return False
        except OSError as error:
            raise OutputError(f"{self.path / name}: cannot be read: {error.strerror}") from None
        if found == text:
            return True
        old, new = found.splitlines(), text.splitlines()
        line = next((k for k, (a, b) in enumerate(zip(old, new)) if a != b), min(len(old), len(new)))  # noqa: B905
        was = old[line].strip() if line < len(old) else "nothing"
        now = new[line].strip() if line < len(new) else "nothing"
        raise InputError(f"{self.path}: holds another sweep, expected another --out: {name}:{line + 1} is '{was}' there, "
                         f"'{now}' here")


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """What cannot be written becomes one line."""
    try:
        yield
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror}") from None
