"""What other packages take: evo, pandas, matplotlib, rich. They are imported only when they are asked for."""

import subprocess
import sys

import numpy as np
import pytest
from conftest import LOG, TRUTH

import parloc


@pytest.fixture(scope="module")
def track(corridor, start):
    return parloc.Localizer(corridor, parloc.Config(particles=80)).run(LOG, start=start)


def test_none_is_imported_before():
    code = "import sys, parloc; print([m for m in ('matplotlib', 'pandas', 'evo', 'rich') if m in sys.modules])"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.strip() == "[]"


def test_pandas(track):
    pytest.importorskip("pandas")
    table = track.to_pandas()
    assert list(table.columns[:4]) == ["stamp_s", "x_m", "y_m", "theta_rad"] and len(table) == len(track)
    assert (table["sigma_x_m"] > 0).all() and set(table["state"]) == set(track.states)
    assert parloc.to_pandas(track.trajectory)["x_m"].tolist() == table["x_m"].tolist()


def test_evo(track):
    pytest.importorskip("evo")
    path = track.to_evo()
    assert path.num_poses == len(track) and np.allclose(path.positions_xyz[:, :2], track.poses[:, :2])
    assert np.allclose(path.get_orientations_euler()[:, 2], track.poses[:, 2])


def test_pictures(track, corridor, start, tmp_path):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    ax = track.plot(truth=parloc.read_trajectory(TRUTH))
    drawn = [line.get_label() for line in ax.lines]
    assert drawn == ["truth", "estimate"] and np.allclose(ax.lines[1].get_xdata(), track.poses[:, 0])
    assert ax.get_xlim()[1] - ax.get_xlim()[0] == pytest.approx(corridor.width * corridor.resolution_m)
    localizer = parloc.Localizer(corridor, parloc.Config(particles=80))
    localizer.start_at(start)
    localizer.step(next(iter(parloc.open_log(LOG))))
    assert len(localizer.plot(most=50, ax=plt.figure().gca()).collections[0].get_offsets()) == 50
    slam = parloc.make_map(LOG, parloc.Config(slam={"particles": 2}))
    assert len(slam.plot(plt.figure().gca()).lines) == 1
    plt.savefig(tmp_path / "map.png")


def test_rich(corridor, start):
    pytest.importorskip("rich")
    localizer = parloc.Localizer(corridor, parloc.Config(particles=80))
    assert len(localizer.run(LOG, start=start, progress=True)) == 37
