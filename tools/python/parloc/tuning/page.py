"""The page of a tuning: what came out, where, and what was tried. By matplotlib, without anything from elsewhere."""

from __future__ import annotations

import html
import io
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ..intervals import Interval
from .score import CAP_M
from .tuner import Tuning, doubt, now, summary
from .verdict import Comparison

if TYPE_CHECKING:
    from matplotlib.figure import Figure

OLD, FOUND, SOFT = "#d55e00", "#0072b2", "#9aa5b1"  # Okabe and Ito's, as on the program's pages

_STYLE = """
body{margin:0 auto;max-width:62rem;padding:1rem;font:16px/1.45 system-ui,sans-serif;color:#1b1f24;background:#fff}
h1{font-size:1.5rem;margin:.2rem 0}
h2{font-size:1.15rem;margin:2rem 0 .4rem}
.note{color:#5b6570;font-size:.9rem}
code{display:block;padding:.5rem .7rem;background:#f5f7f9;border-radius:.4rem;font-size:.85rem;overflow-wrap:anywhere}
.verdict{font-size:1.1rem;font-weight:600;border-left:.3rem solid #0072b2;padding:.4rem .8rem;background:#f5f7f9}
.doubt{border-color:#d55e00}
table{border-collapse:collapse;margin:.6rem 0}
th,td{text-align:right;padding:.25rem 0 .25rem 1.2rem;border-bottom:1px solid #d8dde3;font-weight:400}
th{color:#5b6570}
td{font-variant-numeric:tabular-nums}
td:first-child,th:first-child{text-align:left;padding-left:0}
svg{width:100%;height:auto}
"""

_MEASURES = {
    "error_m": ("error of the pose, capped [mm]", 1000.0, 1),
    "position_m": ("distance to the truth [mm]", 1000.0, 1),
    "heading_rad": ("error of the heading [degrees]", 180 / math.pi, 2),
    "wrong": (f"scans wrong by {CAP_M:g} m or more [%]", 100.0, 2),
    "sure_but_wrong": ("... that said tracking [%]", 100.0, 2),
    "lost": ("scans that said lost [%]", 100.0, 2),
    "nees": ("NEES, median of the pieces; 3 is honest", 1.0, 2),
}


def page(tuning: Tuning, command: str = "") -> str:
    """A page that stands alone (HTML). Needs matplotlib."""
    parts = [
        "<!DOCTYPE html>\n<html lang='en'><head><meta charset='utf-8'><meta name='viewport' "
        f"content='width=device-width,initial-scale=1'><title>parloc tune</title><style>{_STYLE}</style></head><body>",
        f"<h1>Settings from drives</h1><p class='note'>{now()}</p>",
        f"<code>{html.escape(command)}</code>" if command else "",
        f"<p class='verdict'>{html.escape(summary(tuning))}</p>",
        f"<p class='verdict doubt'>{html.escape(doubt(tuning))}</p>" if doubt(tuning) else "",
        "<p>Settings were fitted to the first part of each log and judged on the later part, which was not looked at "
        "before, with other seeds. A piece is a stretch of a log in which the localizer starts anew. The error is that of "
        f"the pose, heading included (1 rad counts as 1 m), at most {CAP_M:g} m, averaged over the scans of a piece. "
        "Intervals are of 95 %, over pieces.</p>",
        "<h2>Pieces kept back</h2>",
        _svg(_pieces_figure(tuning.test)),
        _measures(tuning),
        _gains(tuning),
        "<h2>What changed</h2>",
        _settings(tuning),
        "<h2>What was tried</h2>",
        "<p class='note'>Each dot is one set of settings; those given up early are not shown. Where the dots do not rise or "
        "fall with a setting, it does not matter on these drives. Dashed: old; solid: found.</p>",
        _svg(_tries_figure(tuning)),
        "</body></html>\n",
    ]
    return "\n".join(parts)


def _table(rows: list[list[str]]) -> str:
    head, *body = rows
    cells = ["<tr>" + "".join(f"<th>{html.escape(c)}</th>" for c in head) + "</tr>"]
    cells += ["<tr>" + "".join(f"<td>{html.escape(c)}</td>" for c in row) + "</tr>" for row in body]
    return "<table>" + "".join(cells) + "</table>"


def _measures(tuning: Tuning) -> str:
    rows = [["", "old, fitted to", "found, fitted to", "old, kept back", "found, kept back"]]
    for name, (title, factor, decimals) in _MEASURES.items():
        middle = np.nanmedian if name == "nees" else np.mean
        sides = [tuning.fit.base, tuning.fit.tuned, tuning.test.base, tuning.test.tuned]
        values = [np.array([getattr(s, name) for s in side]) for side in sides]
        rows.append([title, *("-" if np.isnan(v).all() else f"{middle(v) * factor:.{decimals}f}" for v in values)])
    return _table(rows)


