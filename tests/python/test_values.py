"""Maps, scans, poses and trajectories: to and from numpy, and what is refused."""

import pickle

import numpy as np
import pytest
from conftest import LOG, TRUTH

import parloc


def test_map_cells_are_a_view(corridor):
    assert corridor.cells.shape == (corridor.height, corridor.width) and corridor.cells.dtype == np.uint8
    assert np.shares_memory(corridor.cells, corridor.cells)
    cells = np.zeros((3, 4), np.uint8)
    cells[1, 2] = 1
    grid = parloc.GridMap(cells, 0.05, origin=(1, 2, 0.3))
    cells[:] = 2  # the map has its own
    assert grid.cells[1, 2] == 1 and grid.cells.sum() == 1
    view = grid.cells
    view[0, 0] = 2
    del grid
    assert view[0, 0] == 2 and view[1, 2] == 1  # the view keeps the map


def test_map_is_written_and_read(tmp_path):
    grid = parloc.GridMap(np.array([[0, 1, 2], [2, 1, 0]], np.uint8), 0.1, (1.0, -2.0, 0.5))
    grid.save(tmp_path / "m.yaml")
    again = parloc.read_map(str(tmp_path / "m.yaml"))
    assert (again.cells == grid.cells).all() and again.origin == grid.origin and again.resolution_m == 0.1


@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        (lambda: parloc.GridMap(np.zeros((3, 4)), 0.1), TypeError, "cells: expected uint8 of shape .*got ndarray of float64"),
        (lambda: parloc.GridMap(np.zeros(3, np.uint8), 0.1), TypeError, r"cells: .*shape \(3,\)"),
        (lambda: parloc.GridMap(np.zeros((0, 4), np.uint8), 0.1), parloc.InputError, "cells: expected 1 to 32767 rows"),
        (lambda: parloc.GridMap(np.full((3, 4), 7, np.uint8), 0.1), ValueError, r"got 7 at \[0, 0\]"),
        (lambda: parloc.GridMap(np.zeros((3, 4), np.uint8), 0.0), parloc.InputError, "resolution_m: expected above 0"),
        (lambda: parloc.GridMap(np.zeros((3, 4), np.uint8), 1, (0, np.nan, 0)), parloc.InputError, "origin: expected finite"),
        (lambda: parloc.read_map("nothing.yaml"), parloc.InputError, "nothing.yaml: cannot be opened"),
        (lambda: parloc.Scan("abc"), TypeError, "ranges_m: expected numbers in one dimension, got str"),
        (lambda: parloc.Scan(np.zeros((2, 2))), TypeError, r"ranges_m: .*shape \(2, 2\)"),
        (lambda: parloc.Scan([1, 2], bearings_rad=[0]), parloc.InputError, "bearings_rad: expected one per range, 2, got 1"),
        (lambda: parloc.open_log("nothing.log"), parloc.InputError, "nothing.log: cannot be opened"),
        (lambda: parloc.open_log(LOG, scan_topc="a"), parloc.ConfigError, "the nearest is 'scan_topic'"),
        (lambda: parloc.read_trajectory(LOG.parent / "README.md"), parloc.InputError, "README.md"),
        (lambda: parloc.compare_trajectories([[1, 2]], [[1, 2, 3, 4]]), TypeError, "estimate: expected rows of"),
        (lambda: parloc.Pose((1, 2)), TypeError, "incompatible"),
    ],
)
def test_refusals(make, error, words):
    with pytest.raises(error, match=words) as caught:
        make()
    if isinstance(caught.value, parloc.Error):
        assert "\n" not in str(caught.value)


def test_errors_know_their_kind():
    with pytest.raises(parloc.InputError) as caught:
        parloc.read_map("nothing.yaml")
    assert (caught.value.kind, caught.value.exit_code) == ("input", 3) and isinstance(caught.value, ValueError)
    with pytest.raises(OSError, match="cannot") as caught:
        parloc.write_trajectory("/nothing/t.tum", np.zeros((1, 4)))
    assert (caught.value.kind, caught.value.exit_code) == ("output", 5) and isinstance(caught.value, parloc.Error)
    assert issubclass(parloc.BackendError, RuntimeError) and parloc.BackendError.exit_code == 6


@pytest.mark.parametrize("as_type", [np.float32, np.float64, list])
def test_scan(as_type):
    ranges = [1.0, 2.5, float("inf"), 0.0]
    given = list(ranges) if as_type is list else np.array(ranges, as_type)
    scan = parloc.Scan(given, -0.5, 0.25, stamp_s=3.5, sensor="front", T_base_sensor=(0.1, 0, 0), range_max_m=30)
    assert scan.ranges_m.dtype == np.float32 and scan.ranges_m.tolist() == ranges and len(scan) == 4
    assert (scan.angle_min_rad, scan.angle_step_rad, scan.stamp_s, scan.sensor) == (-0.5, 0.25, 3.5, "front")
    assert scan.T_base_sensor == parloc.Pose(0.1) and scan.range_max_m == 30 and len(scan.bearings_rad) == 0
    view = scan.ranges_m
    del scan
    assert view[1] == 2.5


def test_scan_of_every_other_beam():
    assert parloc.Scan(np.arange(10, dtype=np.float32)[::2]).ranges_m.tolist() == [0, 2, 4, 6, 8]


def test_pose():
    pose = parloc.Pose(1, 2, 0.5)
    assert tuple(pose) == (1, 2, 0.5) and pose == parloc.Pose(np.array([1, 2, 0.5])) and pose[-1] == 0.5
    assert np.asarray(pose).tolist() == [1, 2, 0.5]
    assert np.allclose(pose @ pose.inverse(), 0)
    assert pickle.loads(pickle.dumps(pose)) == pose
    assert pose != 3 and pose != (1, 2, 0.5)
    with pytest.raises(TypeError):
        hash(pose)


def test_trajectories(tmp_path):
    truth = parloc.read_trajectory(TRUTH)
    assert truth.dtype == np.float64 and truth.shape[1] == 4
    parloc.write_trajectory(tmp_path / "t.tum", truth)
    assert np.allclose(parloc.read_trajectory(tmp_path / "t.tum"), truth, atol=1e-6)
    moved = truth + [0, 0.3, 0.4, 0]
    errors = parloc.compare_trajectories(moved, truth)
    assert errors.compared == len(truth) and errors.position_rmse_m == pytest.approx(0.5)
    assert errors.x_error_m == pytest.approx(np.full(len(truth), 0.3))
    between = parloc.poses_at(truth, [truth[0, 0], truth[-1, 0] + 100])
    assert np.allclose(between[0], truth[0, 1:]) and np.isnan(between[1]).all()
