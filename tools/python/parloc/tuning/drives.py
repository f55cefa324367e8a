"""Recorded drives and where the robot truly was, cut into pieces: some to fit settings to, later ones to judge them on."""

from __future__ import annotations

import os
from dataclasses import dataclass, field

import numpy as np

from .. import _parloc
from ..errors import InputError
from ..tracks import make_map, run

PIECES = 25
"""Of a log, if they are long enough."""
SHORTEST_S, FEWEST_SCANS = 10.0, 20
"""Of a piece: in less, a start that is off counts for more than the settings."""
LONGEST_S = 120.0
FIT_SHARE = 0.6
"""Of a log's pieces, the first ones; what is judged comes later and is never looked at before."""
FEWEST_PIECES = 4
"""Of a log: two to fit to, two to judge on."""


@dataclass(frozen=True)
class DriveFiles:
    """A log, the map that is localized on, and the true path; what is None comes from mapping the log."""

    log: str
    map: str | None = None
    truth: str | None = None

    def __str__(self) -> str:
        return os.path.basename(os.path.dirname(os.path.abspath(self.log))) + "/" + os.path.basename(self.log)


@dataclass(frozen=True)
class Piece:
    """A stretch of a drive in which the filter starts anew."""

    drive: str
    begin_s: float
    map: _parloc.GridMap
    records: list = field(repr=False)
    truth: np.ndarray = field(repr=False)
    """float64, shape (N, 3): (x_m, y_m, theta_rad) at each scan, NaN where it is not known."""
    start: np.ndarray
    """float64, shape (3,): where the first scan was taken, in the map's frame."""
    same_frame: bool
    """Whether the truth is in the map's frame; else only motion from one time to another can be compared."""


def read_pieces(files: DriveFiles, config: _parloc.Config, kept: str) -> list[Piece]:
    """All pieces of a drive, in the order of its log. Raises InputError for a log that is too short.

    Without a truth, the log is mapped first; map and path are left in the folder `kept`, and taken from there next time.
    A map that was given then has another frame than that path, and where pieces start is what the filter with `config` says,
    which follows the whole log from an unknown start.
    """
    map_file, truth_file = files.map, files.truth
    if truth_file is None:
        own_map, truth_file = _own_map(files.log, config, kept)
        map_file = map_file or own_map
    elif map_file is None:
        raise InputError(f"{files.log}: a drive with a truth needs the map that the truth is in")
    map = _parloc.read_map(map_file)
    records = list(_parloc.open_log(files.log, config).scans(config))
    stamps_s = np.array([r.stamp_s for r in records])
    mapped = files.truth is None
    path = _parloc.read_trajectory(truth_file, config)
    truth = _parloc.poses_at(path, np.round(stamps_s, 6), 0.0) if mapped else _parloc.poses_at(path, stamps_s)
    same_frame = not mapped or files.map is None
    starts = truth if same_frame else _followed(map, records, config)
    pieces = []
    for first, last in _cuts(stamps_s):
        known = np.flatnonzero(np.isfinite(truth[first:last, 0]) & np.isfinite(starts[first:last, 0]))
        if len(known) >= FEWEST_SCANS / 4:  # mapping takes in one of several
            first += known[0]
            pieces.append(
                Piece(
                    str(files), float(stamps_s[first]), map, records[first:last], truth[first:last], starts[first], same_frame
                )
            )
    if len(pieces) < FEWEST_PIECES:
        raise InputError(
            f"{files.log}: expected {FEWEST_PIECES} stretches of {SHORTEST_S:g} s and {FEWEST_SCANS} scans or more "
            f"with a true pose, got {len(pieces)}"
        )
    return pieces


def split(pieces: list[Piece]) -> tuple[list[Piece], list[Piece]]:
    """Pieces of one drive to fit to, and later ones to judge on."""
    fit = max(2, min(len(pieces) - 2, round(FIT_SHARE * len(pieces))))
    return pieces[:fit], pieces[fit:]


def _cuts(stamps_s: np.ndarray) -> list[tuple[int, int]]:
    """First and past-last scan of each piece, in file order: stamps of some logs jump backwards."""
    passed_s = np.maximum.accumulate(stamps_s) - stamps_s[0]
    total_s = float(passed_s[-1])
    length_s = min(LONGEST_S, max(SHORTEST_S, total_s / PIECES))
    count = max(1, min(int(total_s / length_s + 1e-9), len(stamps_s) // FEWEST_SCANS))
    edges = np.searchsorted(passed_s, total_s * np.arange(count + 1) / count)
    edges[-1] = len(stamps_s)
    return [(int(a), int(b)) for a, b in zip(edges, edges[1:], strict=False) if b > a]


def _followed(map: _parloc.GridMap, records: list, config: _parloc.Config) -> np.ndarray:
    """Where the filter is at each scan, (N, 3); NaN where it does not say `tracking`."""
    track = run(_parloc.Localizer(map, config), records, "global")
    return np.where((np.array(track.states) == "tracking")[:, None], track.poses, np.nan)


def _own_map(log: str, config: _parloc.Config, kept: str) -> tuple[str, str]:
    """Maps the log, or finds what was mapped of it before; returns the files of map and path."""
    map_file, path_file = os.path.join(kept, "map.yaml"), os.path.join(kept, "path.tum")
    if not os.path.exists(path_file):  # written last
        os.makedirs(kept, exist_ok=True)
        slam = make_map(log, config)
        path = np.array(slam.trajectory())
        # Between the scans that were taken in, the path is odometry alone.
        path = path[np.isin(path[:, 0], [record.stamp_s for record in slam.records()])]
        slam.map().save(map_file)
        _parloc.write_trajectory(path_file, path)
    return map_file, path_file
