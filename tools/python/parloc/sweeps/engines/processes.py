"""A part as a process of this machine."""

from __future__ import annotations

import contextlib
import ctypes
import os
import signal
import subprocess
import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

_PR_SET_PDEATHSIG = 1
_libc = ctypes.CDLL(None, use_errno=True)


@dataclass(frozen=True)
class Ended:
    """A part that has come to an end: its exit code (negative: by that signal; None: nobody knows), and the last line of its
    standard error."""

    number: int
    code: int | None
    said: str


class PartProcess:
    """`part.sh NUMBER`, which ends with the process that has started it, however that ends."""

    def __init__(self, folder: Path, number: int, environment: Mapping[str, str] | None = None):
        self.number = number
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115
        self._process = subprocess.Popen(
            ["sh", str(folder / "part.sh"), str(number)], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
            stderr=self._errors, env={**os.environ, **(environment or {})},
            start_new_session=True,  # Ctrl-C is for whoever has started the sweep, who then stops the parts
            preexec_fn=_end_with_parent,
        )

    def ended(self) -> Ended | None:
        """Nothing while it works."""
        code = self._process.poll()
        if code is None:
            return None
        self._errors.seek(max(0, self._errors.seek(0, os.SEEK_END) - 2000))
        said = last_line(self._errors.read().decode(errors="replace"))
        self._errors.close()
        return Ended(self.number, code, said)

    def stop(self, patience_s: float = 10.0) -> None:
        """Lets it finish what it writes, then ends it."""
        with contextlib.suppress(OSError):
            self._process.send_signal(signal.SIGTERM)
        try:
            self._process.wait(patience_s)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._errors.close()


def last_line(text: str) -> str:
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return lines[-1] if lines else ""


def _end_with_parent() -> None:
    _libc.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


def run_part(folder: str, number: int, stop_file: str) -> Ended:
    """To its end, or until there is a file of that name. What a worker on another machine calls."""
    stopped = Ended(number, 128 + signal.SIGINT, "stopped")
    if os.path.exists(stop_file):
        return stopped
    process = PartProcess(Path(folder), number)
    while True:
        ended = process.ended()
        if ended:
            return ended
        if os.path.exists(stop_file):
            process.stop()
            return stopped
        time.sleep(0.1)
