"""One run of `parloc run`: its track, and the errors against the truth."""

import bisect
import json
import math
import shutil

from measuring import Failure
from poses import wrap

MAX_TRUTH_GAP_S = 1.5  # as parloc itself interpolates
FILTER_ALONE = "localize: {health: false}\n"  # of a configuration: no search helps the filter


def read_tum(path):
    """[(stamp [s], x [m], y [m], heading [rad])] in file order."""
    rows = []
    for number, line in enumerate(open(path), 1):
        if line.startswith("#") or not line.strip():
            continue
        try:
            stamp, x, y, _, _, _, qz, qw = map(float, line.split())
        except ValueError:
            raise Failure(2, f"{path}:{number}: expected 8 numbers: timestamp x y z qx qy qz qw")
        rows.append((stamp, x, y, 2 * math.atan2(qz, qw)))
    return rows


class Truth:
    """The true pose and yaw rate at any stamp, by the rule of `parloc run`: the row of that stamp, else interpolated."""

    def __init__(self, rows):
        self.exact = {}
        for row in rows:
            self.exact.setdefault(round(row[0] * 1e6), row)
        self.rows = sorted(rows, key=lambda row: row[0])
        self.stamps = [row[0] for row in self.rows]

    def _around(self, stamp_s):
        after = bisect.bisect_right(self.stamps, stamp_s)
        if not 0 < after < len(self.rows):
            return None
        a, b = self.rows[after - 1], self.rows[after]
        return (a, b) if 0 < b[0] - a[0] <= MAX_TRUTH_GAP_S else None

    def pose(self, stamp_s):
        row = self.exact.get(round(stamp_s * 1e6))
        if row:
            return row[1:]
        if not (around := self._around(stamp_s)):
            return None
        a, b = around
        u = (stamp_s - a[0]) / (b[0] - a[0])
        return a[1] + u * (b[1] - a[1]), a[2] + u * (b[2] - a[2]), a[3] + u * wrap(b[3] - a[3])

    def yaw_rate(self, stamp_s):
        """[rad/s] between the two rows around the stamp, None where there are none."""
        if not (around := self._around(stamp_s)):
            return None
        a, b = around
        return wrap(b[3] - a[3]) / (b[0] - a[0])


def pose_errors(trajectory, truth):
    """[(stamp [s], position error [m], heading error [rad])] of the poses that have a truth."""
    errors = []
    for stamp, x, y, heading in trajectory:
        if true := truth.pose(stamp):
            errors.append((stamp, math.hypot(x - true[0], y - true[1]), wrap(heading - true[2])))
    return errors


def rms(values):
    return math.sqrt(sum(v * v for v in values) / len(values)) if values else math.nan


def localize(program, work, name, arguments):
    """The metrics of one run, its pose errors, and the truth."""
    out = work / name
    try:
        metrics = json.loads(program("run", *arguments, "--threads", 1, "--json", "--quiet", "--out", out))
        trajectory = read_tum(out / "trajectory.tum")
    finally:
        shutil.rmtree(out, ignore_errors=True)
    truth = Truth(read_tum(arguments[arguments.index("--truth") + 1]))
    errors = pose_errors(trajectory, truth)
    mean_m = sum(e[1] for e in errors) / max(1, len(errors))
    # Two programs, one answer; files have 6 decimals.
    if len(errors) != metrics["compared_with_truth"] or abs(mean_m - metrics["position_mae_m"]) > 5e-6:
        raise Failure(3, f"{name}: parloc says {metrics['position_mae_m']} m over {metrics['compared_with_truth']} scans, "
                         f"its trajectory says {mean_m} m over {len(errors)}")
    return metrics, errors, truth


def common_values(metrics):
    return {"mean_m": metrics["position_mae_m"], "rmse_m": metrics["position_rmse_m"], "max_m": metrics["position_max_m"],
            "heading_rmse_deg": math.degrees(metrics["heading_rmse_rad"]), "scans": metrics["scans"],
            "digest": metrics["digest"]}
