"""Results in the forms of other packages, which are imported only when they are asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

if TYPE_CHECKING:
    import pandas

    from .tracks import Track


def to_evo(trajectory: ArrayLike) -> Any:
    """Rows of (stamp_s, x_m, y_m, theta_rad) as evo's PoseTrajectory3D, z = 0. Needs evo."""
    from evo.core.trajectory import PoseTrajectory3D

    rows = np.asarray(trajectory, dtype=np.float64).reshape(-1, 4)
    half, zero = rows[:, 3] / 2, np.zeros(len(rows))
    return PoseTrajectory3D(
        positions_xyz=np.column_stack([rows[:, 1:3], zero]),
        orientations_quat_wxyz=np.column_stack([np.cos(half), zero, zero, np.sin(half)]),
        timestamps=rows[:, 0],
    )


def to_pandas(trajectory: ArrayLike) -> pandas.DataFrame:
    """Rows of (stamp_s, x_m, y_m, theta_rad) as a table with these columns. Needs pandas."""
    import pandas

    rows = np.asarray(trajectory, dtype=np.float64).reshape(-1, 4)
    return pandas.DataFrame(rows, columns=["stamp_s", "x_m", "y_m", "theta_rad"])


def track_table(track: Track) -> pandas.DataFrame:
    """What Track.to_pandas() gives."""
    table = to_pandas(track.trajectory)
    variances = np.diagonal(track.covariances, axis1=1, axis2=2)
    for k, name in enumerate(["sigma_x_m", "sigma_y_m", "sigma_theta_rad"]):
        table[name] = np.sqrt(variances[:, k])
    steps = [getattr(e, "filter", e) for e in track.estimates]
    table["state"] = track.states
    table["probability"] = track.probabilities
    table["n_eff"] = [e.n_eff for e in steps]
    table["particles"] = [e.particles for e in steps]
    table["weighted"] = [e.weighted for e in steps]
    return table
