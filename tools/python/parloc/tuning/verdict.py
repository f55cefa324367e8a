"""Whether the settings found are better than those there were, on drives that nothing was fitted to."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import _parloc
from ..intervals import Interval, mean_interval
from .drives import Piece
from .score import PieceScore
from .search import mean_error_m, scores_of

FINALISTS = 5
"""The best of many tries was lucky too; so many are tried again with seeds that chose none of them."""
FINAL_SEEDS = [101, 102]
"""For that, on the pieces that were fitted to."""
TEST_SEEDS = [201, 202, 203]
"""On the pieces that were kept back."""

Scoring = Callable[[list[tuple[str, bool, list[int]]]], list[list[PieceScore]]]
"""Scores settings (YAML) on the pieces to fit to (False) or on those kept back (True), with these seeds."""


@dataclass(frozen=True)
class Comparison:
    """Two settings on the same pieces with the same seeds."""

    pieces: list[tuple[str, float]]
    """Drive, and stamp of the beginning [s]."""
    base: list[PieceScore]
    """One per piece, means over seeds."""
    tuned: list[PieceScore]

    @property
    def gains_m(self) -> np.ndarray:
        """float64, shape (pieces,): how much smaller the tuned settings' error is."""
        return np.array([b.error_m - t.error_m for b, t in zip(self.base, self.tuned, strict=True)])

    @property
    def gain(self) -> Interval:
        """Over all pieces [m]."""
        return mean_interval(self.gains_m)

    def gain_of(self, drive: str) -> Interval:
        """Over the pieces of one drive [m]."""
        return mean_interval(self.gains_m[[name == drive for name, _ in self.pieces]])


def is_better(comparison: Comparison) -> bool:
    """Whether the whole interval of the gain is above 0, and it is not more often sure and wrong."""
    sure = [np.mean([s.sure_but_wrong for s in side]) for side in (comparison.base, comparison.tuned)]
    return bool(comparison.gain.low > 0 and sure[1] <= sure[0] + 1e-9)


def averaged(scores: list[PieceScore]) -> PieceScore:
    """Means of the same piece over seeds."""
    fields = PieceScore.__dataclass_fields__
    return PieceScore(**{name: float(np.mean([getattr(s, name) for s in scores])) for name in fields})


def score_all(config: str, pieces: list[Piece], seeds: list[int]) -> list[PieceScore]:
    """One per piece, means over seeds; `config` is YAML, since a process of its own may do this."""
    by_piece: dict[int, list[PieceScore]] = {}
    for number, _, score in scores_of(_parloc.Config.from_yaml(config), pieces, seeds):
        by_piece.setdefault(number, []).append(score)
    return [averaged(by_piece[number]) for number in range(len(pieces))]


def finalists(study: Any) -> list[dict[str, Any]]:
    """The best settings so far, the best first; equal ones once."""
    complete = [t for t in study.get_trials(deepcopy=False) if t.state.name == "COMPLETE"]
    best: list[dict[str, Any]] = []
    for trial in sorted(complete, key=lambda t: (t.value, t.number)):
        if trial.params not in best and len(best) < FINALISTS:
            best.append(trial.params)
    return best


def choose(
    candidates: list[str], base: str, score: Scoring
) -> tuple[str, tuple[list[PieceScore], list[PieceScore]], tuple[list[PieceScore], list[PieceScore]]]:
    """The best candidate (YAML), or `base` if that is the best itself; how (base, it) did on fit, and on test."""
    again = score([(config, False, FINAL_SEEDS) for config in [base, *candidates]])
    best = min(range(len(again)), key=lambda k: (mean_error_m(again[k]), k))
    config = [base, *candidates][best]
    test = score([(base, True, TEST_SEEDS), (config, True, TEST_SEEDS)])
    return config, (again[0], again[best]), (test[0], test[1])
