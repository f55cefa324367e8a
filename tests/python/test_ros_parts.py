"""The parts of the ROS 2 nodes that need no ROS."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools" / "ros"))
from parloc_ros.delay import Delay
from parloc_ros.pose_file import PoseFile


def test_a_scan_is_late_beside_the_promptest():
    delay = Delay()
    assert delay.of(received_s=100.0, stamp_s=5.0) == 0.0  # another clock is no delay
    assert delay.of(100.5, 5.1) == pytest.approx(0.4)
    assert delay.of(101.0, 7.0) == 0.0  # played faster than it was recorded
    assert delay.of(101.5, 7.0) == pytest.approx(0.5)
    assert delay.of(200.0, 7.0) == 0.0  # a minute later nobody remembers the promptest


def test_a_clock_is_set_back_by_more_than_a_straggler():
    delay = Delay()
    assert [delay.is_set_back(stamp_s) for stamp_s in (10.0, 10.1, 9.9, 9.0, 9.2, 3.0, 3.1)] == [
        False, False, False, True, False, True, False]  # fmt: skip


def test_a_pose_is_kept_for_its_map(tmp_path):
    kept = PoseFile(str(tmp_path / "sub" / "pose.json"), "/amcl")
    assert kept.read("a map") == (None, "")
    kept.write("a map", (1.0, 2.0, 0.5), (0.1, 0.1, 0.05))
    assert kept.read("a map") == (([1.0, 2.0, 0.5], [0.1, 0.1, 0.05]), "")
    pose, why = kept.read("another map")
    assert pose is None and "another map" in why
    assert [path.name for path in kept.path.parent.iterdir()] == ["pose.json"]


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"map": "m", "pose": [1, 2], "sigma": [0, 0, 0]}', '{"pose": 1}',
                                  '{"map": "m", "pose": [1, 2, NaN], "sigma": [0, 0, 0]}', "\x00"])  # fmt: skip
def test_a_file_that_is_no_pose_is_told(tmp_path, text):
    path = tmp_path / "pose.json"
    path.write_text(text)
    pose, why = PoseFile(str(path), "amcl").read("m")
    assert pose is None and str(path) in why
