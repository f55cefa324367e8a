"""Tuning: pieces of drives, their score, the verdict, and whole searches on simulated drives that tuning knows nothing of."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from conftest import LOG, MAP, ROOT, TRUTH

import parloc

pytest.importorskip("optuna", reason="tuning needs Optuna")
from parloc import tuning  # noqa: E402
from parloc.intervals import mean_interval  # noqa: E402
from parloc.tuning import drives, score, space, space_file, verdict  # noqa: E402

FACULTY = tuning.DriveFiles(
    *(str(ROOT / "maps" / n) for n in ("logs/malaga_faculty.log.gz", "malaga_faculty.yaml", "logs/malaga_faculty.tum"))
)
WIDE = {"sensor.sigma_hit": tuning.Range(0.02, 0.4, log=True), "sensor.effective_beams": tuning.Range(2.0, 60.0, log=True)}
POOR = parloc.Config(particles=100, sensor={"sigma_hit": 0.4, "effective_beams": 2.0}, localize={"recover": False})


@pytest.fixture(scope="session")
def office(tmp_path_factory):
    """Five minutes on the office floor at one scan a second, simulated with exact truth."""
    folder = tmp_path_factory.mktemp("office")
    text = (ROOT / "configs" / "office_scenario.yaml").read_text()
    scenario = folder / "scenario.yaml"
    scenario.write_text(text.replace("../maps", str(ROOT / "maps")).replace("scan_rate: 10 ", "scan_rate: 1 "))
    program = os.environ.get("PARLOC_PROGRAM") or shutil.which("parloc")
    subprocess.run([program, "simulate", "--scenario", scenario, "--out", folder, "--quiet"], check=True)
    return tuning.DriveFiles(str(folder / "scans.log"), str(ROOT / "maps" / "office.yaml"), str(folder / "truth.tum"))


# ---- Drives and their pieces -------------------------------------------------------------------------------------------


def test_a_log_is_cut_into_pieces_and_the_later_ones_are_kept_back(tmp_path):
    pieces = drives.read_pieces(FACULTY, parloc.Config(), str(tmp_path))
    fit, test = drives.split(pieces)
    assert len(pieces) == 5 and len(fit) == 3 and sum(len(p.records) for p in pieces) == 225
    assert max(p.records[-1].stamp_s for p in fit) < min(p.begin_s for p in test)
    for piece in pieces:
        assert piece.truth.shape == (len(piece.records), 3) and tuple(piece.start) == tuple(piece.truth[0])
    assert not os.listdir(tmp_path)


def test_stamps_that_jump_back_neither_lose_nor_double_a_scan():
    stamps_s = np.concatenate([np.arange(0.0, 60.0, 0.1), np.arange(59.0, 120.0, 0.1)])
    cuts = drives._cuts(stamps_s)
    assert cuts[0][0] == 0 and cuts[-1][1] == len(stamps_s)
    assert all(a[1] == b[0] for a, b in zip(cuts, cuts[1:], strict=False))


def test_a_log_that_is_too_short_is_refused(tmp_path):
    with pytest.raises(parloc.InputError, match="expected 4 stretches of 10 s and 20 scans"):
        drives.read_pieces(tuning.DriveFiles(str(LOG), str(MAP), str(TRUTH)), parloc.Config(), str(tmp_path))
    with pytest.raises(parloc.InputError, match="needs the map"):
        drives.read_pieces(tuning.DriveFiles(str(LOG), None, str(TRUTH)), parloc.Config(), str(tmp_path))


# ---- The score ---------------------------------------------------------------------------------------------------------


def test_errors_of_motion_do_not_depend_on_the_frame():
    rng = np.random.default_rng(1)
    truth = np.column_stack([np.linspace(0, 20, 200), np.full(200, 3.0), rng.normal(0, 3, 200)])
    c, s = np.cos(2.0), np.sin(2.0)
    elsewhere = np.column_stack([truth[:, :2] @ np.array([[c, s], [-s, c]]) + [5.0, -3.0], truth[:, 2] + 2.0])
    position, heading = score._motion_errors(elsewhere, truth)
    known = np.isfinite(position)
    assert 150 < known.sum() < 200  # not before the first metre
    assert position[known].max() < 1e-9 and np.abs(heading[known]).max() < 1e-9
    longer = truth * [1.02, 1.02, 1.0]
    assert score._motion_errors(longer, truth)[0][known] == pytest.approx(0.02, rel=0.2)


def test_the_score_of_a_piece(tmp_path):
    pieces = drives.read_pieces(FACULTY, parloc.Config(), str(tmp_path))
    localizer = parloc.Localizer(pieces[0].map, parloc.Config(particles=300, threads=1))
    good, again = (score.score_piece(localizer, pieces[0], 1) for _ in range(2))
    assert good == again != score.score_piece(localizer, pieces[0], 2)
    assert 0 < good.position_m <= good.error_m < 0.15 and good.wrong == good.lost == 0 and good.nees > 0
    lost = parloc.Localizer(pieces[0].map, parloc.Config(particles=300, threads=1, localize={"recover": False}))
    far = drives.Piece(**{**vars(pieces[0]), "start": pieces[0].start + [4.0, 4.0, 2.0]})
    assert score.score_piece(lost, far, 1).error_m <= score.CAP_M
    assert score.score_piece(lost, far, 1).wrong > 0.5


# ---- Settings ----------------------------------------------------------------------------------------------------------


def test_shares_of_beams_still_sum_to_one():
    config = space.configured(parloc.Config(), {"sensor.z_rand": 0.25})
    assert config.sensor.z_hit == 0.75
    config = space.configured(parloc.Config(), {"sensor.model": "beam", "sensor.z_rand": 0.25, "sensor.sigma_hit": 0.2})
    total = sum(config[f"sensor.{z}"] for z in ("z_hit", "z_short", "z_max", "z_rand"))
    assert total == pytest.approx(1) and config.sensor.sigma_hit == 0.2
    parloc.Localizer(parloc.read_map(MAP), config)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({}, "at least one"),
        ({"sensor.sigma_hot": tuning.Range(0.1, 0.2)}, "nearest is 'sensor.sigma_hit'"),
        ({"sensor.sigma_hit": tuning.Range(0.2, 0.1)}, "a smaller number, then a larger one"),
        ({"sensor.z_rand": tuning.Range(0.0, 0.1, log=True)}, "above 0"),
        ({"sensor.sigma_hit": tuning.Range(0.1, 200.0)}, "0.001 to 10"),
        ({"sensor.model": tuning.Choice(("beam", "beams"))}, "beam"),
        ({"slam.particles": tuning.Range(1, 10)}, "cannot be tuned"),
    ],
)
def test_what_cannot_be_tuned_is_refused(wrong, said):
    with pytest.raises(parloc.ConfigError, match=said):
        space.check(wrong, parloc.Config())


def test_settings_are_read_from_a_file(tmp_path):
    file = tmp_path / "s.yaml"
    file.write_text(
        "sensor.sigma_hit: {from: 0.02, to: 0.4, scale: log}\nparticles: {from: 100, to: 500}\nsensor.model: [beam, gaussian]\n"
    )
    assert space_file.read_space(file) == {
        "sensor.sigma_hit": tuning.Range(0.02, 0.4, log=True),
        "particles": tuning.Range(100, 500),
        "sensor.model": tuning.Choice(("beam", "gaussian")),
    }


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "1: expected settings"),
        ("- a\n", "1: expected settings"),
        ("a: [1, 2\n", ":2: "),
        ("particles: [1, 2]\nsensor.sigma_hot: [1, 2]\n", ":2: .*nearest is 'sensor.sigma_hit'"),
        ("particles: [1, 2]\nparticles: [1, 3]\n", ":2: .*'particles' is there twice"),
        ("particles: 5\n", ":1: particles: expected two values at least"),
        ("particles: [5]\n", ":1: particles: expected two values at least"),
        ("particles: {from: 1, to: b}\n", ":1: particles: expected a number, got b"),
        ("particles: {from: 5, to: 1}\n", ":1: particles: expected more than from, 5, got 1"),
        ("particles: {from: 1, to: 5, steps: 2}\n", ":1: particles: steps make a grid"),
        ("particles: {from: 1, to: 5, scale: ln}\n", "expected linear or log"),
        ("sensor.sigma_hit: {from: 0.1, to: 200}\n", "0.001 to 10"),
    ],
)
def test_a_file_that_is_wrong_is_told_with_its_line(tmp_path, text, said):
    file = tmp_path / "s.yaml"
    file.write_text(text)
    with pytest.raises(parloc.ConfigError, match=said):
        space_file.read_space(file)


# ---- The verdict -------------------------------------------------------------------------------------------------------


def fake(errors, sure=0.0):
    return [tuning.PieceScore(e, e, 0.0, 0.0, sure, 0.0, 3.0) for e in errors]


def test_the_interval_is_students():
    i = mean_interval(np.array([1.0, 2.0, 3.0]))
    assert i.mean == 2 and i.low == pytest.approx(2 - 2.484, abs=1e-3) and i.high == pytest.approx(2 + 2.484, abs=1e-3)
    assert mean_interval(np.array([1.0])).low == -np.inf  # says nothing


def test_noise_is_not_called_better():
    """Two equal settings: the whole interval is above 0 in 2.5 % of all cases. Of 2000, more than 70 would be 3 sigma."""
    rng = np.random.default_rng(5)
    places = [("drive", float(k)) for k in range(10)]
    better = sum(
        verdict.is_better(tuning.Comparison(places, fake(rng.normal(0.1, 0.02, 10)), fake(rng.normal(0.1, 0.02, 10))))
        for _ in range(2000)
    )
    assert 25 < better < 71
    assert verdict.is_better(tuning.Comparison(places, fake(np.full(10, 0.1) + np.arange(10) / 1e3), fake(np.full(10, 0.09))))


def test_more_often_sure_and_wrong_is_not_better():
    places = [("drive", float(k)) for k in range(10)]
    old, new = np.full(10, 0.1) + np.arange(10) / 1e3, np.full(10, 0.05)
    assert not verdict.is_better(tuning.Comparison(places, fake(old), fake(new, sure=0.01)))


# ---- Whole searches ----------------------------------------------------------------------------------------------------


def test_poor_settings_are_found_to_be_poor_on_drives_kept_back(office, tmp_path):
    found = tuning.tune([office], tmp_path, WIDE, POOR, trials=10, jobs=2)
    assert found.better and found.test.gain.low > 0 and found.tried >= 10
    assert found.config.sensor.sigma_hit < 0.4 and found.config.sensor.effective_beams > 2
    assert found.config.particles == 100 and found.config.threads == POOR.threads
    assert "Better: " in tuning.summary(found)


def test_good_settings_stay(office, tmp_path):
    """What hardly matters is not sold as a gain."""
    nothing = {"localize.carried_per_hour": tuning.Range(0.9, 1.1)}
    found = tuning.tune([office], tmp_path, nothing, parloc.Config(particles=100), trials=3, jobs=1)
    assert not found.better and "othing to gain" in tuning.summary(found)
    assert found.config.localize.carried_per_hour == 1


def test_one_job_gives_the_same_again(tmp_path):
    results = [tuning.tune([FACULTY], tmp_path / str(k), WIDE, POOR, trials=3, jobs=1) for k in range(2)]
    assert results[0].found == results[1].found and results[0].test == results[1].test


def test_another_question_does_not_mix_with_the_first(tmp_path):
    tuning.tune([FACULTY], tmp_path, WIDE, POOR, trials=2, jobs=1)
    before = (tmp_path / "journal.log").read_bytes()
    for other in (
        {"seed": 2},
        {"config": parloc.Config(particles=100)},
        {"settings": {"sensor.z_rand": tuning.Range(0.1, 0.2)}},
    ):
        with pytest.raises(parloc.OutputError, match="holds a search with other"):
            tuning.tune(
                **{"drives": [FACULTY], "out": tmp_path, "settings": WIDE, "config": POOR, "trials": 2, "jobs": 1, **other}
            )
    assert (tmp_path / "journal.log").read_bytes() == before


# ---- The command -------------------------------------------------------------------------------------------------------


def tune_command(*words):
    return [sys.executable, "-m", "parloc.tuning", *map(str, words)]


def drive_words(files):
    return ["--log", files.log, "--map", files.map, "--truth", files.truth]


def test_the_command_goes_on_after_a_break_and_a_killed_worker(office, tmp_path):
    config, settings, out = tmp_path / "poor.yaml", tmp_path / "s.yaml", tmp_path / "out"
    config.write_text("particles: 100\nsensor: {sigma_hit: 0.4, effective_beams: 2}\n")
    settings.write_text(
        "sensor.sigma_hit: {from: 0.02, to: 0.4, scale: log}\nsensor.effective_beams: {from: 2, to: 60, scale: log}\n"
    )
    words = [*drive_words(office), "--config", config, "--settings", settings, "--out", out, "--jobs", 2]
    begun = subprocess.Popen(tune_command(*words, "--trials", 500), stderr=subprocess.PIPE, text=True)
    journal = out / "journal.log"
    deadline = time.monotonic() + 60
    while not (journal.exists() and journal.read_text().count('"op_code":7') > 20):
        assert begun.poll() is None and time.monotonic() < deadline
        time.sleep(0.1)
    workers = subprocess.run(["pgrep", "-P", str(begun.pid), "-f", "spawn_main"], capture_output=True, text=True, check=True)
    os.kill(int(workers.stdout.split()[0]), signal.SIGKILL)
    time.sleep(0.5)
    assert begun.poll() is None
    begun.send_signal(signal.SIGINT)
    said = begun.communicate(timeout=60)[1]
    assert begun.returncode == 130 and "goes on from here" in said and "Traceback" not in said
    done = subprocess.run(tune_command(*words, "--trials", 10), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("Better: ")
    told = json.loads((out / "tune.json").read_text())
    assert told["better"] and told["tried"] >= 10 and told["test"]["gain_m"]["low"] > 0
    assert parloc.read_config(out / "tuned.yaml").sensor.sigma_hit == told["settings"]["sensor.sigma_hit"]["found"]
    page = (out / "report.html").read_text()
    assert page.count("<svg") == 2 and told["verdict"] in page


def test_a_map_of_another_place_is_doubted(tmp_path):
    true = parloc.read_map(FACULTY.map)
    parloc.GridMap(true.cells[::-1, ::-1].copy(), true.resolution_m, true.origin).save(tmp_path / "turned.yaml")
    elsewhere = tuning.DriveFiles(FACULTY.log, str(tmp_path / "turned.yaml"), FACULTY.truth)
    found = tuning.tune([elsewhere], tmp_path, WIDE, POOR, trials=1, jobs=1)
    assert "are map and truth those of these drives" in tuning.doubt(found)
    tuning.write_results(found)
    assert tuning.doubt(found) in (tmp_path / "report.html").read_text()


def test_settings_that_never_go_together_are_refused(tmp_path):
    shares = {"sensor.z_short": tuning.Range(0.5, 1.0), "sensor.z_rand": tuning.Range(0.6, 1.0)}
    for jobs in (1, 2):
        with pytest.raises(parloc.ConfigError, match="none of . settings tried can be"):
            tuning.tune([FACULTY], tmp_path, shares, POOR, trials=2, jobs=jobs)


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        ([], 2, "expected --log"),
        (["--map", "m.yaml"], 2, "expected --log before it"),
        (["--log", "a", "--log", "b", "--map", "c", "--map", "d"], 2, "b has one already"),
        (["--log", "absent.log"], 2, "expected --out"),
        (["--log", "absent.log", "--out", "OUT"], 3, "absent.log"),
        (["--log", LOG, "--map", MAP, "--truth", TRUTH, "--out", "OUT"], 3, "expected 4 stretches"),
        (["--log", LOG, "--map", MAP, "--truth", TRUTH, "--out", "/proc/none"], 5, "/proc/none"),
        (["--log", LOG, "--trials", "0", "--out", "OUT"], 2, "expected at least 1"),
        (["--log", LOG, "--jobs", "-1", "--out", "OUT"], 2, "expected at least 1, or 0"),
        (["--log", LOG, "--trials", "many", "--out", "OUT"], 2, "--trials"),
        (["--log", LOG, "--settings", "absent.yaml", "--out", "OUT"], 3, "absent.yaml: cannot be read"),
    ],
)
def test_wrong_words_are_one_line(tmp_path, words, code, said):
    words = [str(tmp_path / "out") if w == "OUT" else w for w in words]
    done = subprocess.run(tune_command(*words), capture_output=True, text=True, check=False)
    assert done.returncode == code and said in done.stderr and len(done.stderr.splitlines()) == 1, done.stderr


def test_help_fits_a_screen():
    text = subprocess.run(tune_command("--help"), capture_output=True, text=True, check=True).stdout
    assert len(text.splitlines()) <= 24 and max(map(len, text.splitlines())) <= 80
