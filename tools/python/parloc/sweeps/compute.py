"""The parts of a sweep, computed by an engine: again where one was killed, and named where one cannot be computed."""

from __future__ import annotations

import itertools
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

from ..errors import BackendError, ConfigError, Error, InputError, OutputError, UsageError
from .engines import Engine
from .engines.processes import Ended
from .folder import SweepFolder

ATTEMPTS = 3
_OF_CODE = {c.exit_code: c for c in (UsageError, InputError, ConfigError, OutputError, BackendError)}
_FOR_GOOD = {UsageError.exit_code, InputError.exit_code, ConfigError.exit_code}  # the same words give the same error
_LOOKED_AT_ONCE = 500  # files of parts, each time that progress is told


@dataclass(frozen=True)
class FailedPart:
    """A part that could not be computed: line `part` of parts.txt, of that run. `code` is its exit code (negative: by that
    signal; None: nobody knows), and `said` the last line of its standard error."""

    part: int
    run: int
    code: int | None
    said: str

    def __str__(self) -> str:
        code = "" if self.code is None else f"signal {-self.code}" if self.code < 0 else f"exit code {self.code}"
        return f"part {self.part} (run {self.run}): {self.said.removeprefix('parloc: ') or code}"


def error_of(code: int | None, said: str) -> Error:
    """What the program has ended with, as an exception."""
    return _OF_CODE.get(code or 0, Error)(said.removeprefix("parloc: ") or f"parloc ended with exit code {code}")


class Computation:
    """Computes what is missing. `tell(trials, all)` is called now and then."""

    def __init__(self, folder: SweepFolder, engine: Engine, attempts: int, tell: Callable[[int, int], object]):
        self._engine = engine
        self._attempts = attempts
        self._tell = tell
        self._folder = folder
        self._parts = {part.number: part for part in folder.parts}
        self._tries: Counter[int] = Counter()
        self._waiting = dict.fromkeys(number for number, part in self._parts.items() if not part.is_done)  # in order
        self._had = {number: part.count.trials for number, part in self._parts.items()}
        self._later: list[tuple[float, int]] = []
        self._told_s = 0.0
        self._failed: list[FailedPart] = []

    def run(self) -> list[FailedPart]:
        """Gives the parts that could not be computed. Raises what ends all parts alike: an engine that is not there, a full
        disk, another version on a worker."""
        self._tell_now_and_then(at_once=True)
        if not self._waiting:
            return []
        try:
            self._engine.start(self._folder.path, len(self._waiting))
            self._engine.submit(sorted(self._waiting))
            while self._waiting:
                for ended in self._engine.ended(0.5):
                    self._take(ended)
                self._submit_again()
                self._tell_now_and_then()
        finally:
            self._engine.stop()
        self._tell_now_and_then(at_once=True)
        return self._failed

    def _take(self, ended: Ended) -> None:
        number, part = ended.number, self._parts[ended.number]
        if number not in self._waiting:
            return
        if part.is_done:
            del self._waiting[number]
            return
        # What goes on is tried on: only ends without a new trial are counted.
        since, self._had[number] = part.count.trials - self._had[number], part.count.trials
        self._tries[number] = 1 if since > 0 else self._tries[number] + 1
        last = self._tries[number] >= self._attempts
        if ended.code == BackendError.exit_code or (ended.code == OutputError.exit_code and last):
            raise error_of(ended.code, ended.said)
        if ended.code in _FOR_GOOD or last:
            del self._waiting[number]
            self._failed.append(FailedPart(number, part.run.number, ended.code, ended.said))
        else:
            self._later.append((time.monotonic() + 2.0 ** (self._tries[number] - 2), number))

    def _submit_again(self) -> None:
        now = time.monotonic()
        numbers = [number for at_s, number in self._later if at_s <= now]
        if numbers:
            self._later = [(at_s, number) for at_s, number in self._later if at_s > now]
            self._engine.submit(numbers)

    def _tell_now_and_then(self, at_once: bool = False) -> None:
        now = time.monotonic()
        if not at_once and now < self._told_s + 1.0:
            return
        self._told_s = now
        for number in itertools.islice(self._waiting, _LOOKED_AT_ONCE):  # those of the front are at work
            self._parts[number].count.update()
        self._tell(sum(part.count.trials for part in self._parts.values()), self._folder.plan.trials)
