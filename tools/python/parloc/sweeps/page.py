"""The page of a sweep: what was tried, what each setting does, which points are best, what failed. One file, no network."""

from __future__ import annotations

import html
import math
from collections.abc import Iterable, Sequence
from typing import Any

from ..intervals import Interval
from .compute import FailedPart
from .effects import Effect, PointScore, Scores
from .folder import SweepFolder
from .plots import effect_picture
from .table import Table

MOST_POINTS_SHOWN = 20

_STYLE = """
:root{color-scheme:light dark;--page:#fff;--text:#1b1f24;--soft:#5b6570;--rule:#d8dde3;--panel:#f5f7f9}
@media(prefers-color-scheme:dark){:root{--page:#14171b;--text:#e6e9ec;--soft:#9aa5b1;--rule:#333b44;--panel:#1d2228}
svg{background:#fff}}
body{margin:0 auto;max-width:64rem;padding:1rem;background:var(--page);color:var(--text);font:16px/1.45 system-ui,sans-serif}
h1{font-size:1.5rem;margin:.2rem 0}h2{font-size:1.15rem;margin:2rem 0 .4rem}h3{font-size:1rem;margin:1.4rem 0 .2rem}
p{margin:.4rem 0}.note{color:var(--soft);font-size:.9rem}.warning{border-left:.3rem solid #d55e00;padding:.4rem .7rem;
background:var(--panel)}table{border-collapse:collapse;margin:.4rem 0}th,td{text-align:left;vertical-align:top;
padding:.2rem 1rem .2rem 0;border-bottom:1px solid var(--rule);font-weight:400;font-variant-numeric:tabular-nums}
th{color:var(--soft)}td .note{white-space:nowrap}
.wide{overflow-x:auto}svg{width:100%;height:auto}pre{padding:.5rem .7rem;background:var(--panel);
font-size:.85rem;overflow-x:auto}tr.good td{background:color-mix(in srgb,#009e73 13%,transparent)}
"""


def page_of(folder: SweepFolder, table: Table, failed: Sequence[FailedPart], missing: int, command: str, machine: str) -> str:
    """`missing`: runs that are not in the table."""
    plan = folder.plan
    name = plan.file.rsplit("/", 1)[-1]
    scores = Scores(table)
    points = scores.points()
    sections = [
        f"<h1>Sweep: {escaped(name)}</h1>",
        f"<p>{summary(folder, table, scores)}</p>",
        warning(failed, missing, len(plan.runs)),
        answer(points, plan),
        effect_sections(scores, plan),
        best_points(points, plan),
        per_source(table) if len(plan.sources) > 1 else "",
        what_was_tried(plan),
        f"<h2>How it was made</h2><pre>{escaped(command)}</pre><p class='note'>{escaped(machine)}</p>"
        "<p class='note'>All trials are in <b>table.csv</b> beside this page, a row each. The same seeds give the same numbers "
        "on every machine.</p>",
    ]
    return ("<!doctype html><html lang='en'><head><meta charset='utf-8'>"
            f"<meta name='viewport' content='width=device-width'><title>{escaped(name)}</title>"
            f"<style>{_STYLE}</style></head><body>{''.join(sections)}</body></html>\n")


def escaped(text: Any) -> str:
    return html.escape(str(text))


def html_table(header: Iterable[str], rows: Iterable[tuple[str, Sequence[str]]]) -> str:
    """rows: (class, cells); cells are HTML."""
    head = "".join(f"<th>{cell}</th>" for cell in header)
    body = "".join(f"<tr class='{kind}'>{''.join(f'<td>{cell}</td>' for cell in cells)}</tr>" for kind, cells in rows)
    return f"<div class='wide'><table><tr>{head}</tr>{body}</table></div>"


def percent(i: Interval) -> str:
    return "-" if not i.count else f"{100 * i.mean:.1f} %" + span(100 * i.low, 100 * i.high, "{:.1f}")


def metres(i: Interval) -> str:
    return "-" if not i.count else f"{i.mean:.4f} m" + span(i.low, i.high, "{:.4f}")


def span(low: float, high: float, form: str) -> str:
    """Of one trial there is no interval."""
    if not math.isfinite(low):
        return ""
    return f" <span class='note'>({form.format(low)} to {form.format(high)})</span>"


def counted(count: int, word: str) -> str:
    return f"{count:,} {word}{'' if count == 1 else 's'}"


def summary(folder: SweepFolder, table: Table, scores: Scores) -> str:
    plan = folder.plan
    parts = [counted(len(plan.points), "point") + (f" over {counted(len(plan.ranges), 'setting')}" if plan.ranges else ""),
             f"on {', '.join(escaped(s.name) for s in plan.sources)}"]
    if plan.filters:
        parts.append(f"with {', '.join(map(escaped, plan.filters))}")
    each = "each point and filter" if plan.filters else "each point"
    return f"{' '.join(parts)}: {len(table):,} trials, {len(scores.trials):,} for {each}. " + (
        "A trial succeeds if it is not lost at its end; its error is the RMSE of its position." if plan.filters else
        "A trial succeeds if it is right by the limit and stays it; its error is the RMSE of its position since then.")


