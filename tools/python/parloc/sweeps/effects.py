"""What a sweep says: how good each point is, and what each setting does, on the same trials."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..intervals import Interval, mean_interval
from .table import Table

MOST_VALUES = 6  # of a setting that has more, neighbours are put together


@dataclass(frozen=True)
class PointScore:
    """A point with a filter. `behind` is its success minus that of the first, on the same trials, and `behind_error_m` its
    error minus that of the first, on trials in which both succeeded; None for the first."""

    point: int
    filter: str | None
    success: Interval
    error_m: Interval
    behind: Interval | None = None
    behind_error_m: Interval | None = None

    @property
    def as_good(self) -> bool:
        """Whether the trials cannot tell it from the first, neither by success nor by error."""
        if self.behind is None or self.behind_error_m is None:
            return True
        return self.behind.high >= 0.0 and not self.behind_error_m.low > 0.0


@dataclass(frozen=True)
class Effect:
    """What a value of a setting does, all else being tried alike: means over all other settings. The intervals are those of the
    difference to the mean over all values, on the same trials."""

    label: str
    at: float  # where it is drawn; the place in the list for words
    success: Interval
    error_m: Interval


def wilson(hits: int, count: int) -> Interval:
    """Of a rate."""
    if count == 0:
        return Interval(math.nan, 0.0, 1.0, 0)
    z, share = 1.959964, hits / count
    middle = (share + z * z / (2 * count)) / (1 + z * z / count)
    half = z * math.sqrt(share * (1 - share) / count + z * z / (4 * count * count)) / (1 + z * z / count)
    return Interval(share, max(0.0, middle - half), min(1.0, middle + half), count)


class Scores:
    """The table's numbers, a row of trials per point and filter, and a column per trial (source and seed)."""

    def __init__(self, table: Table):
        filters = table.columns.get("filter") or [None] * len(table)
        trials = list(zip(table.columns["source"], table.columns["seed"], strict=True))
        rows = list(zip(table.columns["point"], filters, strict=True))
        self.rows: list[tuple[int, Any]] = list(dict.fromkeys(rows))
        self.trials: list[tuple[str, int]] = list(dict.fromkeys(trials))
        self.filters: list[Any] = list(dict.fromkeys(filters))
        shape = (len(self.rows), len(self.trials))
        self.success, self.error_m = np.full(shape, np.nan), np.full(shape, np.nan)
        row_at = {row: k for k, row in enumerate(self.rows)}
        trial_at = {trial: k for k, trial in enumerate(self.trials)}
        at = ([row_at[row] for row in rows], [trial_at[trial] for trial in trials])
        succeeded = np.array(table.columns["success"], dtype=np.float64)
        self.success[at] = succeeded
        # How far off one is that failed says nothing.
        errors = np.array(table.columns["error_m"], dtype=np.float64)
        self.error_m[at] = np.where(succeeded > 0, errors, np.nan)

    def points(self) -> list[PointScore]:
        """The best first: by success, then by error."""
        scores = []
        for k, (point, name) in enumerate(self.rows):
            there = self.success[k][~np.isnan(self.success[k])]
            errors = self.error_m[k][~np.isnan(self.error_m[k])]
            scores.append((PointScore(point, name, wilson(int(there.sum()), len(there)), mean_interval(errors)), k))
        scores.sort(key=lambda s: (-s[0].success.mean, s[0].error_m.mean if s[0].error_m.count else math.inf, s[0].point))
        first = scores[0][1] if scores else 0
        return [score if k == first else self._compared(score, k, first) for score, k in scores]

    def _compared(self, score: PointScore, row: int, first: int) -> PointScore:
        success, error = (of[row] - of[first] for of in (self.success, self.error_m))
        return replace(score, behind=mean_interval(success[~np.isnan(success)]),
                       behind_error_m=mean_interval(error[~np.isnan(error)]))

    def effects(self, values_of_points: Sequence[Any], filter_name: Any) -> list[Effect]:
        """Of one setting, which has values_of_points[k - 1] at point k, with one filter."""
        mine = [k for k, (_, name) in enumerate(self.rows) if name == filter_name]
        values = [values_of_points[self.rows[k][0] - 1] for k in mine]
        groups = grouped(values)
        success, success_mean = self._differences(self.success, mine, groups)
        error, error_mean = self._differences(self.error_m, mine, groups)
        return [Effect(label, at, mean_interval(success[g], success_mean), mean_interval(error[g], error_mean))
                for g, (label, at, _) in enumerate(groups)]

    @staticmethod
    def _differences(scores: NDArray[np.float64], rows: list[int], groups: list[Any]) -> tuple[NDArray[np.float64], float]:
        """Per group and trial its mean minus that of all groups, over the trials that all groups have; and the mean of all."""
        with np.errstate(invalid="ignore"):
            means = np.array([nan_mean(scores[[rows[k] for k in members]]) for _, _, members in groups])
        means = means[:, ~np.isnan(means).any(axis=0)]
        return means - means.mean(axis=0), float(means.mean()) if means.size else math.nan


def nan_mean(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Over the first axis, of what is there; nan where nothing is."""
    counts = (~np.isnan(rows)).sum(axis=0)
    return np.where(counts > 0, np.nansum(rows, axis=0) / np.maximum(counts, 1), np.nan)


def grouped(values: Sequence[Any]) -> list[tuple[str, float, list[int]]]:
    """(label, where it is drawn, which of the values), in order: a group per value; of many numbers, of equally many
    neighbours."""
    is_number = all(isinstance(value, (int, float)) and not isinstance(value, bool) for value in values)
    distinct = sorted(set(values)) if is_number else list(dict.fromkeys(map(str, values)))
    if len(distinct) <= MOST_VALUES or not is_number:
        keys = values if is_number else list(map(str, values))
        return [(f"{value:g}" if is_number else value, float(value) if is_number else float(k),
                 [i for i, key in enumerate(keys) if key == value]) for k, value in enumerate(distinct)]
    order = sorted(range(len(values)), key=lambda i: values[i])
    groups = []
    for members in np.array_split(order, max(2, min(MOST_VALUES - 1, len(order) // 3))):
        inside = [values[i] for i in members]
        groups.append((f"{min(inside):.3g} to {max(inside):.3g}", float(np.median(inside)), list(members)))
    return groups
