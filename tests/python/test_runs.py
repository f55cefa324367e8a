"""Filters driven step by step and over logs; threads and interrupts."""

import signal
import threading
import time

import numpy as np
import pytest
from conftest import LOG, ROOT, TRUTH

import parloc

CONFIG = parloc.Config(particles=80)


def test_steps_from_numpy_are_those_of_the_log(corridor, start):
    track = parloc.Localizer(corridor, CONFIG).run(LOG, start=start)
    localizer = parloc.Localizer(corridor, CONFIG)
    localizer.start_at(start)
    for record in parloc.open_log(LOG):
        s = record.scan
        scan = parloc.Scan(
            np.array(s.ranges_m), s.angle_min_rad, s.angle_step_rad, stamp_s=s.stamp_s, sensor=s.sensor,
            T_base_sensor=tuple(s.T_base_sensor), range_min_m=s.range_min_m, range_max_m=s.range_max_m,
        )
        estimate = localizer.step(tuple(record.odometry), scan)
    assert localizer.digest() == track.digest and tuple(estimate.pose) == tuple(track.poses[-1])
    particles = localizer.particles()
    assert particles.shape == (80, 4) and particles.dtype == np.float32 and particles[:, 3].sum() == pytest.approx(1)
    assert localizer.particles(10).shape == (10, 4)
    assert localizer.steps == len(track) and localizer.lidars_used()[0].beams.total == localizer.beam_counts().total > 0


def test_track(corridor):
    truth = parloc.read_trajectory(TRUTH)
    told = []
    localizer = parloc.Localizer(corridor, CONFIG)
    track = localizer.run(LOG, start="global", progress=lambda share, scans: told.append((share, scans)))
    assert len(track) == len(track.stamps_s) == len(track.states) == told[-1][1] and told[-1][0] == 1.0
    assert track.trajectory.shape == (len(track), 4) and track.covariances.shape == (len(track), 3, 3)
    assert set(track.states) <= {"tracking", "ambiguous", "lost"} and track.probabilities[-1] > 0.5
    assert track.errors(truth).position_rmse_m < 0.3
    assert track.estimates[-1].filter.n_eff > 1 and repr(track.estimates[-1]).startswith("<parloc.LocalizerEstimate tracking")


def test_guesses_and_priors(corridor, start):
    record = next(iter(parloc.open_log(LOG)))
    localizer = parloc.Localizer(corridor, CONFIG)
    localizer.start_at([parloc.PoseGuess(start), parloc.PoseGuess((20, 0, 0), weight=0.1)])
    near = parloc.Pose(*start)
    pose = localizer.step(record).pose
    assert np.hypot(pose.x_m - near.x_m, pose.y_m - near.y_m) < 1
    localizer.start_anywhere(region=(near.x_m, near.y_m, 3.0), heading=(near.theta_rad, 0.3))
    pose = localizer.step(record).pose
    assert np.hypot(pose.x_m - near.x_m, pose.y_m - near.y_m) < 3.5 and localizer.searches == 1
    with pytest.raises(parloc.InputError):
        localizer.start_at((1e6, 0, 0))
    with pytest.raises(parloc.UsageError, match="start: expected a pose or global, got 'anywhere'"):
        localizer.run(LOG, start="anywhere")


def test_global_search(corridor, start):
    record = next(iter(parloc.open_log(LOG)))
    result = parloc.GlobalSearch(corridor).search(record.scan)
    best = result.hypotheses[0]
    assert np.hypot(best.pose.x_m - start[0], best.pose.y_m - start[1]) < 0.3 and best.weight > 0.5
    nearby = parloc.GlobalSearch(corridor).search(record.scan, region=(start[0], start[1], 2.0))
    assert all(np.hypot(h.pose.x_m - start[0], h.pose.y_m - start[1]) < 3 for h in nearby.hypotheses)
    with pytest.raises(parloc.InputError):
        parloc.GlobalSearch(corridor).search(record.scan, region=(1e6, 0, 1.0))


