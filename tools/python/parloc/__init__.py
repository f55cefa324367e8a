"""2D LiDAR localization and mapping: the same code, and the same bits, as the program `parloc`.

Lengths are metres, angles radians (counter-clockwise, 0 along +x), times seconds. Poses are (x, y, theta).
"""

import os as _os

# GNU OpenMP would spin for 3 ms when it waits, and on a busy machine keep the core from the thread it waits for. It reads
# this when it is loaded; what is set already stays.
if "OMP_WAIT_POLICY" not in _os.environ:
    _os.environ.setdefault("GOMP_SPINCOUNT", "3000")

from ._parloc import (  # noqa: E402
    GridMap,
    LiveAnswer,
    LiveLocalizer,
    Pose,
    PreparedLocalizer,
    Settings,
    __version__,
    map_from_message,
    map_message,
    nav2_parameters,
    read_map,
    stamp_of_message,
)
from .errors import BackendError, ConfigError, Error, InputError, OutputError, UsageError  # noqa: E402

__all__ = [
    "BackendError",
    "ConfigError",
    "Error",
    "GridMap",
    "InputError",
    "OutputError",
    "Pose",
    "UsageError",
    "__version__",
    "read_map",
]
