"""The program `parloc`, for what is computed by calling it."""

from __future__ import annotations

import functools
import os
import shutil
import subprocess
import sys
from pathlib import Path

from ._parloc import version
from .errors import BackendError


@functools.cache
def program_path() -> str:
    """The program of this package's version: the one that PARLOC_PROGRAM names (`parloc sweep` says itself), else the one
    beside this Python, else the one on PATH. Raises BackendError if there is none, or one of another version."""
    beside = Path(sys.executable).parent / "parloc"
    named = os.environ.get("PARLOC_PROGRAM") or (str(beside) if beside.exists() else "parloc")
    path = shutil.which(named)
    if path is None:
        raise BackendError(f"expected the program parloc beside {sys.executable} or on PATH, found no {named}")
    path = str(Path(path).absolute())
    said = version_of(path)
    if said != expected_version():
        raise BackendError(f"{path}: expected {expected_version()}, as this Python package is, found '{said}'")
    return path


def version_of(path: str) -> str:
    """What that program says for `--version`, or what came instead."""
    try:
        done = subprocess.run([path, "--version"], capture_output=True, text=True, timeout=60, check=False)
    except (OSError, subprocess.TimeoutExpired) as error:
        return str(error)
    return (done.stdout.strip() or done.stderr.strip() or f"exit code {done.returncode}").splitlines()[0]


def expected_version() -> str:
    """What the program of this package's version says for `--version`."""
    return f"parloc {version}"
