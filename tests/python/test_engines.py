"""Engines besides the local one: Dask and Slurm with something killed half-way, and what is said where they are not there."""

import os
import shutil
import signal

import pytest
from slurm_here import Slurm, why_not
from sweep_here import SLOW, Killer, expect_equal_to_one_run, write_sweep

import parloc
from parloc.sweeps.engines import processes
from parloc.sweeps.engines.local import LocalEngine
from parloc.sweeps.engines.slurm import SlurmEngine

pytest.importorskip("yaml")


@pytest.fixture(scope="module")
def slurm(tmp_path_factory):
    reason = why_not()
    if reason:
        pytest.skip(reason)
    here = Slurm(tmp_path_factory.mktemp("slurm"))
    os.environ.update(here.environment)
    yield here
    for name in here.environment:
        del os.environ[name]
    here.stop()


@pytest.fixture(scope="module")
def client():
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None) as cluster,
        distributed.Client(cluster) as made,
    ):
        yield made


def test_dask_with_a_worker_killed(client, tmp_path):
    killer = Killer(tmp_path / "out", lambda: [pid for pid in client.run(pid_if_busy).values() if pid])
    result = parloc.sweep(write_sweep(tmp_path, **SLOW), out=tmp_path / "out", engine=client, parts=4, progress=killer)
    killer.expect_that_all_was_kept()
    assert len(result.table) == 8 and not result.failed
    expect_equal_to_one_run(tmp_path / "out")


def pid_if_busy(dask_worker):
    return os.getpid() if dask_worker.state.executing_count else None


def test_dask_by_address_and_interrupted(client, tmp_path):
    plan, out = write_sweep(tmp_path, **SLOW), tmp_path / "out"

    def interrupt(done, of):
        if done:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        parloc.sweep(plan, out=out, engine=client.scheduler.address, parts=4, progress=interrupt)
    assert not any(client.processing().values()) and not list(out.glob("stop*"))
    told = []
    result = parloc.sweep(plan, out=out, engine=client, progress=lambda *now: told.append(now))
    assert told[0][0] >= 1 and len(result.table) == 8


def test_dask_that_is_not_there(tmp_path):
    pytest.importorskip("distributed")
    with pytest.raises(parloc.BackendError, match="engine dask: expected a scheduler at tcp://127.0.0.1:9"):
        parloc.sweep(write_sweep(tmp_path), out=tmp_path / "out", engine="tcp://127.0.0.1:9")


def test_slurm_with_a_task_killed(slurm, tmp_path):
    """With its script, as on a node that has no memory left: it leaves no exit code behind."""
    out, killed = tmp_path / "out", []

    def kill(done, of):
        running = slurm.ask("squeue", "-h", "-r", "-t", "R", "-o", "%F_%K").split()
        if done and running and not killed:
            slurm.ask("scancel", "--signal=KILL", "--full", running[0])
            killed.append(running[0])

    result = parloc.sweep(write_sweep(tmp_path, **SLOW), out=out, engine="slurm", parts=4, progress=kill)
    assert killed and len(result.table) == 8 and not result.failed
    assert (out / "slurm" / "2" / "parts").read_text().count("\n") == 1  # that part was submitted again
    expect_equal_to_one_run(out)


def test_slurm_interrupted(slurm, tmp_path):
    plan, out = write_sweep(tmp_path, **SLOW), tmp_path / "out"

    def interrupt(done, of):
        if done:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        parloc.sweep(plan, out=out, engine="slurm", jobs=1, parts=4, progress=interrupt)
    assert not slurm.ask("squeue", "-h").strip()
    assert len(parloc.sweep(plan, out=out, jobs=2).table) == 8


def test_what_a_killed_sweep_has_left_in_the_queue_is_waited_for(slurm, tmp_path):
    plan, out = write_sweep(tmp_path, **SLOW), tmp_path / "out"
    child = os.fork()
    if child == 0:
        parloc.sweep(plan, out=out, engine="slurm", parts=4, progress=lambda done, of: done and die())
    os.waitpid(child, 0)
    assert slurm.ask("squeue", "-h").strip()
    assert len(parloc.sweep(plan, out=out, engine="slurm").table) == 8
    assert [folder.name for folder in (out / "slurm").iterdir()] == ["1"]
    expect_equal_to_one_run(out)


def die():
    os.kill(os.getpid(), signal.SIGKILL)


def test_slurm_that_refuses(slurm, tmp_path):
    plan = write_sweep(tmp_path)
    with pytest.raises(parloc.BackendError, match="engine slurm: .*[Ii]nvalid partition"):
        parloc.sweep(plan, out=tmp_path / "out", engine="slurm", options=["--partition=nowhere"])
    assert len(parloc.sweep(plan, out=tmp_path / "out").table) == 6


def test_no_slurm(tmp_path, monkeypatch):
    for name in ("sh", "sed", "uname", "wc", "dirname"):
        (tmp_path / name).symlink_to(shutil.which(name))
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(parloc.BackendError, match="engine slurm: expected sbatch, squeue and scancel on PATH, found no sbatch"):
        parloc.sweep(write_sweep(tmp_path), out=tmp_path / "out", engine="slurm")


def test_a_controller_that_does_not_answer_is_waited_for(tmp_path, monkeypatch):
    fake = tmp_path / "squeue"
    for said, queued in (("slurm_load_jobs error: Unable to contact slurm controller", None),
                         ("slurm_load_jobs error: Invalid job id specified", set())):
        fake.write_text(f"#!/bin/sh\necho '{said}' >&2; exit 1\n")
        fake.chmod(0o755)
        monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
        assert SlurmEngine._in_queue(["7"]) == queued


def test_each_gpu_has_a_worker(monkeypatch, tmp_path):
    monkeypatch.delenv("CUDA_VISIBLE_DEVICES", raising=False)
    monkeypatch.setattr("parloc.sweeps.engines.local.program_path", lambda: str(tmp_path / "parloc"))
    (tmp_path / "parloc").write_text("#!/bin/sh\necho 'cpu: two cores'; echo 'cuda 0: GPU'; echo 'cuda 1: GPU'\n")
    (tmp_path / "parloc").chmod(0o755)
    engine = LocalEngine()
    assert engine.jobs == 2 and [engine.environment(k)["CUDA_VISIBLE_DEVICES"] for k in (0, 1)] == ["0", "1"]
    assert [LocalEngine(4).environment(k)["CUDA_VISIBLE_DEVICES"] for k in range(4)] == ["0", "1", "0", "1"]
    monkeypatch.setenv("CUDA_VISIBLE_DEVICES", "3,5")
    (tmp_path / "part.sh").write_text('echo "$CUDA_VISIBLE_DEVICES $1" >> ran; sleep 0.3; echo $1 >&2; exit $1\n')
    engine = LocalEngine()
    monkeypatch.chdir(tmp_path)
    engine.start(tmp_path, 2)
    engine.submit([1, 2])
    ended = [e for _ in range(10) for e in engine.ended(0.2)]
    assert sorted((e.number, e.code, e.said) for e in ended) == [(1, 1, "1"), (2, 2, "2")]
    assert sorted((tmp_path / "ran").read_text().splitlines()) == ["3 1", "5 2"]
    (tmp_path / "parloc").write_text("#!/bin/sh\necho 'cpu: two cores'; echo 'cuda: not in this build'\n")
    assert LocalEngine().environment(0) == {} and processes.last_line("a\n b \n\n") == "b"
