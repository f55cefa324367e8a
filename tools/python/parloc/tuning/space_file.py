"""The settings to tune, as a YAML file: as those of a sweep that draws its points."""

from __future__ import annotations

import os

from .. import _parloc
from ..errors import ConfigError
from ..sweeps.settings import range_of
from ..sweeps.yaml_places import read_yaml
from .space import Choice, Range, Space


def read_space(path: str | os.PathLike, base: _parloc.Config | None = None) -> Space:
    """Reads settings by their names, each a list of values, or `{from: 0.02, to: 0.4, scale: log}`; `base` has all others.

    Raises InputError for a file that cannot be read, ConfigError that names file and line.
    """
    root = read_yaml(os.fspath(path))
    if not isinstance(root.value, dict) or not root.value:
        raise ConfigError(
            f"{root.file}:{root.line}: expected settings, as in 'sensor.sigma_hit: {{from: 0.02, to: 0.4, scale: log}}'"
        )
    space: Space = {}
    for name, node in root.value.items():
        made = range_of(name, node, base if base is not None else _parloc.Config(), needs_steps=False)
        if len(made.values) == 1:
            raise node.wrong(f"{name}: expected two values at least, or a range")
        space[name] = Choice(made.values) if made.values else Range(made.low, made.high, made.is_log)
    return space
