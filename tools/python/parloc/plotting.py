"""Pictures by matplotlib, which is imported only when one is asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from . import _parloc

if TYPE_CHECKING:
    import matplotlib.axes

    from .tracks import Track

_GREYS = np.array([255, 0, 205], dtype=np.uint8)  # free, occupied, unknown: as map_server has them


def plot_map(map: _parloc.GridMap, ax: matplotlib.axes.Axes | None = None) -> matplotlib.axes.Axes:
    """Draws a map in its own frame, in metres; returns the axes. Needs matplotlib."""
    import matplotlib.pyplot as plt
    from matplotlib.transforms import Affine2D

    if ax is None:
        ax = plt.gca()
    x_m, y_m, theta_rad = map.origin
    size_m = (map.width * map.resolution_m, map.height * map.resolution_m)
    to_map = Affine2D().rotate(theta_rad).translate(x_m, y_m)
    ax.imshow(
        _GREYS[map.cells], cmap="gray", vmin=0, vmax=255, origin="lower", interpolation="nearest",
        extent=(0, size_m[0], 0, size_m[1]), transform=to_map + ax.transData,
    )
    corners = to_map.transform([(0, 0), (size_m[0], 0), size_m, (0, size_m[1])])
    ax.set_xlim(corners[:, 0].min(), corners[:, 0].max())
    ax.set_ylim(corners[:, 1].min(), corners[:, 1].max())
    ax.set_aspect("equal")
    ax.set_xlabel("x [m]")
    ax.set_ylabel("y [m]")
    return ax


def plot_trajectory(trajectory: ArrayLike, ax: matplotlib.axes.Axes | None = None, **style: Any) -> matplotlib.axes.Axes:
    """Draws rows of (stamp_s, x_m, y_m, theta_rad) as a line; `style` is that of Axes.plot. Needs matplotlib."""
    import matplotlib.pyplot as plt

    if ax is None:
        ax = plt.gca()
    rows = np.asarray(trajectory, dtype=np.float64).reshape(-1, 4)
    ax.plot(rows[:, 1], rows[:, 2], **style)
    return ax


def plot_track(track: Track, truth: ArrayLike | None, ax: matplotlib.axes.Axes | None) -> matplotlib.axes.Axes:
    """What Track.plot() draws."""
    ax = plot_map(track.map, ax)
    if truth is not None:
        plot_trajectory(truth, ax, color="tab:green", linewidth=2.5, alpha=0.6, label="truth")
    plot_trajectory(track.trajectory, ax, color="tab:blue", linewidth=1.0, label="estimate")
    ax.legend()
    return ax


def plot_filter(filter: Any, most: int = 2000, ax: matplotlib.axes.Axes | None = None) -> matplotlib.axes.Axes:
    """What filter.plot() draws."""
    ax = plot_map(filter.map, ax)
    particles = filter.particles(most)
    ax.scatter(particles[:, 0], particles[:, 1], s=2, color="tab:red", label="particles")
    return ax


def plot_slam(slam: _parloc.GridSlam, ax: matplotlib.axes.Axes | None = None) -> matplotlib.axes.Axes:
    """What slam.plot() draws."""
    ax = plot_map(slam.map(), ax)
    return plot_trajectory(slam.trajectory(), ax, color="tab:blue", linewidth=1.0)
