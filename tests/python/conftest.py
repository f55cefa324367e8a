"""Where the package, the program and the shipped logs are: ctest says so, and an installed package needs no saying."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest

import parloc

ROOT = Path(__file__).resolve().parents[2]
MAP = ROOT / "maps" / "malaga_corridor.yaml"
LOG = ROOT / "maps" / "logs" / "malaga_corridor.log.gz"
TRUTH = ROOT / "maps" / "logs" / "malaga_corridor.tum"


@pytest.fixture(scope="session")
def corridor():
    return parloc.read_map(MAP)


@pytest.fixture(scope="session")
def start():
    """Where the shipped log begins, as its truth says."""
    return tuple(parloc.read_trajectory(TRUTH)[0, 1:])


@pytest.fixture(scope="session")
def program():
    """program(argument...) runs `parloc` and gives the metrics that it prints."""
    path = os.environ.get("PARLOC_PROGRAM") or shutil.which("parloc")
    assert path, "PARLOC_PROGRAM is not set, and there is no parloc on PATH"

    def run(*arguments):
        done = subprocess.run([path, *map(str, arguments), "--json"], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return run
