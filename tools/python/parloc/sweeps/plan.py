"""A sweep as its file says it: on what, how often, with which filters and over which settings."""

from __future__ import annotations

import math
import shlex
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from .._parloc import Config, read_config
from ..errors import ConfigError
from .settings import MOST_POINTS, Range, config_of, points_of, range_of
from .yaml_places import Node, read_yaml

# Keys that are options of the command as they are: {key: option}.
EVALUATE_OPTIONS = {"task": "--task", "limit": "--limit", "range": "--range", "fov": "--fov"}
COMPARE_OPTIONS = {"sigma": "--sigma", "start_error": "--start-error", "kidnap": "--kidnap", "kappa": "--kappa",
                   "people": "--people"}
SIMULATED_ONLY = ("range", "fov", "kappa", "people")
KEYS = ("scenarios", "logs", "filters", "trials", "seed", "duration", "config", "settings", "draw", "draw_seed",
        *EVALUATE_OPTIONS, *COMPARE_OPTIONS)
MOST_TRIALS = 10_000_000


@dataclass(frozen=True)
class Source:
    """A scenario, or a log with map and truth; `words` name it in a command line."""

    name: str
    words: tuple[str, ...]
    trials: int
    recorded: bool = False


@dataclass(frozen=True)
class Run:
    """One command: a point of the settings, on one source. Its results are those of all its parts."""

    number: int  # from 1 on
    point: int  # from 1 on
    source: Source
    words: tuple[str, ...]  # without --shard, --out and --jobs


@dataclass(frozen=True)
class Plan:
    """What read_plan() gives. `points` are {setting: value}, `configs` the whole configuration at each of them."""

    file: str
    text: str
    command: str  # evaluate, or compare if there are filters
    sources: tuple[Source, ...]
    filters: tuple[str, ...]
    ranges: tuple[Range, ...]
    points: tuple[dict[str, Any], ...]
    configs: tuple[Config, ...] = field(repr=False)
    runs: tuple[Run, ...] = field(repr=False)

    @property
    def trials(self) -> int:
        """Of all runs together; `compare` does each with every filter."""
        return sum(run.source.trials for run in self.runs)


def read_plan(path: str | Path) -> Plan:
    """Raises InputError or ConfigError with file and line; nothing has been run by then."""
    root = read_yaml(path)
    keys = root.group("a sweep", KEYS)
    compares = "filters" in keys
    refuse_mixed(keys, compares)
    sources = sources_of(root, keys, compares)
    base = base_config(keys.get("config"))
    draw = keys["draw"].whole("draw", 1, MOST_POINTS) if "draw" in keys else 0
    if "draw_seed" in keys and not draw:
        raise keys["draw_seed"].wrong("draw_seed: expected the key 'draw' as well")
    draw_seed = keys["draw_seed"].whole("draw_seed", 0, 2**63) if draw and "draw_seed" in keys else 1
    ranges = ranges_of(keys.get("settings"), base, draw)
    if draw and not ranges:
        raise keys["draw"].wrong("draw: expected settings to draw")
    count = draw or math.prod(len(r.values) for r in ranges)
    if count > MOST_POINTS:
        raise keys["settings"].wrong(f"settings: expected at most {MOST_POINTS} points, as with draw: N, found {count}")
    points = tuple(points_of(ranges, draw, draw_seed))
    configs = tuple(config_of(base, point, keys.get("settings", root)) for point in points)
    filters = filters_of(keys["filters"]) if compares else ()
    options = options_of(keys, compares, filters)
    runs = [Run(0, k + 1, source, command_words(compares, source, k + 1, options)) for k in range(count) for source in sources]
    numbered = tuple(Run(k, run.point, run.source, run.words) for k, run in enumerate(runs, 1))
    return Plan(str(path), Path(path).read_text(encoding="utf-8"), "compare" if compares else "evaluate", sources,
                filters, tuple(ranges), points, configs, numbered)


def refuse_mixed(keys: dict[str, Node], compares: bool) -> None:
    for key in EVALUATE_OPTIONS if compares else COMPARE_OPTIONS:
        if key in keys:
            other = "trials without filters" if compares else "filters, which are not named here"
            raise ConfigError(f"{keys[key].file}:{keys[key].key_line}: the key '{key}' belongs to {other}")
    if "logs" in keys:
        for key in SIMULATED_ONLY:
            if key in keys:
                raise ConfigError(f"{keys[key].file}:{keys[key].key_line}: {key} is simulated: expected scenarios alone")
        if "task" in keys and keys["task"].value == "kidnap":
            raise keys["task"].wrong("task: expected global or track, as kidnappings are simulated")


