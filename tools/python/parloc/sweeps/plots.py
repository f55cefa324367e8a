"""Pictures of what settings do, by matplotlib, as SVG in a page."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from typing import Any

from ..intervals import Interval
from .effects import Effect

# Okabe and Ito's, for colour-blind readers; markers differ too.
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#b5508c", "#e69f00", "#56b4e9", "#5b6570")
MARKERS = ("o", "s", "^", "D", "v", "P", "X")


def effect_picture(name: str, effects: dict[Any, Sequence[Effect]]) -> str | None:
    """Success and error over the values of a setting, a line per filter ({filter: effects}). None without matplotlib."""
    try:
        from matplotlib.figure import Figure
    except ImportError:
        return None
    figure = Figure(figsize=(9, 2.9), layout="constrained")
    left, right = figure.subplots(1, 2)
    for k, (filter_name, values) in enumerate(effects.items()):
        style = {"color": COLOURS[k % len(COLOURS)], "marker": MARKERS[k % len(MARKERS)], "label": filter_name or name}
        shift = (k - (len(effects) - 1) / 2) * 0.02  # so that intervals do not hide each other
        draw(left, [e.success for e in values], 100.0, shift, style)
        draw(right, [e.error_m for e in values], 1.0, shift, style)
    for axes, title in ((left, "success [%]"), (right, "error of what succeeded [m]")):
        label_axes(axes, name, title, next(iter(effects.values())))
    low, high = left.get_ylim()
    left.set_ylim(max(-2.0, min(low, high - 10.0)), min(102.0, high))
    if len(effects) > 1:
        left.legend(fontsize=8)
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None})
    svg = text.getvalue()
    return svg[svg.index("<svg") :]


def draw(axes: Any, intervals: Sequence[Interval], factor: float, shift: float, style: dict[str, Any]) -> None:
    places = range(len(intervals))
    means = [factor * i.mean for i in intervals]
    halves = [factor * (i.high - i.mean) if math.isfinite(i.high) else 0.0 for i in intervals]
    axes.errorbar([k + shift for k in places], means, yerr=halves, capsize=4, linewidth=1.4, markersize=5, **style)


def label_axes(axes: Any, name: str, title: str, values: Sequence[Effect]) -> None:
    """Values stand side by side: what is between two of them was not tried."""
    axes.set_xticks(range(len(values)), [e.label for e in values], fontsize=8, rotation=20 if len(values) > 4 else 0)
    axes.set_xlim(-0.4, len(values) - 0.6)
    axes.set_xlabel(name)
    axes.set_title(title, fontsize=10, loc="left")
    axes.grid(True, color="#d8dde3", linewidth=0.7)
    axes.spines[["top", "right"]].set_visible(False)
