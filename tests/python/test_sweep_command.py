"""`parloc sweep` as a command: its errors, interrupts, a full disk, another version."""

import os
import signal
import subprocess
import sys
import time

import pytest
from sweep_here import SLOW, processes, write_sweep

import parloc
from parloc.program import program_path
from parloc.sweeps.shard_file import ShardCount

pytest.importorskip("yaml")


def command(*words, **more):
    return subprocess.Popen([sys.executable, "-m", "parloc.sweeps", *map(str, words)], stdout=subprocess.PIPE,
                            stderr=subprocess.PIPE, text=True, **more)


def test_the_command_is_interrupted_and_goes_on(tmp_path):
    plan, out = write_sweep(tmp_path, **SLOW), tmp_path / "out"
    running = command(plan, "--out", out, "--jobs", 2, "--quiet")
    until = time.monotonic() + 20
    shards = "runs/*/parts/*/shard.parloc"
    while not any(ShardCount(file).update() for file in out.glob(shards)) and time.monotonic() < until:
        time.sleep(0.05)
    running.send_signal(signal.SIGINT)
    _, said = running.communicate(timeout=30)
    assert running.returncode == 130 and said.count("\n") == 1 and "interrupted" in said, said
    assert not processes(out)
    again = command(plan, "--out", out, "--jobs", 2)
    told, said = again.communicate(timeout=60)
    assert again.returncode == 0 and "8 trials of 1 points" in told and not said.startswith("0 of 8"), said


def test_parts_end_with_a_sweep_that_is_killed(tmp_path):
    plan, out = write_sweep(tmp_path, **SLOW), tmp_path / "out"
    running = command(plan, "--out", out, "--jobs", 2, "--quiet")
    until = time.monotonic() + 20
    while not processes(out) and time.monotonic() < until:
        time.sleep(0.05)
    running.kill()
    running.communicate()
    until = time.monotonic() + 5
    while processes(out) and time.monotonic() < until:
        time.sleep(0.05)
    assert not processes(out)


@pytest.mark.parametrize(("words", "code", "error"), [
    (["--out", "x"], 2, "S.yaml"),
    (["nothing.yaml", "--out", "x"], 3, "nothing.yaml: cannot be read"),
    (["{plan}"], 2, "--out"),
    (["{plan}", "--out", "x", "--jobs", "0"], 2, "expected a whole number"),
    (["{plan}", "--out", "x", "--engine", "lokal"], 2, "expected local, slurm, dask, none"),
    (["{plan}", "--out", "/proc/x"], 5, "/proc/x: cannot be written"),
    (["{plan}", "--out", "/dev/full"], 5, "/dev/full"),
])
def test_errors_of_the_command_are_one_line(tmp_path, words, code, error):
    plan = write_sweep(tmp_path)
    running = command(*(word.format(plan=plan) for word in words), cwd=tmp_path)
    told, said = running.communicate(timeout=60)
    assert (running.returncode, told) == (code, "") and error in said
    assert said.startswith("parloc: ") and said.count("\n") == 1


def test_help_fits_a_screen():
    told, _ = command("--help").communicate(timeout=60)
    assert len(told.splitlines()) <= 24 and max(map(len, told.splitlines())) <= 80
    # The same by the program, which looks for the Python on PATH.
    environment = os.environ | {"PATH": f"{os.path.dirname(sys.executable)}:{os.environ['PATH']}"}
    by_program = subprocess.run([program_path(), "sweep", "--help"], env=environment, capture_output=True, check=True)
    assert by_program.stdout.decode() == told


def test_another_version_is_refused(tmp_path, monkeypatch):
    fake = tmp_path / "parloc"
    fake.write_text("#!/bin/sh\necho parloc 0.0.7\n")
    fake.chmod(0o755)
    environment = os.environ | {"PARLOC_PROGRAM": str(fake)}
    running = command(write_sweep(tmp_path), "--out", tmp_path / "out", env=environment)
    _, said = running.communicate(timeout=60)
    assert running.returncode == 6 and said.count("\n") == 1
    assert f"expected parloc {parloc.__version__}" in said and "0.0.7" in said
    # On the worker alone: nothing is computed there, and what is there stays.
    parloc.program.program_path()
    monkeypatch.setenv("PARLOC_PROGRAM", str(fake))
    with pytest.raises(parloc.BackendError, match=f"expected parloc {parloc.__version__} on .*, found: parloc 0.0.7"):
        parloc.sweep(write_sweep(tmp_path), out=tmp_path / "out")
    monkeypatch.undo()
    assert len(parloc.sweep(write_sweep(tmp_path), out=tmp_path / "out").table) == 6


def test_a_full_disk_is_one_line_and_costs_nothing(tmp_path):
    """A file system of 96 kB, in a name space of its own."""
    plan = write_sweep(tmp_path, trials=24, particles=[20], duration=0.5)
    disk = tmp_path / "disk"
    disk.mkdir()
    again = f"{sys.executable} -m parloc.sweeps {plan} --out {disk}/out --jobs 2 --parts 2 --quiet"
    inside = (f"mount -t tmpfs -o size=96k none {disk} && {again} --attempts 1; echo $?; "
              f"mount -o remount,size=64m {disk}; {again}; echo $?; wc -l < {disk}/out/table.csv")
    done = subprocess.run(["unshare", "-rm", "sh", "-c", inside], capture_output=True, text=True, check=False)
    if "unshare" in done.stderr or "mount" in done.stderr:
        pytest.skip(f"no name space for a small disk: {done.stderr.strip()}")
    assert done.stdout.split() == ["5", "0", "25"], done.stdout + done.stderr
    assert done.stderr.count("\n") == 1 and "No space left on device" in done.stderr