def path_in(node: Node, text: str) -> str:
    """Of a file, as seen from the folder of the sweep's file. Raises ConfigError if there is none."""
    path = (Path(node.file).parent / text).resolve()
    if not path.exists():
        raise ConfigError(f"{node.file}:{node.line}: expected a file, found no {path}")
    return str(path)


def sources_of(root: Node, keys: dict[str, Node], compares: bool) -> tuple[Source, ...]:
    trials = keys["trials"].whole("trials", 1, MOST_TRIALS) if "trials" in keys else None
    sources = []
    if "scenarios" in keys:
        node = keys["scenarios"]
        for text in node.texts("scenarios: expected a file, or a list of files"):
            words = ("--scenario", path_in(node, text))
            sources.append(Source(Path(text).stem.removesuffix("_scenario"), words, trials or (5 if compares else 100)))
    if "logs" in keys:
        node = keys["logs"]
        for item in node.value if isinstance(node.value, list) else [node]:
            sources.append(log_source(item, trials, compares))
    if not sources:
        raise ConfigError(f"{root.file}:{root.line}: expected scenarios or logs: what the trials are of")
    names = [source.name for source in sources]
    if len(set(names)) < len(names):
        sources = [Source(f"{s.name}_{k}", s.words, s.trials, s.recorded) for k, s in enumerate(sources, 1)]
    return tuple(sources)


def log_source(node: Node, trials: int | None, compares: bool) -> Source:
    """{log, map, truth, starts}."""
    keys = ("log", "map", "truth") if compares else ("log", "map", "truth", "starts")
    group = node.group("logs", keys, ("log", "map", "truth"))
    words: list[str] = []
    for key in ("log", "map", "truth"):
        if not isinstance(group[key].value, str):
            raise group[key].wrong(f"{key}: expected a file")
        words += [f"--{key}", path_in(group[key], group[key].value)]
    count = group["starts"].whole("starts", 1, MOST_TRIALS) if "starts" in group else trials or (5 if compares else 20)
    if not compares:
        words += ["--starts", str(count)]
    return Source(Path(group["log"].value).name.split(".")[0], tuple(words), count, True)


def filters_of(node: Node) -> tuple[str, ...]:
    """KIND[@PARTICLES][=CONFIG.yaml] each; of a file as of all others."""
    named = []
    for text in node.texts("filters: expected a list such as mcl,ekf"):
        for word in text.split(","):
            kind, mark, file = word.strip().partition("=")
            named.append(kind + mark + (path_in(node, file) if mark else ""))
    return tuple(named)


def base_config(node: Node | None) -> Config:
    if node is None:
        return Config()
    if not isinstance(node.value, str):
        raise node.wrong("config: expected a file")
    return read_config(path_in(node, node.value))


def ranges_of(node: Node | None, base: Config, draw: int) -> list[Range]:
    if node is None:
        return []
    if not isinstance(node.value, dict):
        raise node.wrong("settings: expected a group of names, as in parloc config, with values")
    return [range_of(name, item, base, not draw) for name, item in node.value.items()]


def options_of(keys: dict[str, Node], compares: bool, filters: tuple[str, ...]) -> list[str]:
    """What all runs have in common."""
    words: list[str] = []
    known = COMPARE_OPTIONS if compares else EVALUATE_OPTIONS
    for key, option in {"duration": "--duration", **known}.items():
        if key not in keys:
            continue
        value = keys[key].value
        if value is None or isinstance(value, (list, dict, bool)):
            raise keys[key].wrong(f"{key}: expected a value, as {option} has it")
        words += [option, str(value)]
    if "task" in keys and keys["task"].value not in ("global", "kidnap", "track"):
        raise keys["task"].wrong("task: expected global, kidnap or track")
    if "seed" in keys:
        words += ["--seed", str(keys["seed"].whole("seed", 0, 10**9))]
    return words + (["--filters", ",".join(filters)] if compares else [])


def command_words(compares: bool, source: Source, point: int, options: list[str]) -> tuple[str, ...]:
    count = ["--seeds" if compares else "--trials", str(source.trials)]
    if source.recorded and not compares:
        count = []  # as many as there are starts
        options = without(options, "--seed")
    return ("compare" if compares else "evaluate", *source.words, *count, *options, "--config", config_name(point))


def without(words: list[str], option: str) -> list[str]:
    """Of options with one value each. The seed of a recorded trial is its start, of which all are taken."""
    pairs = zip(words[::2], words[1::2], strict=True)
    return [word for pair in pairs if pair[0] != option for word in pair]


def config_name(point: int) -> str:
    """Of the configuration at a point, within the sweep's folder."""
    return f"configs/{point:04d}.yaml"


def shell_line(words: tuple[str, ...]) -> str:
    """As one types it."""
    return " ".join(map(shlex.quote, words))


