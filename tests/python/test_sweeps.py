"""Sweeps on this machine: they give what one run would have given, go on, and say what cannot be computed."""

import csv
import threading

import pytest
from conftest import LOG, MAP, TRUTH
from sweep_here import SLOW, Killer, expect_equal_to_one_run, write_sweep

import parloc

pytest.importorskip("yaml")


def test_a_sweep_gives_a_table_a_page_and_goes_on(tmp_path):
    plan, told = write_sweep(tmp_path), []
    result = parloc.sweep(plan, out=tmp_path / "out", jobs=2, parts=2, progress=lambda *now: told.append(now))
    assert told[0] == (0, 6) and told[-1] == (6, 6) and not result.failed and not result.missing
    assert len(result.table) == 6 and [row["particles"] for row in result.table] == [50] * 3 + [100] * 3
    row = result.table[0]
    assert (row["point"], row["source"], row["seed"], row["success"]) == (1, "paz2012", 1, True) and 0 < row["error_m"] < 0.3
    rows = list(csv.DictReader((tmp_path / "out" / "table.csv").read_text().splitlines()))
    assert [float(r["error_m"]) for r in rows] == result.table.columns["error_m"] and rows[0]["success"] == "true"
    page = result.page.read_text()
    assert "<svg" in page and "particles" in page and "<script" not in page and "src=" not in page
    expect_equal_to_one_run(tmp_path / "out")

    # Again: nothing is computed, and the results are the same.
    files = {f: f.stat().st_mtime_ns for f in (tmp_path / "out").glob("runs/*/parts/*/shard.parloc")}
    again = parloc.sweep(plan, out=tmp_path / "out")
    assert again.table.columns == result.table.columns and all(f.stat().st_mtime_ns == t for f, t in files.items())

    # Something else does not come into the same folder.
    write_sweep(tmp_path, trials=4)
    with pytest.raises(parloc.InputError, match=r"holds another sweep.*sweep.yaml:3 is 'trials: 3' there, 'trials: 4' here"):
        parloc.sweep(plan, out=tmp_path / "out")
    write_sweep(tmp_path)
    with pytest.raises(parloc.UsageError, match="was begun with 2 parts per run"):
        parloc.sweep(plan, out=tmp_path / "out", parts=3)


def test_filters_have_rows_of_their_own(tmp_path):
    (tmp_path / "s.yaml").write_text(f"logs: {{log: {LOG}, map: {MAP}, truth: {TRUTH}}}\nfilters: mcl@100,ekf\ntrials: 2\n"
                                     "settings:\n  motion.alpha1: [0.1, 0.2]\n")
    table = parloc.sweep(tmp_path / "s.yaml", out=tmp_path / "out", jobs=2).table
    trials = [(1, "mcl@100", 1), (1, "mcl@100", 2), (1, "ekf", 1), (1, "ekf", 2)]
    first = table[0]
    assert [(r["point"], r["filter"], r["seed"]) for r in table[:4]] == trials and len(table) == 8
    assert first["success"] == (not first["lost"]) and first["error_m"] == first["position_rmse_m"]
    expect_equal_to_one_run(tmp_path / "out")


def test_a_part_that_is_killed_costs_its_trial_and_nothing_else(tmp_path):
    killer = Killer(tmp_path / "out")
    result = parloc.sweep(write_sweep(tmp_path, **SLOW), out=tmp_path / "out", jobs=2, parts=2, progress=killer)
    killer.expect_that_all_was_kept()
    assert len(result.table) == 8 and not result.failed
    expect_equal_to_one_run(tmp_path / "out")


def test_a_part_that_cannot_be_computed_is_named_and_all_else_stays(tmp_path):
    plan = write_sweep(tmp_path)
    parloc.sweep(plan, out=tmp_path / "out", parts=1)
    (tmp_path / "out" / "runs" / "0002" / "parts" / "1" / "shard.parloc").write_bytes(b"something else")
    again = parloc.sweep(plan, out=tmp_path / "out")
    (failed,) = again.failed
    assert (failed.code, failed.run, failed.part) == (3, 2, 2) and "expected the results of a shard" in failed.said
    assert again.missing == 1 and again.table.columns["point"] == [1, 1, 1]
    assert "expected the results of a shard" in again.page.read_text()


def test_two_sweeps_in_one_folder_are_refused(tmp_path):
    plan, told, errors = write_sweep(tmp_path), threading.Event(), []

    def second(done, of):
        if not told.is_set():
            told.set()
            with pytest.raises(parloc.OutputError, match="another parloc sweep is at work here") as error:
                parloc.sweep(plan, out=tmp_path / "out")
            errors.append(error)

    parloc.sweep(plan, out=tmp_path / "out", progress=second)
    assert errors
