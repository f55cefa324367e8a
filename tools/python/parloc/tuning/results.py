"""What a tuning leaves in its folder: numbers, settings that `parloc run` takes, and a page."""

from __future__ import annotations

import json
import math
import os
from dataclasses import asdict
from typing import Any

from .. import _parloc
from ..errors import OutputError
from ..intervals import Interval
from .page import page
from .tuner import Tuning, doubt, now, summary
from .verdict import Comparison


def write_results(tuning: Tuning, command: str = "") -> list[str]:
    """Writes tune.json, report.html, and the settings found: as tuned.yaml if they are better, else as not_better.yaml.

    Returns the files. A file of an earlier run that says otherwise is removed. Raises OutputError.
    """
    files = {
        "tune.json": json.dumps(record(tuning, command), indent=1, allow_nan=False) + "\n",
        "report.html": page(tuning, command),
        "tuned.yaml": None,
        "not_better.yaml": None,
    }
    if tuning.found:
        files["tuned.yaml" if tuning.better else "not_better.yaml"] = settings_text(tuning)
    written = []
    for name, text in files.items():
        path = os.path.join(tuning.out, name)
        try:
            if text is None:
                if os.path.exists(path):
                    os.remove(path)
                continue
            draft = f"{path}.{os.getpid()}"
            with open(draft, "w", encoding="utf-8") as file:
                file.write(text)
            os.replace(draft, path)
        except OSError as error:
            raise OutputError(f"{path}: {error.strerror}") from None
        written.append(path)
    return written


def settings_text(tuning: Tuning) -> str:
    """The settings found, over those that were given, as YAML."""
    lines = [f"# {summary(tuning)}", f"# Found by parloc tune, {tuning.tried} tries, {now()}."]
    return "\n".join(lines) + "\n" + str(tuning.found_config)


def record(tuning: Tuning, command: str) -> dict[str, Any]:
    """All numbers, as JSON has them: null for what is not known."""
    old = tuning.base
    return {
        "verdict": summary(tuning),
        "doubt": doubt(tuning),
        "better": tuning.better,
        "command": command,
        "date": now(),
        "version": _parloc.version,
        "tried": tuning.tried,
        "settings": {name: {"old": old[name], "found": tuning.found_config[name]} for name in tuning.found},
        "fit": _comparison(tuning.fit),
        "test": _comparison(tuning.test),
    }


def _comparison(c: Comparison) -> dict[str, Any]:
    drives = list(dict.fromkeys(name for name, _ in c.pieces))
    return {
        "gain_m": _interval(c.gain),
        "gain_m_by_drive": {name: _interval(c.gain_of(name)) for name in drives},
        "pieces": [
            {"drive": drive, "begin_s": begin_s, "old": _known(asdict(old)), "found": _known(asdict(found))}
            for (drive, begin_s), old, found in zip(c.pieces, c.base, c.tuned, strict=True)
        ],
    }


def _interval(i: Interval) -> dict[str, Any]:
    return _known({"mean": i.mean, "low": i.low, "high": i.high, "pieces": i.count})


def _known(values: dict[str, Any]) -> dict[str, Any]:
    return {k: None if isinstance(v, float) and not math.isfinite(v) else v for k, v in values.items()}
