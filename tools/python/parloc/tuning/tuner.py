"""Settings for a robot from its recorded drives: search, and verdict on drives that were kept back."""

from __future__ import annotations

import concurrent.futures
import dataclasses
import hashlib
import json
import multiprocessing
import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from .. import _parloc
from ..errors import InputError, OutputError, UsageError
from .drives import DriveFiles, Piece, read_pieces, split
from .score import PieceScore
from .search import finished, search
from .space import DEFAULT_SPACE, Choice, Range, Space, check, configured
from .verdict import Comparison, Scoring, choose, finalists, is_better, score_all

DOUBTFUL_WRONG = 0.5
"""Share of wrong scans from which on it is rather the map, or the truth, that is wrong."""

Progress = Callable[[str, float], object]
"""Told what is at work and how much of it is done, 0 to 1."""


@dataclass(frozen=True)
class Tuning:
    """What `tune` found. Errors are means over a piece's scans of the capped error of the pose [m] (docs/tune.md)."""

    better: bool
    """Whether the settings found are shown to be better on drives that nothing was fitted to; else `config` is the old one."""
    config: _parloc.Config
    """What to use."""
    found: dict[str, Any]
    """The settings that were best on the pieces fitted to, by name; empty if the old ones were."""
    base: _parloc.Config
    """The old settings."""
    space: Space
    """What was tuned, and between what."""
    fit: Comparison
    """Old and found settings on the pieces that were fitted to, with seeds that chose none of them."""
    test: Comparison
    """Old and found settings on the pieces that were kept back."""
    tried: int
    """Settings tried."""
    out: str
    """The folder of tune.json, report.html, and tuned.yaml if they are better."""
    study: Any = field(repr=False)
    """Optuna's study, for its own plots."""

    @property
    def found_config(self) -> _parloc.Config:
        """The old settings with those found, better or not."""
        return configured(self.base, self.found)


@dataclass(frozen=True)
class Reader:
    """Reads pieces in any process: those to fit to, and those kept back."""

    drives: list[DriveFiles]
    base: str
    out: str

    def both(self) -> tuple[list[Piece], list[Piece]]:
        """(fit, test), drive by drive."""
        fit: list[Piece] = []
        test: list[Piece] = []
        base = _parloc.Config.from_yaml(self.base)
        for number, files in enumerate(self.drives):
            mine = split(read_pieces(files, base, os.path.join(self.out, f"own_map_{number + 1}")))
            fit += mine[0]
            test += mine[1]
        return fit, test

    def __call__(self) -> list[Piece]:
        return self.both()[0]


_pieces: tuple[list[Piece], list[Piece]]  # of a process that scores


def _read_once(reader: Reader) -> None:
    global _pieces
    _pieces = reader.both()


def _score(config: str, kept_back: bool, seeds: list[int]) -> list[PieceScore]:
    return score_all(config, _pieces[kept_back], seeds)


@contextmanager
def _scoring(jobs: int, reader: Reader, pieces: tuple[list[Piece], list[Piece]]) -> Iterator[Scoring]:
    """Gives what scores several settings, in processes if there is more than one job."""
    if jobs == 1:
        yield lambda work: [score_all(config, pieces[kept_back], seeds) for config, kept_back, seeds in work]
        return
    spawn = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(jobs, spawn, initializer=_read_once, initargs=(reader,)) as pool:
        yield lambda work: list(pool.map(_score, *zip(*work, strict=True)))


def tune(
    drives: list[DriveFiles],
    out: str | os.PathLike,
    settings: Space | None = None,
    config: _parloc.Config | None = None,
    trials: int = 100,
    jobs: int = 0,
    seed: int = 1,
    progress: Progress | None = None,
) -> Tuning:
    """Looks for settings with which the localizer is closer to the truth on these drives, and judges them on later pieces.

    Each log is cut into stretches in which the localizer starts anew; settings are fitted to the first 60 % and judged on
    the rest, with other seeds. `drives` without a truth are mapped first. `settings` says what is tuned and between what
    (by default the noise of wheels and LiDAR), `config` what is not. `jobs` processes work, 0: as many as cores; the same
    call goes on where it was stopped, and several machines with the folder `out` in common work together. With one job the
    same call gives the same answer; with more, which settings are tried depends on who is done first.

    Raises UsageError, InputError, ConfigError, OutputError if `out` cannot be written or has another search in it, and
    ImportError without Optuna.
    """
    import optuna  # noqa: F401  said before anything is done

    if not drives:
        raise UsageError("drives: expected at least one")
    if trials < 1:
        raise UsageError(f"trials: expected at least 1, got {trials}")
    if jobs < 0:
        raise UsageError(f"jobs: expected at least 1, or 0 for all cores, got {jobs}")
    base = config.copy() if config is not None else _parloc.Config()
    base.threads = 1
    base.backend = "cpu"
    space = DEFAULT_SPACE if settings is None else settings
    check(space, base)
    folder = os.fspath(out)
    _begin(folder, _question(drives, space, base, seed))
    reader = Reader(drives, str(base), folder)
    tell = progress or (lambda what, share: None)
    tell("reading", 0.0)
    fit, test = reader.both()  # what is wrong is said at once, and maps are made once
    jobs = jobs if jobs > 0 else os.cpu_count() or 1
    study = search(folder, space, base, reader, trials, jobs, seed, lambda done: tell("trying", min(1.0, done / trials)))

    tell("judging", 0.0)
    found = finalists(study)
    texts = [str(configured(base, values)) for values in found]
    with _scoring(jobs, reader, (fit, test)) as score:
        best, on_fit, on_test = choose(texts, str(base), score)
    comparison = Comparison([(p.drive, p.begin_s) for p in test], *on_test)
    better = best != str(base) and is_better(comparison)
    return Tuning(
        better=better,
        config=_usable(best if better else str(base), config),
        found=found[texts.index(best)] if best in texts and best != str(base) else {},
        base=_usable(str(base), config),
        space=space,
        fit=Comparison([(p.drive, p.begin_s) for p in fit], *on_fit),
        test=comparison,
        tried=finished(study),
        out=folder,
        study=study,
    )