def test_slam_goes_on_from_a_checkpoint(tmp_path):
    config = parloc.Config(slam={"particles": 3})
    whole = parloc.GridSlam(config)
    assert whole.run(LOG) == 37
    first = parloc.GridSlam(config)
    for k, record in enumerate(parloc.iter_scans(LOG, config)):
        if k == 20:
            first.save(tmp_path / "state")
            first = parloc.GridSlam.load(tmp_path / "state")
        first.step(record)
    assert first.digest() == whole.digest() and first.config.slam.particles == 3
    assert whole.trajectory().shape == (37, 4) and whole.poses().shape == (3, 3)
    assert 0 < len(whole.records()) <= 37 and whole.memory_bytes > 0 and whole.loops() is not None


def test_simulated_drive_is_that_of_the_program(program, tmp_path):
    made = parloc.simulate(ROOT / "configs" / "paz2012_scenario.yaml", seed=3)
    made.save(tmp_path / "scans.log")
    assert made.truth.shape[1] == 4 and made.hits <= made.beams and made.duration_s > 10
    again = parloc.open_log(tmp_path / "scans.log")
    ranges = [np.array(r.scan.ranges_m) for r in made.log]
    assert all((a == b.scan.ranges_m).all() for a, b in zip(ranges, again, strict=True))


def test_evaluate_is_that_of_the_program(program):
    scenario = ROOT / "configs" / "paz2012_scenario.yaml"
    config = parloc.Config(particles=200)
    e = parloc.evaluate(scenario, trials=2, config=config, limit_s=1.0, duration_s=2.0, jobs=1)
    assert len(e.trials) == 2 and e.success.trials == 2
    ran = program("evaluate", "--scenario", scenario, "--trials", 2, "--particles", 200, "--limit", 1, "--duration", 2)
    assert ran["summary"]["success"]["hits"] == e.success.hits
    assert ran["summary"]["rmse_m"] == e.rmse_m > 0
    with pytest.raises(parloc.UsageError, match="task: expected global, kidnap or track, got 'x'"):
        parloc.evaluate(scenario, task="x")


def test_other_threads_run_while_a_filter_works(corridor, start):
    localizer = parloc.Localizer(corridor, parloc.Config(particles=300_000, threads=1))
    localizer.start_at(start)
    record = next(iter(parloc.open_log(LOG)))
    counted, done = 0, threading.Event()

    def step():
        localizer.step(record)
        done.set()

    thread = threading.Thread(target=step)
    thread.start()
    while not done.is_set():
        counted += 1
    thread.join()
    assert counted > 1000  # the GIL was free


def test_threads_that_share_a_filter_take_turns(corridor, start):
    localizer = parloc.Localizer(corridor, CONFIG)
    localizer.start_at(start)
    records = list(parloc.open_log(LOG))
    threads = [threading.Thread(target=lambda: [localizer.step(r) for r in records[:10]]) for _ in range(4)]
    for t in threads:
        t.start()
    for t in threads:
        t.join()
    assert localizer.steps == 40


def test_interrupt_ends_a_run_between_two_scans(corridor, start):
    localizer = parloc.Localizer(corridor, parloc.Config(particles=20_000))
    localizer.start_at(start)
    records = list(parloc.open_log(LOG))
    killer = threading.Timer(0.3, signal.raise_signal, [signal.SIGINT])
    killer.start()
    begun = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        localizer.run(records * 1000)
    assert time.monotonic() - begun < 30 and localizer.steps > 0


def test_what_there_was_before_a_damaged_record_is_kept(corridor, start):
    def damaged():
        for k, record in enumerate(parloc.open_log(LOG)):
            if k == 12:
                raise parloc.InputError("damaged from here on")
            yield record

    with pytest.raises(parloc.InputError, match="damaged") as told:
        parloc.Localizer(corridor, CONFIG).run(damaged(), start=start)
    whole = parloc.Localizer(corridor, CONFIG).run(LOG, start=start)
    assert len(told.value.track) == 12 and (told.value.track.poses == whole.poses[:12]).all()


def test_interrupt_ends_a_search_and_a_simulation(corridor):
    killer = threading.Timer(0.2, signal.raise_signal, [signal.SIGINT])
    killer.start()
    with pytest.raises(KeyboardInterrupt):
        for seed in range(10_000):
            parloc.simulate(ROOT / "configs" / "paz2012_scenario.yaml", seed=seed)
