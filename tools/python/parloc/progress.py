"""How far a run is, told by rich or to a function."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

ProgressOption = bool | Callable[[float, int], object]
"""False: nothing is told; True: a bar by rich; a function: called with the share read, 0 to 1, and the scans so far."""


@contextmanager
def reporting(progress: ProgressOption, scans: Any) -> Iterator[Callable[[int], object]]:
    """Gives a function to be called with the number of scans after each of them."""

    def share() -> float:
        return getattr(scans, "progress", 0.0)

    if progress is False:
        yield lambda read: None
    elif progress is True:
        from rich.progress import Progress

        with Progress(transient=True) as bar:
            task = bar.add_task("", total=1.0)
            yield lambda read: bar.update(task, completed=share(), description=f"{read} scans")
    else:
        yield lambda read: progress(share(), read)
