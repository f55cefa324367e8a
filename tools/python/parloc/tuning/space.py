"""Which settings are tuned, and between what."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .. import _parloc
from ..errors import ConfigError


@dataclass(frozen=True)
class Range:
    """All numbers from `low` to `high`; whole ones for a setting that counts."""

    low: float
    high: float
    log: bool = False
    """Whether equal factors are equally likely to be tried, instead of equal steps."""


@dataclass(frozen=True)
class Choice:
    """One of these."""

    values: tuple


Space = dict[str, Range | Choice]
"""By a setting's name, as in `sensor.sigma_hit`."""

DEFAULT_SPACE: Space = {
    "motion.alpha1": Range(0.01, 1.0, log=True),
    "motion.alpha2": Range(0.005, 1.0, log=True),
    "motion.alpha3": Range(0.01, 1.0, log=True),
    "motion.alpha4": Range(0.005, 1.0, log=True),
    "motion.sigma_rot_per_s": Range(0.0005, 0.05, log=True),
    "motion.sigma_trans_per_s": Range(0.0005, 0.1, log=True),
    "sensor.sigma_hit": Range(0.02, 0.4, log=True),
    "sensor.z_rand": Range(0.02, 0.6, log=True),
    "sensor.effective_beams": Range(2.0, 60.0, log=True),
    "sensor.laser_likelihood_max_dist": Range(0.2, 3.0, log=True),
}
"""What differs from robot to robot: the noise of its wheels, of its LiDAR, and how much of what it sees the map has."""

_SHARES = ("sensor.z_short", "sensor.z_max", "sensor.z_rand")


def configured(base: _parloc.Config, values: dict[str, Any]) -> _parloc.Config:
    """`base` with these settings. Where shares of beams are tuned but z_hit is not, z_hit is what they leave.

    Raises ConfigError.
    """
    config = base.copy()
    if "sensor.model" in values:  # brings its defaults
        config["sensor.model"] = values["sensor.model"]
    for name, value in values.items():
        if name != "sensor.model":
            config[name] = value
    if any(name in values for name in _SHARES) and "sensor.z_hit" not in values:
        config["sensor.z_hit"] = 1.0 - sum(config[name] for name in _SHARES)
    return config


def check(space: Space, base: _parloc.Config) -> None:
    """Raises ConfigError for a setting that is none, that tuning cannot judge, or that cannot have what it may be given."""
    if not space:
        raise ConfigError("expected at least one setting to tune")
    for name, values in space.items():
        group = name.split(".")[0]
        if group in ("slam", "flow", "search", "log", "seed", "backend", "threads", "device"):
            raise ConfigError(f"{name}: drives do not tell whether it is good, so it cannot be tuned")
        ends = values.values if isinstance(values, Choice) else (values.low, values.high)
        if isinstance(values, Range) and not values.low < values.high:
            raise ConfigError(f"{name}: expected a smaller number, then a larger one, got {values.low:g} to {values.high:g}")
        if isinstance(values, Range) and values.log and values.low <= 0:
            raise ConfigError(f"{name}: expected a range above 0 for a logarithmic scale, got {values.low:g}")
        for value in ends:
            try:
                base.copy()[name] = _typed(value, base[name])
            except KeyError as unknown:
                raise ConfigError(str(unknown.args[0])) from None


def suggest(trial: Any, space: Space, base: _parloc.Config) -> dict[str, Any]:
    """What an Optuna trial shall try."""
    values: dict[str, Any] = {}
    for name, allowed in space.items():
        if isinstance(allowed, Choice):
            values[name] = trial.suggest_categorical(name, list(allowed.values))
        elif _counts(base[name]):
            values[name] = trial.suggest_int(name, int(allowed.low), int(allowed.high), log=allowed.log)
        else:
            values[name] = trial.suggest_float(name, allowed.low, allowed.high, log=allowed.log)
    return values


def base_values(space: Space, base: _parloc.Config) -> dict[str, Any]:
    """Those of `base`, moved to the nearest end of a range that they lie outside of; choices it does not have: the first."""
    values = {}
    for name, allowed in space.items():
        value = base[name]
        if isinstance(allowed, Choice):
            values[name] = value if value in allowed.values else allowed.values[0]
        else:
            values[name] = _typed(min(allowed.high, max(allowed.low, value)), value)
    return values


def _counts(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _typed(value: Any, like: Any) -> Any:
    return int(value) if _counts(like) and float(value).is_integer() else value
