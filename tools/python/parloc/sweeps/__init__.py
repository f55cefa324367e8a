"""Sweeps: trials over ranges of settings, on one or many machines (docs/sweeps.md)."""

from .compute import FailedPart
from .run import SweepResult, sweep
from .table import Table

__all__ = ["FailedPart", "SweepResult", "Table", "sweep"]
