"""What the tests of sweeps share: a small sweep, what one run of it would have said, and parts that are killed half-way."""

import json
import os
import shlex
import signal
import subprocess
from pathlib import Path

from conftest import ROOT

import parloc

SCENARIO = ROOT / "configs" / "paz2012_scenario.yaml"
SLOW = {"trials": 8, "particles": [4000], "duration": 3}  # a trial takes long enough to be killed in it


def write_sweep(folder, trials=3, particles=(50, 100), duration=1.0, name="sweep.yaml"):
    text = (f"scenarios: {SCENARIO}\ntask: track\ntrials: {trials}\nduration: {duration}\n"
            f"settings:\n  particles: {list(particles)}\n")
    path = Path(folder) / name
    path.write_text(text)
    return path


def results(path):
    """Of a command, as text without what a clock has said."""
    found = json.loads(Path(path).read_text())
    del found["times"]
    return json.dumps(found)


def expect_equal_to_one_run(out):
    """Each run's merged results are those of its command without shards."""
    commands = {}
    for line in (out / "parts.txt").read_text().splitlines():
        words = shlex.split(line)
        at = words.index("--shard")
        commands[words[at + 3].split("/")[1]] = words[:at]
    for run, words in commands.items():
        whole = out / "whole" / run
        subprocess.run([parloc.program.program_path(), *words, "--out", str(whole)], cwd=out, check=True)
        name = f"{words[0]}.json"
        assert results(out / "runs" / run / "merged" / name) == results(whole / name)


def processes(folder, name="parloc"):
    """Programs of that name at work on a part in this folder."""
    found = []
    for entry in Path("/proc").iterdir():
        try:
            words = (entry / "cmdline").read_bytes().decode().split("\0")
            is_here = (entry / "cwd").readlink() == folder
        except (OSError, UnicodeDecodeError):
            continue
        if entry.name.isdecimal() and is_here and Path(words[0]).name == name and "--shard" in words:
            found.append(int(entry.name))
    return found


class Killer:
    """A progress function that kills what works on a part, once trials are done, and keeps what was in the files by then."""

    def __init__(self, out, find=None):
        self.out, self.find = Path(out).absolute(), find or (lambda: processes(self.out))
        self.killed, self.files = [], {}

    def __call__(self, done, of):
        if self.killed or not 1 <= done < of:
            return
        for process in self.find()[:1]:
            os.kill(process, signal.SIGKILL)
            self.killed.append(process)
        self.files = {file: file.read_bytes() for file in self.out.glob("runs/*/parts/*/shard.parloc")}

    def expect_that_all_was_kept(self):
        """Nothing that was finished was done again: the files have only grown, but for a trial that was being written."""
        assert self.killed and self.files
        for file, before in self.files.items():
            assert file.read_bytes()[: len(before) - 64] == before[:-64]