def warning(failed: Sequence[FailedPart], missing: int, runs: int) -> str:
    if not missing:
        return ""
    items = "".join(f"<li>{escaped(f)}</li>" for f in failed[:20])
    more = f"<li>and {len(failed) - 20} more</li>" if len(failed) > 20 else ""
    return (f"<div class='warning'><p>{missing} of {counted(runs, 'run')} are not in these results. The same command again "
            f"goes on with them.</p><ul>{items}{more}</ul></div>")


def answer(points: Sequence[PointScore], plan: Any) -> str:
    """The first thing that a reader wants to know."""
    if len(points) < 2:
        return ""
    best = points[0]
    alike = sum(p.as_good for p in points) - 1
    rest = len(points) - 1 - alike
    return (f"<h2>In short</h2><p>Best: point {best.point}{of_filter(best.filter)}, {escaped(values_text(plan, best.point))}. "
            f"Success {percent(best.success)}, error {metres(best.error_m)}.</p><p>Of {counted(alike + rest, 'other')}, "
            f"{alike} cannot be told from it by success and error on the same trials. The best of many looks better than "
            "it is: before you believe it, try it with seeds that are not in here.</p>")


def of_filter(name: str | None) -> str:
    return f" with {escaped(name)}" if name else ""


def values_text(plan: Any, point: int) -> str:
    return ", ".join(f"{name} = {value}" for name, value in plan.points[point - 1].items()) or "the configuration as it is"


def effect_sections(scores: Scores, plan: Any) -> str:
    if not plan.ranges or not len(scores.rows):
        return ""
    text = ["<h2>What each setting does</h2><p class='note'>Means over all values of the other settings. The bars are 95 % "
            "intervals of the difference to the mean over all values, on the same trials (source and seed): where they do not "
            "overlap, the setting matters. Errors are of trials that succeeded at all values.</p>"]
    for r in plan.ranges:
        values = [point[r.name] for point in plan.points]
        effects = {name: scores.effects(values, name) for name in scores.filters}
        if max(map(len, effects.values())) < 2:
            continue
        picture = effect_picture(r.name, effects)
        text.append(f"<h3>{escaped(r.name)}</h3>{picture or effect_table(effects)}")
    return "".join(text)


def effect_table(effects: dict[Any, Sequence[Effect]]) -> str:
    """Instead of a picture, where there is no matplotlib."""
    rows = [("", (escaped(name or ""), escaped(e.label), percent(e.success), metres(e.error_m)))
            for name, values in effects.items() for e in values]
    return html_table(("filter", "value", "success", "error"), rows)


def best_points(points: Sequence[PointScore], plan: Any) -> str:
    if not points:
        return ""
    names = [r.name for r in plan.ranges]
    header = ["point", *(["filter"] if plan.filters else []), *map(escaped, names), "success", "error", "success - first",
              "error - first"]
    rows = []
    for p in points[:MOST_POINTS_SHOWN]:
        values = plan.points[p.point - 1]
        cells = [str(p.point), *([escaped(p.filter)] if plan.filters else []), *(escaped(values[n]) for n in names),
                 percent(p.success), metres(p.error_m),
                 percent(p.behind) if p.behind else "", metres(p.behind_error_m) if p.behind_error_m else ""]
        rows.append(("good" if p.as_good else "", cells))
    shown = "" if len(points) <= MOST_POINTS_SHOWN else f" The first {MOST_POINTS_SHOWN} of {len(points)}."
    return (f"<h2>The best points</h2>{html_table(header, rows)}<p class='note'>By success, then by error.{shown} Green: "
            "cannot be told from the first. Success has Wilson's 95 % interval, all else Student's. Differences to the first "
            "are on the same trials, and those of errors on trials in which both succeeded.</p>")


def per_source(table: Table) -> str:
    columns = table.columns
    rows = []
    for source in dict.fromkeys(columns["source"]):
        hits = [ok for name, ok in zip(columns["source"], columns["success"], strict=True) if name == source]
        rows.append(("", (escaped(source), f"{100 * sum(hits) / len(hits):.1f} %", f"{len(hits):,}")))
    return "<h2>By source</h2>" + html_table(("source", "success over all points", "trials"), rows)


def what_was_tried(plan: Any) -> str:
    rows = []
    for r in plan.ranges:
        drawn = f"{r.low:g} to {r.high:g}, drawn{' on a log scale' if r.is_log else ''}"
        tried = ", ".join(map(str, r.values)) or drawn
        rows.append(("", (escaped(r.name), escaped(tried))))
    return (f"<h2>What was tried</h2>{html_table(('setting', 'values'), rows) if rows else ''}"
            f"<p class='note'>{escaped(plan.file)}:</p><pre>{escaped(plan.text)}</pre>")
