"""The settings to tune, as a YAML file."""

from __future__ import annotations

import os
from typing import Any

from .. import _parloc
from ..errors import ConfigError
from .space import Choice, Range, Space

_KEYS = ("from", "to", "scale")


def read_space(path: str | os.PathLike) -> Space:
    """Reads settings by their names, each a list of values, or `{from: 0.02, to: 0.4, scale: log}`.

    Raises ConfigError that names file and line.
    """
    import yaml

    name = os.fspath(path)
    try:
        with open(name, encoding="utf-8") as file:
            root = yaml.compose(file, Loader=yaml.SafeLoader)
    except OSError as error:
        raise ConfigError(f"{name}: {error.strerror}") from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        mark = getattr(error, "problem_mark", None)
        raise ConfigError(f"{name}:{mark.line + 1 if mark else 1}: {getattr(error, 'problem', None) or 'no YAML'}") from None
    if not isinstance(root, yaml.MappingNode) or not root.value:
        raise ConfigError(f"{name}:1: expected settings, as in 'sensor.sigma_hit: {{from: 0.02, to: 0.4, scale: log}}'")
    names = _parloc.Config()
    space: Space = {}
    for key, node in root.value:
        where = f"{name}:{key.start_mark.line + 1}"
        setting = str(key.value)
        try:
            names[setting]
        except KeyError as unknown:
            raise ConfigError(f"{where}: {unknown.args[0]}") from None
        if setting in space:
            raise ConfigError(f"{where}: {setting} is there twice")
        space[setting] = _allowed(where, setting, yaml.SafeLoader("").construct_object(node, deep=True))
    return space


def _allowed(where: str, setting: str, given: Any) -> Range | Choice:
    if isinstance(given, list) and len(given) >= 2 and all(isinstance(v, str | int | float | bool) for v in given):
        return Choice(tuple(given))
    if not isinstance(given, dict) or not {"from", "to"} <= given.keys():
        raise ConfigError(f"{where}: {setting}: expected a list of values, or {{from: , to: , scale: log or linear}}")
    for key in given:
        if key not in _KEYS:
            raise ConfigError(f"{where}: {setting}: expected {', '.join(_KEYS)}, got {key}")
    for key in ("from", "to"):
        if isinstance(given[key], bool) or not isinstance(given[key], int | float):
            raise ConfigError(f"{where}: {setting}: expected a number as {key}, got {given[key]}")
    if given.get("scale", "linear") not in ("linear", "log"):
        raise ConfigError(f"{where}: {setting}: expected log or linear as scale, got {given['scale']}")
    return Range(float(given["from"]), float(given["to"]), given.get("scale") == "log")
