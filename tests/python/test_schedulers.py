"""Files for other schedulers: GNU parallel, and an Indexed Job of Kubernetes, held against the official schema."""

import os
import shutil
import subprocess

import pytest
from conftest import ROOT
from sweep_here import write_sweep

import parloc

yaml = pytest.importorskip("yaml")

FILES = ROOT / "configs" / "engines"


@pytest.fixture
def prepared(tmp_path):
    plan, out = write_sweep(tmp_path), tmp_path / "out"
    result = parloc.sweep(plan, out=out, engine="none", parts=2)
    assert result.missing == 2 and len(result.table) == 0 and len((out / "parts.txt").read_text().splitlines()) == 4
    yield out
    done = parloc.sweep(plan, out=out, engine="none")
    assert len(done.table) == 6 and not done.missing


def test_the_job_is_one_of_kubernetes():
    validate = pytest.importorskip("kubernetes_validate")
    job = yaml.safe_load((FILES / "kubernetes_job.yaml").read_text())
    version = validate.latest_version()
    validate.validate(job, version, strict=True)
    job["spec"]["completionsMode"] = job["spec"].pop("completionMode")
    with pytest.raises(validate.ValidationError):  # it can fail
        validate.validate(job, version, strict=True)


def test_the_job_computes_every_part(prepared):
    spec = yaml.safe_load((FILES / "kubernetes_job.yaml").read_text())["spec"]
    (container,) = spec["template"]["spec"]["containers"]
    environment = os.environ | {item["name"]: item["value"] for item in container["env"]}
    for index in range(4):
        subprocess.run(container["command"], cwd=prepared, env=environment | {"JOB_COMPLETION_INDEX": str(index)}, check=True)
    beyond = subprocess.run(container["command"], cwd=prepared, env=environment | {"JOB_COMPLETION_INDEX": "4"},
                            capture_output=True, text=True, check=False)
    assert beyond.returncode in spec["podFailurePolicy"]["rules"][0]["onExitCodes"]["values"]
    assert beyond.stderr == "parloc: expected a part from 1 to 4, got '5'\n"


def test_gnu_parallel_computes_every_part(prepared, tmp_path):
    program = shutil.which("parallel")
    if not program or "GNU parallel" not in subprocess.run([program, "--version"], capture_output=True, text=True).stdout:
        for number in range(1, 5):
            subprocess.run(["sh", prepared / "part.sh", str(number)], check=True)
        pytest.skip("GNU parallel is not installed (apt-get install parallel)")
    subprocess.run([FILES / "gnu_parallel.sh", prepared, "--jobs", "2"], check=True, env=os.environ | {"HOME": str(tmp_path)})
