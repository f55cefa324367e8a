"""2D LiDAR localization and mapping: the same code, and the same bits, as the program `parloc`.

Lengths are metres, angles radians (counter-clockwise, 0 along +x), times seconds. Poses are (x, y, theta);
trajectories are arrays of rows (stamp_s, x_m, y_m, theta_rad).

    import parloc

    localizer = parloc.Localizer(parloc.read_map("my_map.yaml"))
    track = localizer.run("my_bag/", start="global")
    print(track.poses[-1], track.states[-1], track.digest)
"""

import os as _os

# GNU OpenMP would spin for 3 ms when it waits, and on a busy machine keep the core from the thread it waits for. It reads
# this when it is loaded; what is set already stays.
if "OMP_WAIT_POLICY" not in _os.environ:
    _os.environ.setdefault("GOMP_SPINCOUNT", "3000")

from ._parloc import (  # noqa: E402
    BeamCounts,
    Config,
    Estimate,
    Evaluation,
    FlowFilter,
    GlobalSearch,
    GridMap,
    GridSlam,
    Hypothesis,
    LidarUse,
    LiveAnswer,
    LiveLocalizer,
    LiveSlam,
    LiveSlamAnswer,
    Localizer,
    LocalizerEstimate,
    Log,
    LogWarnings,
    Mode,
    ParticleFilter,
    Pose,
    PoseGuess,
    PreparedLocalizer,
    Scan,
    ScanRecord,
    SearchResult,
    Simulation,
    SlamRecord,
    TrackErrors,
    compare_trajectories,
    evaluate,
    map_from_message,
    map_message,
    nav2_parameters,
    poses_at,
    read_config,
    read_map,
    read_trajectory,
    simulate,
    stamp_of_message,
    write_trajectory,
)
from ._parloc import version as __version__  # noqa: E402
from .errors import BackendError, ConfigError, Error, InputError, OutputError, UsageError  # noqa: E402
from .export import to_evo, to_pandas  # noqa: E402
from .plotting import plot_map, plot_trajectory  # noqa: E402
from .sweeps import SweepResult, sweep  # noqa: E402
from .tracks import Track, iter_scans, make_map, open_log  # noqa: E402

__all__ = [
    "BackendError",
    "BeamCounts",
    "Config",
    "ConfigError",
    "Error",
    "Estimate",
    "Evaluation",
    "FlowFilter",
    "GlobalSearch",
    "GridMap",
    "GridSlam",
    "Hypothesis",
    "InputError",
    "LidarUse",
    "LiveAnswer",
    "LiveLocalizer",
    "LiveSlam",
    "LiveSlamAnswer",
    "Localizer",
    "LocalizerEstimate",
    "Log",
    "LogWarnings",
    "Mode",
    "OutputError",
    "ParticleFilter",
    "Pose",
    "PoseGuess",
    "PreparedLocalizer",
    "Scan",
    "ScanRecord",
    "SearchResult",
    "Simulation",
    "SlamRecord",
    "SweepResult",
    "Track",
    "TrackErrors",
    "UsageError",
    "__version__",
    "compare_trajectories",
    "evaluate",
    "iter_scans",
    "make_map",
    "map_from_message",
    "map_message",
    "nav2_parameters",
    "open_log",
    "plot_map",
    "plot_trajectory",
    "poses_at",
    "read_config",
    "read_map",
    "read_trajectory",
    "simulate",
    "stamp_of_message",
    "sweep",
    "to_evo",
    "to_pandas",
    "write_trajectory",
]
