"""The settings of a sweep: their values, and the points that these make together."""

from __future__ import annotations

import itertools
import math
import random
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from .._parloc import Config
from ..errors import ConfigError
from .yaml_places import Node, edit_distance

MOST_POINTS = 100_000


@dataclass(frozen=True)
class Range:
    """The values of one setting: a list of them, or all between two."""

    name: str  # dotted, as in `parloc config`
    node: Node = field(compare=False)
    values: tuple[Any, ...] = ()
    low: float = 0.0
    high: float = 0.0
    is_log: bool = False
    is_whole: bool = False

    def at(self, share: float) -> float | int:
        """The value at that share of the way from low to high."""
        if self.is_log:
            value = math.exp(math.log(self.low) + share * (math.log(self.high) - math.log(self.low)))
        else:
            value = self.low + share * (self.high - self.low)
        return round(value) if self.is_whole else float(f"{value:.6g}")  # short to read, and the same everywhere

    def drawn(self, random_numbers: random.Random) -> Any:
        """A value by chance, each as likely as any other."""
        share = random_numbers.random()
        return self.values[int(share * len(self.values))] if self.values else self.at(share)


def range_of(name: str, node: Node, base: Config, needs_steps: bool) -> Range:
    """Every value is tried in the configuration: what that refuses is refused here, with its line."""
    if name not in base.names():
        nearest = min(base.names(), key=lambda known: edit_distance(name[:100], known))
        raise ConfigError(f"{node.file}:{node.key_line}: there is no setting '{name}'; the nearest is '{nearest}'")
    if isinstance(node.value, dict):
        made = range_between(name, node, isinstance(base[name], int) and not isinstance(base[name], bool), needs_steps)
        if not made.values:
            for value in (made.low, made.high):
                checked(base, name, round(value) if made.is_whole else value, node)
            return made
        items = [(value, node) for value in made.values]
    else:
        nodes = node.value if isinstance(node.value, list) else [node]
        if not nodes:
            raise node.wrong(f"{name}: expected a list of values, or from, to and steps")
        items = [(plain(item), item) for item in nodes]
        made = Range(name, node)
    values = [checked(base, name, value, item) for value, item in items]
    if len(set(map(repr, values))) < len(values) and isinstance(node.value, list):
        raise node.wrong(f"{name}: expected each value once")
    return Range(name, node, tuple(dict.fromkeys(values)), made.low, made.high, made.is_log, made.is_whole)


def plain(node: Node) -> Any:
    """A value, or a list of values as some settings have it."""
    return [plain(item) for item in node.value] if isinstance(node.value, list) else node.value


def checked(base: Config, name: str, value: Any, node: Node) -> Any:
    """The value as the configuration has it."""
    config = base.copy()
    try:
        config[name] = value
    except (ConfigError, TypeError, ValueError) as error:
        raise ConfigError(f"{node.file}:{node.line}: {error}") from None
    return config[name]


def range_between(name: str, node: Node, is_whole: bool, needs_steps: bool) -> Range:
    """{from, to, steps, scale}."""
    group = node.group(name, ("from", "to", "steps", "scale"), ("from", "to"))
    low, high = (number_of(name, group[key]) for key in ("from", "to"))
    if low >= high:
        raise group["to"].wrong(f"{name}: expected more than from, {low:g}")
    scale = group.get("scale")
    if scale and scale.value not in ("linear", "log"):
        raise scale.wrong(f"{name}: scale: expected linear or log")
    made = Range(name, node, (), low, high, bool(scale and scale.value == "log"), is_whole)
    if made.is_log and low <= 0:
        raise group["from"].wrong(f"{name}: expected more than 0, as the scale is log")
    if not needs_steps:
        if "steps" in group:
            raise ConfigError(f"{node.file}:{group['steps'].key_line}: {name}: steps make a grid, and points are drawn here: "
                              "expected a list of values, or none")
        return made
    if "steps" not in group:
        raise ConfigError(f"{node.file}:{node.line}: {name}: expected the key 'steps' as well, as all settings make a grid")
    steps = group["steps"].whole(f"{name}: steps", 2, 1000)
    return Range(name, node, tuple(made.at(k / (steps - 1)) for k in range(steps)), low, high, made.is_log, is_whole)


def number_of(name: str, node: Node) -> float:
    if not isinstance(node.value, (int, float)) or isinstance(node.value, bool) or not math.isfinite(node.value):
        raise node.wrong(f"{name}: expected a number")
    return float(node.value)


def points_of(ranges: list[Range], draw: int, draw_seed: int) -> Iterator[dict[str, Any]]:
    """All combinations, the last setting changing first; or `draw` of them by chance, the same on every machine."""
    if not draw:
        for values in itertools.product(*(r.values for r in ranges)):
            yield dict(zip((r.name for r in ranges), values, strict=True))
        return
    random_numbers = random.Random(draw_seed)
    for _ in range(draw):
        yield {r.name: r.drawn(random_numbers) for r in ranges}


def config_of(base: Config, point: dict[str, Any], node: Node) -> Config:
    """The configuration at a point. Raises ConfigError for values that contradict each other."""
    config = base.copy()
    # A model brings its defaults with it, so it comes before its own settings.
    for name, value in sorted(point.items(), key=lambda item: not isinstance(item[1], str)):
        config[name] = value
    try:
        config.validate()
    except ConfigError as error:
        told = ", ".join(f"{name}={value}" for name, value in point.items())
        raise ConfigError(f"{node.file}:{node.key_line or node.line}: at {told}: {error}") from None
    return config