def _usable(text: str, given: _parloc.Config | None) -> _parloc.Config:
    """Those settings with the threads and the backend of the configuration that was given."""
    config = _parloc.Config.from_yaml(text)
    given = given if given is not None else _parloc.Config()
    config.threads, config.backend = given.threads, given.backend
    return config


def _question(drives: list[DriveFiles], space: Space, base: _parloc.Config, seed: int) -> dict[str, Any]:
    """All that decides what is looked for: two runs with the same belong to one search."""
    files = sorted({name for d in drives for name in (d.log, d.truth) if name is not None})
    return {
        "version": _parloc.version,
        "drives": [dataclasses.asdict(d) for d in drives],
        "files": {name: _sha256(name) for name in files},
        "maps": {d.map: _map_sha256(d.map) for d in drives if d.map is not None},
        "settings": {n: {"kind": type(v).__name__, **_plain(v)} for n, v in space.items()},
        "base": str(base),
        "seed": seed,
    }


def _plain(allowed: Range | Choice) -> dict[str, Any]:
    return {k: list(v) if isinstance(v, tuple) else v for k, v in dataclasses.asdict(allowed).items()}


def _sha256(path: str) -> str:
    """Of a file; of a folder, such as a bag, of its files by name."""
    digest = hashlib.sha256()
    names = sorted(os.path.join(path, n) for n in os.listdir(path)) if os.path.isdir(path) else [path]
    try:
        for name in names:
            if os.path.isfile(name):
                with open(name, "rb") as file:
                    for block in iter(lambda: file.read(1 << 20), b""):
                        digest.update(block)
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    return digest.hexdigest()


def _map_sha256(path: str) -> str:
    map = _parloc.read_map(path)
    return hashlib.sha256(map.cells.tobytes() + repr((map.resolution_m, *map.origin)).encode()).hexdigest()


def _begin(folder: str, question: dict[str, Any]) -> None:
    """Makes the folder of a search, or finds the same search in it."""
    path = os.path.join(folder, "search.json")
    text = json.dumps(question, indent=1, sort_keys=True)
    try:
        os.makedirs(folder, exist_ok=True)
        if os.path.exists(path):
            with open(path) as file:
                old = json.load(file)
            for key in question:
                if old.get(key) != json.loads(text)[key]:
                    raise OutputError(f"{folder}: holds a search with other {key}; give another folder, or delete this one")
            return
        with open(f"{path}.{os.getpid()}", "w") as file:
            file.write(text)
        os.replace(file.name, path)
    except (OSError, ValueError) as error:
        if isinstance(error, OutputError):
            raise
        raise OutputError(f"{path}: {error}") from None


def summary(tuning: Tuning) -> str:
    """One sentence: what came out."""
    gain, before = tuning.test.gain, sum(s.error_m for s in tuning.test.base) / len(tuning.test.base)
    if not tuning.found:
        return f"Nothing to gain: none of {tuning.tried} settings tried is better than those there were."
    what = f"{abs(gain.mean) * 1000:.1f} mm {'less' if gain.mean > 0 else 'more'} error than {before * 1000:.1f} mm before"
    told = (
        f"{what} on {gain.count} pieces kept back, 95 % interval of the gain {gain.low * 1000:.1f} to {gain.high * 1000:.1f} mm"
    )
    if tuning.better:
        return f"Better: {told}."
    if gain.low > 0:
        return f"Not used, since it is more often sure and wrong: {told}."
    return f"Nothing to gain that could be shown: {told}."


def doubt(tuning: Tuning) -> str:
    """What makes the whole search doubtful, as one sentence; empty if nothing does."""
    wrong = sum(s.wrong for s in tuning.fit.base) / len(tuning.fit.base)
    if wrong < DOUBTFUL_WRONG:
        return ""
    return f"The old settings are wrong in {100 * wrong:.0f} % of the scans: are map and truth those of these drives?"


def now() -> str:
    """UTC, to the minute."""
    return time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime())
