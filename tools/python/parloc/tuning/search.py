"""The search for settings: a study of Optuna in a journal on disk, worked on by many processes."""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

from .. import _parloc
from ..errors import ConfigError, Error, OutputError
from .drives import Piece
from .score import PieceScore, score_piece
from .space import Space, base_values, configured, suggest

STUDY = "parloc"
FIT_SEED = 1
"""Of the filter and of the errors of its starts, while it is tuned."""


def open_study(folder: str, seed: int = 0) -> Any:
    """The study whose journal is in that folder; begun if there is none. Other processes may be at work on it."""
    import optuna

    optuna.logging.set_verbosity(optuna.logging.WARNING)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
        from optuna.storages import JournalStorage
        from optuna.storages.journal import JournalFileBackend, JournalFileOpenLock

        path = os.path.join(folder, "journal.log")
        return optuna.create_study(
            study_name=STUDY,
            storage=JournalStorage(JournalFileBackend(path, lock_obj=JournalFileOpenLock(path))),
            sampler=optuna.samplers.TPESampler(seed=seed, multivariate=True, constant_liar=True, n_startup_trials=15),
            pruner=optuna.pruners.MedianPruner(n_startup_trials=15, n_warmup_steps=4),
            load_if_exists=True,
        )


def scores_of(config: _parloc.Config, pieces: list[Piece], seeds: list[int], stop: Callable[[], bool] = lambda: False) -> Any:
    """Yields (piece's number, seed, PieceScore); a localizer is made once per map."""
    localizers: dict[int, Any] = {}
    for seed in seeds:
        for number, piece in enumerate(pieces):
            if stop():
                raise KeyboardInterrupt
            if id(piece.map) not in localizers:
                localizers[id(piece.map)] = _parloc.Localizer(piece.map, config)
            yield number, seed, score_piece(localizers[id(piece.map)], piece, seed)


def mean_error_m(scores: list[PieceScore]) -> float:
    """What is made small: the mean over pieces."""
    return float(np.mean([s.error_m for s in scores]))


def finished(study: Any) -> int:
    """How many settings have been tried, those given up early included."""
    return sum(t.state.is_finished() and t.state.name != "FAIL" for t in study.get_trials(deepcopy=False))


def try_one(study: Any, space: Space, base: _parloc.Config, pieces: list[Piece], stop: Callable[[], bool]) -> None:
    """Tries one set of settings on all pieces, or on the first ones if it does badly there."""
    import optuna

    trial = study.ask()
    done: list[PieceScore] = []
    try:
        config = configured(base, suggest(trial, space, base))
        for number, _, score in scores_of(config, pieces, [FIT_SEED], stop):
            done.append(score)
            trial.report(mean_error_m(done), number)
            if trial.should_prune():
                break
    except Error as impossible:  # settings that do not go together
        trial.set_user_attr("error", str(impossible))
        study.tell(trial, state=optuna.trial.TrialState.PRUNED)
    except BaseException:
        study.tell(trial, state=optuna.trial.TrialState.FAIL)
        raise
    else:
        if len(done) == len(pieces):
            study.tell(trial, mean_error_m(done))
        else:
            study.tell(trial, state=optuna.trial.TrialState.PRUNED)


def _work(
    folder: str, seed: int, trials: int, space: Space, base_text: str, read: Callable[[], list[Piece]], stop: Any, ended: Any
) -> None:
    """A worker: until enough have been tried, by whomever. What it cannot go on from is told in `ended`, a queue."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent says when to stop
    parent = os.getppid()

    def told_to_stop() -> bool:
        return stop.is_set() or os.getppid() != parent

    try:
        base = _parloc.Config.from_yaml(base_text)
        pieces = read()
        study = open_study(folder, seed)
        while finished(study) < trials and not told_to_stop():
            try_one(study, space, base, pieces, told_to_stop)
    except KeyboardInterrupt:
        pass
    except Error as error:
        ended.put(error)
    except OSError as error:
        ended.put(OutputError(f"{folder}: {error.strerror}"))


def search(
    folder: str,
    space: Space,
    base: _parloc.Config,
    read: Callable[[], list[Piece]],
    trials: int,
    jobs: int,
    seed: int,
    tell: Callable[[int], object],
) -> Any:
    """Tries settings until `trials` have been tried in all, those of earlier runs and of other machines included.

    Returns the study. Raises OutputError if the journal cannot be written, ConfigError if no settings can be.
    `read` gives the pieces to fit to, and is pickled for other processes; one job is done in this one.
    `tell` is called now and then with the number tried. A worker that dies costs the settings it was at.
    """
    try:
        study = open_study(folder, seed)
        if not study.get_trials(deepcopy=False):
            study.enqueue_trial(base_values(space, base))  # what there is has its chance
        if jobs == 1:
            pieces = read()
            while finished(study) < trials:
                tell(finished(study))
                try_one(study, space, base, pieces, lambda: False)
        else:
            _search_with_workers(study, (folder, seed, trials, space, str(base), read), jobs, tell)
    except OSError as error:
        if isinstance(error, Error):
            raise
        raise OutputError(f"{folder}: {error.strerror}") from None
    _refuse_impossible(study)
    return study


def _refuse_impossible(study: Any) -> None:
    """Raises ConfigError if none of the settings go together."""
    tried = study.get_trials(deepcopy=False)
    reasons = [t.user_attrs["error"] for t in tried if "error" in t.user_attrs]
    if reasons and not any(t.state.name == "COMPLETE" for t in tried):
        raise ConfigError(f"none of {len(reasons)} settings tried can be: {reasons[0]}")


def _search_with_workers(study: Any, work: tuple, jobs: int, tell: Callable[[int], object]) -> None:
    folder, seed, trials, *what = work
    spawn = multiprocessing.get_context("spawn")  # a forked filter would wait for threads that are not there
    stop, ended = spawn.Event(), spawn.SimpleQueue()
    workers = [
        spawn.Process(target=_work, args=(folder, seed + k, trials, *what, stop, ended), daemon=True) for k in range(jobs)
    ]
    try:
        for worker in workers:
            worker.start()
        while any(worker.is_alive() for worker in workers):
            time.sleep(0.2)
            tell(finished(study))
    finally:
        stop.set()
        for worker in workers:
            worker.join(timeout=30)
    if finished(study) < trials:
        if not ended.empty():
            raise ended.get()
        codes = sorted({w.exitcode for w in workers if w.exitcode})
        raise Error(f"{finished(study)} of {trials} settings were tried: all workers ended (exit codes {codes})")
