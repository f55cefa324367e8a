"""Settings for a robot from its recorded drives, with a verdict on drives that nothing was fitted to (docs/tune.md).

Needs Optuna and matplotlib: pip install 'parloc[tune]'.
"""

from ..intervals import Interval
from .drives import DriveFiles
from .results import write_results
from .score import PieceScore
from .space import DEFAULT_SPACE, Choice, Range
from .tuner import Tuning, doubt, summary, tune
from .verdict import Comparison

__all__ = [
    "DEFAULT_SPACE",
    "Choice",
    "Comparison",
    "DriveFiles",
    "Interval",
    "PieceScore",
    "Range",
    "Tuning",
    "doubt",
    "summary",
    "tune",
    "write_results",
]