def _gains(tuning: Tuning) -> str:
    drives = list(dict.fromkeys(name for name, _ in tuning.test.pieces))
    rows = [["less error, mean [95 %]", "fitted to", "kept back"]]
    rows += [[d, _told(tuning.fit.gain_of(d)), _told(tuning.test.gain_of(d))] for d in drives]
    if len(drives) > 1:
        rows.append(["all", _told(tuning.fit.gain), _told(tuning.test.gain)])
    return _table(rows)


def _told(i: Interval) -> str:
    return f"{i.mean * 1000:+.1f} mm [{i.low * 1000:+.1f}, {i.high * 1000:+.1f}], {i.count} pieces"


def _settings(tuning: Tuning) -> str:
    if not tuning.found:
        return "<p>Nothing: the old settings were the best that were tried.</p>"
    found = tuning.found_config
    return _table([["setting", "old", "found"], *([n, _value(tuning.base[n]), _value(found[n])] for n in tuning.found)])


def _value(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _svg(figure: Figure) -> str:
    import matplotlib.pyplot as plt

    text = io.StringIO()
    figure.savefig(text, format="svg", bbox_inches="tight", metadata={"Date": None})
    plt.close(figure)
    return text.getvalue()[text.getvalue().index("<svg") :]


def _pieces_figure(c: Comparison) -> Figure:
    """Old and found, side by side for every piece."""
    import matplotlib.pyplot as plt

    count = len(c.pieces)
    figure, ax = plt.subplots(figsize=(10, 3.2))
    at = np.arange(count)
    old, found = ([s.error_m * 1000 for s in side] for side in (c.base, c.tuned))
    ax.vlines(at, old, found, color=SOFT, linewidth=1.5, zorder=1)
    ax.scatter(at, old, color=OLD, marker="o", label="old", zorder=2)
    ax.scatter(at, found, color=FOUND, marker="s", label="found", zorder=3)
    ax.set_xticks(at, _labels(c))
    ax.tick_params(axis="x", labelsize=8, rotation=90 if count > 12 else 0)
    ax.set_xlabel("pieces in the order of the log: seconds after the first one kept back")
    ax.set_ylabel("error [mm]")
    ax.set_ylim(bottom=0)
    ax.grid(axis="y", color="#e5e8ec")
    ax.legend(loc="upper left", bbox_to_anchor=(1, 1), frameon=False)
    return figure


def _labels(c: Comparison) -> list[str]:
    """When each piece begins, and the drive above where there are several."""
    first: dict[str, float] = {}
    several = len({name for name, _ in c.pieces}) > 1
    return [f"{name}  " * several + f"{begin_s - first.setdefault(name, begin_s):.0f} s" for name, begin_s in c.pieces]


def _tries_figure(tuning: Tuning) -> Figure:
    """Error over the number of the try, and over every setting."""
    import matplotlib.pyplot as plt

    tries = [t for t in tuning.study.get_trials(deepcopy=False) if t.state.name == "COMPLETE"]
    errors = np.array([t.value * 1000 for t in tries])
    names = list(tuning.space)
    columns = 4
    rows = -(-(len(names) + 1) // columns)
    figure, axes = plt.subplots(rows, columns, figsize=(12, 2.6 * rows), sharey=True, squeeze=False)
    top = float(np.quantile(errors, 0.9)) * 1.05 if len(errors) else 1.0
    for ax, name in zip(axes.flat, ["tries, in order", *names], strict=False):
        xs = [t.number for t in tries] if name == "tries, in order" else [t.params[name] for t in tries]
        ax.scatter([str(x) if isinstance(x, str | bool) else x for x in xs], np.minimum(errors, top), s=10, color=SOFT)
        if name == "tries, in order":
            ax.step(xs, np.minimum.accumulate(errors), where="post", color=FOUND)
        else:
            _marked(ax, tuning, name)
        ax.set_title(name, fontsize=9)
        ax.grid(color="#eef0f3")
    for ax in axes.flat[len(names) + 1 :]:
        ax.axis("off")
    for ax in axes[:, 0]:
        ax.set_ylabel("error [mm]")
    axes[0, 0].set_ylim(bottom=max(0.0, errors.min() * 0.95 if len(errors) else 0.0), top=top * 1.02)
    figure.tight_layout()
    return figure


def _marked(ax: Any, tuning: Tuning, name: str) -> None:
    """Where the old value lies, and the one found."""
    allowed = tuning.space[name]
    if getattr(allowed, "log", False):
        ax.set_xscale("log")
    for value, colour, style in ((tuning.base[name], OLD, "--"), (tuning.found.get(name), FOUND, "-")):
        if value is not None and not isinstance(value, str | bool):
            ax.axvline(value, color=colour, linestyle=style, linewidth=1.2)
