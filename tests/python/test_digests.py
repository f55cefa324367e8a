"""The package and the program give the same bits."""

import re

import pytest
from conftest import LOG, MAP, ROOT

import parloc


def as_text(start):
    return ",".join(map(repr, map(float, start)))


@pytest.mark.parametrize("model", ["beam", "likelihood_field"])
def test_particle_filter(model, corridor, start, program, tmp_path):
    config = parloc.Config(particles=80, sensor={"model": model}, localize={"health": False}, seed=5)
    (tmp_path / "config.yaml").write_text(config.to_yaml())
    track = parloc.ParticleFilter(corridor, config).run(LOG, start=start)
    ran = program("run", "--map", MAP, "--log", LOG, "--init", as_text(start), "--config", tmp_path / "config.yaml",
                  "--out", tmp_path / "out")
    assert track.digest == ran["digest"]
    parloc.write_trajectory(tmp_path / "track.tum", track.trajectory)
    assert (tmp_path / "track.tum").read_text() == (tmp_path / "out" / "trajectory.tum").read_text()


@pytest.mark.parametrize("where", ["given", "global"])
def test_localizer(where, corridor, start, program, tmp_path):
    config = parloc.Config(particles=80)
    (tmp_path / "config.yaml").write_text(config.to_yaml())
    track = parloc.Localizer(corridor, config).run(LOG, start=start if where == "given" else "global")
    init = as_text(start) if where == "given" else "global"
    ran = program("run", "--map", MAP, "--log", LOG, "--init", init, "--config", tmp_path / "config.yaml",
                  "--out", tmp_path / "out")
    assert track.digest == ran["digest"]
    assert len(track) == ran["scans"]


def test_slam(program, tmp_path):
    config = parloc.Config(slam={"particles": 4})
    (tmp_path / "config.yaml").write_text(config.to_yaml())
    slam = parloc.make_map(LOG, config)
    ran = program("slam", "--log", LOG, "--config", tmp_path / "config.yaml", "--out", tmp_path / "map")
    assert slam.digest() == ran["digest"]
    assert (slam.map().cells == parloc.read_map(tmp_path / "map" / "map.yaml").cells).all()


GOLDEN = dict(re.findall(r'Golden\{"(\w+)", "(\w{64})"\}', (ROOT / "tests/system/flow_digest_test.cpp").read_text()))


@pytest.mark.parametrize("method", ["ekf", "ekf_beams", "edh", "naedh", "ledh", "gromov", "pfpf"])
def test_flow(method, corridor):
    """No command prints digests of these filters: those of the library's own test, whose settings these are."""
    motion = {"sigma_rot_min_rad": 0.001, "sigma_trans_min_m": 0.002, "sigma_rot_per_s": 0.0, "sigma_trans_per_s": 0.0}
    config = parloc.Config(
        particles=60, seed=42, backend="cpu", motion=motion,
        flow={"max_beams": 120, "steps": 6, "max_dist": 1.0, "sigma_psi_cells": 0.4},
    )
    flow = parloc.FlowFilter(method, corridor, config)
    flow.start_at((3.453, -10.171, -0.485), (0.2, 0.2, 0.1))
    for record in parloc.iter_scans(LOG, config):
        flow.step(record.odometry, record.scan)
    assert flow.digest() == GOLDEN[method]
