"""Runs over logs, and what they give: one row per scan."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from . import _parloc
from .errors import UsageError
from .progress import ProgressOption, reporting

if TYPE_CHECKING:
    import matplotlib.axes
    import pandas

LogLike = _parloc.Log | str | os.PathLike | Iterable[_parloc.ScanRecord]


def open_log(path: str | os.PathLike, config: _parloc.Config | None = None, **choice: object) -> _parloc.Log:
    """Opens a log of any format: a bag of ROS 1 or 2 (a folder, SQLite, MCAP, bag 2.0), or CARMEN text, plain or gzip.

    What is read of a bag with more than one of a kind is chosen by config.log, or here by the same names:
    `open_log("drive/", scan_topic="/scan")`. Raises InputError, ConfigError for a choice that is none.
    """
    if choice:
        config = config.copy() if config is not None else _parloc.Config()
        config.log = choice
    return _parloc.open_log(path, config)


def iter_scans(log: LogLike, config: _parloc.Config | None = None) -> Iterable[_parloc.ScanRecord]:
    """The scans of a log (or of the file of that name), each with the odometry at its time and before it.

    `config` is that of the filter which takes them: how far ahead odometry is read depends on its LiDARs.
    """
    if isinstance(log, str | os.PathLike):
        log = open_log(log, config)
    return log.scans(config) if isinstance(log, _parloc.Log) else log


class Track:
    """What a filter said of every scan of a log. Arrays have one row per scan, in the order of the log."""

    def __init__(self, map: _parloc.GridMap, stamps_s: list[float], estimates: list[Any], digest: str) -> None:
        self.map = map
        """The map that was localized on."""
        self.estimates = estimates
        """What the filter returned: Estimate, or LocalizerEstimate."""
        self.stamps_s = np.array(stamps_s, dtype=np.float64)
        """float64, shape (N,): stamps of the scans [s]."""
        self.poses = _parloc.poses_of(estimates)
        """float64, shape (N, 3): (x_m, y_m, theta_rad) in the map frame."""
        self.digest = digest
        """The filter's at the end: that of the program."""

    def __len__(self) -> int:
        return len(self.estimates)

    def __repr__(self) -> str:
        return f"<parloc.Track of {len(self)} scans, digest {self.digest[:12]}>"

    @property
    def trajectory(self) -> np.ndarray:
        """float64, shape (N, 4): rows of (stamp_s, x_m, y_m, theta_rad) in the map frame."""
        return np.column_stack([self.stamps_s, self.poses])

    @property
    def covariances(self) -> np.ndarray:
        """float64, shape (N, 3, 3): of (x, y, theta) [m^2, m rad, rad^2]."""
        return _parloc.covariances_of(self.estimates).reshape(-1, 3, 3)

    @property
    def states(self) -> list[str]:
        """'tracking', 'ambiguous' or 'lost' per scan; of a bare filter 'unjudged'."""
        return [getattr(e, "state", "unjudged") for e in self.estimates]

    @property
    def probabilities(self) -> np.ndarray:
        """float64, shape (N,): that the pose is within 0.5 m and 10 degrees; NaN of a bare filter."""
        return np.array([getattr(e, "probability", np.nan) for e in self.estimates], dtype=np.float64)

    def to_pandas(self) -> pandas.DataFrame:
        """A table with one row per scan: pose, standard deviations, state, probability, N_eff, particles. Needs pandas."""
        from .export import track_table

        return track_table(self)

    def to_evo(self) -> Any:
        """The trajectory as evo's PoseTrajectory3D. Needs evo."""
        from .export import to_evo

        return to_evo(self.trajectory)

    def save(self, path: str | os.PathLike) -> None:
        """Writes the trajectory as TUM text. Raises OutputError."""
        _parloc.write_trajectory(path, self.trajectory)

    def errors(self, truth: ArrayLike) -> _parloc.TrackErrors:
        """How far it is from the truth, rows of (stamp_s, x_m, y_m, theta_rad)."""
        return _parloc.compare_trajectories(self.trajectory, truth)

    def plot(self, truth: ArrayLike | None = None, ax: matplotlib.axes.Axes | None = None) -> matplotlib.axes.Axes:
        """Draws map and path, and the truth if it is given. Needs matplotlib."""
        from .plotting import plot_track

        return plot_track(self, truth, ax)


def _start(filter: Any, start: Any) -> None:
    if start is None:
        return
    if not isinstance(start, str):
        filter.start_at(start)
    elif start == "global" and hasattr(filter, "start_anywhere"):
        filter.start_anywhere()
    else:
        raise UsageError(f"start: expected a pose{' or global' if hasattr(filter, 'start_anywhere') else ''}, got '{start}'")


def run(filter: Any, log: LogLike, start: Any = None, progress: ProgressOption = False) -> Track:
    """Takes in all scans of a log: what `filter.run(...)` calls."""
    _start(filter, start)
    stamps_s, estimates = [], []

    def so_far() -> Track:
        return Track(filter.map, stamps_s[: len(estimates)], estimates, filter.digest())

    scans = iter_scans(log, filter.config)
    try:
        with reporting(progress, scans) as tell:
            for record in scans:
                stamps_s.append(record.stamp_s)
                estimates.append(filter.step(record))
                tell(len(estimates))
    except BaseException as stop:
        # Ctrl-C, or a log that is damaged further on: an hour's work is not lost.
        if estimates:
            stop.track = so_far()
        raise
    return so_far()


def run_slam(slam: _parloc.GridSlam, log: LogLike, progress: ProgressOption = False) -> int:
    """Takes in all scans of a log: what `slam.run(...)` calls. Returns how many there were."""
    read = 0
    scans = iter_scans(log, slam.config)
    with reporting(progress, scans) as tell:
        for record in scans:
            slam.step(record)
            read += 1
            tell(read)
    return read


def make_map(
    log: LogLike, config: _parloc.Config | None = None, progress: ProgressOption = False
) -> _parloc.GridSlam:
    """Makes a map of a log as `parloc slam` does: with the odometry from the scans where the recorded one never moves."""
    config = config.copy() if config is not None else _parloc.Config()
    if isinstance(log, str | os.PathLike):
        log = open_log(log, config)
    if isinstance(log, _parloc.Log) and config.slam.odometry == "recorded" and _parloc.odometry_stands_still(log):
        config.slam.odometry = "scans"
    slam = _parloc.GridSlam(config)
    run_slam(slam, log, progress)
    return slam
