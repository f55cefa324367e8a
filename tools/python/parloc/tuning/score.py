"""How far off a filter was on a piece of a drive: one number that settings are tuned by, and what is told beside it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..tracks import run
from .drives import Piece

CAP_M = 0.5
"""An error above counts as this one: lost is lost, and a mean over scans with a cap has an interval that means something."""
LEVER_M = 1.0
"""A heading error counts as the way that it moves a point so far ahead of the robot."""
STEP_M = 1.0
"""Way between two poses whose motion is compared, where the truth has another frame than the map."""
START_SIGMA = (0.1, 0.1, 0.05)
"""Of the error of the start that the filter is told [m, m, rad]."""


@dataclass(frozen=True)
class PieceScore:
    """Means over the scans of a piece with a true pose."""

    error_m: float
    """Of the pose, heading included, capped: what is tuned."""
    position_m: float
    heading_rad: float
    wrong: float
    """Share with an error at the cap."""
    sure_but_wrong: float
    """... that said `tracking`."""
    lost: float
    """Share that said `lost`."""
    nees: float
    """Normalised estimation error squared of the scans that are right: 3 is honest, more is over-confident; NaN: not known."""


def score_piece(localizer: Any, piece: Piece, seed: int) -> PieceScore:
    """Runs the localizer over the piece, from a start that is off by as much as `seed` says."""
    rng = np.random.default_rng([seed, int(round(piece.begin_s * 1e6)) & 0x7FFFFFFF])
    off = rng.normal(size=3) * START_SIGMA
    localizer.set_seed(seed)
    localizer.start_at(piece.start + off, sigma=START_SIGMA)
    track = run(localizer, piece.records)
    if piece.same_frame:
        position, heading = _pose_errors(track.poses, piece.truth)
        nees = _nees(track, piece.truth)
    else:
        position, heading = _motion_errors(track.poses, piece.truth)
        nees = np.full(len(position), np.nan)
    states = np.array(track.states)
    known = np.isfinite(position) & np.isfinite(heading)
    lost = states == "lost"
    error = np.minimum(CAP_M, np.hypot(position, LEVER_M * heading))
    if not piece.same_frame:
        error = np.where(lost, CAP_M, error)  # motion alone looks right at a wrong place, too
    wrong = error >= CAP_M
    right_nees = nees[known & ~wrong & np.isfinite(nees)]
    return PieceScore(
        error_m=float(error[known].mean()),
        position_m=float(position[known].mean()),
        heading_rad=float(np.abs(heading[known]).mean()),
        wrong=float(wrong[known].mean()),
        sure_but_wrong=float((wrong & (states == "tracking"))[known].mean()),
        lost=float(lost[known].mean()),
        nees=float(right_nees.mean()) if len(right_nees) else float("nan"),
    )


def _wrapped(angles_rad: np.ndarray) -> np.ndarray:
    return (angles_rad + np.pi) % (2 * np.pi) - np.pi


def _pose_errors(poses: np.ndarray, truth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    off = poses - truth
    return np.hypot(off[:, 0], off[:, 1]), _wrapped(off[:, 2])


def _nees(track: Any, truth: np.ndarray) -> np.ndarray:
    off = track.poses - truth
    off[:, 2] = _wrapped(off[:, 2])
    off = np.nan_to_num(off)
    covariances = track.covariances
    usable = np.linalg.det(covariances) > 0
    nees = np.full(len(off), np.nan)
    nees[usable] = np.einsum("ni,ni->n", off[usable], np.linalg.solve(covariances[usable], off[usable][..., None])[..., 0])
    return np.where(np.isfinite(truth[:, 0]), nees, np.nan)


def _motion_errors(poses: np.ndarray, truth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of the motion over the last STEP_M of way; NaN where that is not known."""
    count = len(truth)
    position, heading = np.full(count, np.nan), np.full(count, np.nan)
    known = np.flatnonzero(np.isfinite(truth[:, 0]))
    if len(known) < 2:
        return position, heading
    steps = np.hypot(*np.diff(truth[known, :2], axis=0).T)
    way_m = np.concatenate([[0.0], np.cumsum(steps)])
    start = np.searchsorted(way_m, way_m - STEP_M, side="right") - 1
    enough = start >= 0
    now, then = known[enough], known[start[enough]]
    mine, true = _relative(poses[then], poses[now]), _relative(truth[then], truth[now])
    off = mine - true
    position[now], heading[now] = np.hypot(off[:, 0], off[:, 1]), _wrapped(off[:, 2])
    return position, heading


def _relative(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """b in the frame of a, row by row."""
    c, s = np.cos(a[:, 2]), np.sin(a[:, 2])
    dx, dy = b[:, 0] - a[:, 0], b[:, 1] - a[:, 1]
    return np.column_stack([c * dx + s * dy, -s * dx + c * dy, b[:, 2] - a[:, 2]])
