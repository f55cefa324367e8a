"""Simulated drives, and runs of `parloc run` with their errors against the truth."""

import json
import math
import re
import shutil

from logs import Truth, read_tum
from measuring import ROOT, Failure
from poses import wrap


def yaml_text(settings, indent=""):
    """Of a configuration or a scenario; a group without settings is left out."""
    text = ""
    for key, value in settings.items():
        if isinstance(value, dict):
            text += f"{indent}{key}:\n{yaml_text(value, indent + '  ')}" if value else ""
        else:
            text += f"{indent}{key}: {str(value).lower() if isinstance(value, bool) else value}\n"
    return text


def scenario_with(path, lidar):
    """The text of a shipped scenario with these settings of its LiDAR, and file names that hold from anywhere."""
    text, home = (ROOT / path).read_text(), (ROOT / path).parent
    text = re.sub(rf"^  ({'|'.join(lidar)}):.*\n", "", text, flags=re.MULTILINE)
    text = re.sub(r"^lidar:.*\n", lambda line: line[0] + yaml_text(lidar, "  "), text, flags=re.MULTILINE)
    return re.sub(r"^(map|localization_map|path): *(?=\.\./)", rf"\1: {home}/", text, flags=re.MULTILINE)


def simulate(bench, scenario, seed, name, lidar=None):
    """The folder NAME with a log and its truth, and the program's words. Without a seed, that of the scenario; `lidar` are
    settings in place of its own."""
    out = bench.folder / name
    seeded = [] if seed is None else ["--seed", seed]
    if lidar:
        changed = out.with_name(f"{name}.scenario.yaml")
        changed.write_text(scenario_with(scenario, lidar))
        scenario = changed
    return out, bench.program("simulate", "--scenario", scenario, *seeded, "--out", out)


def report_of(bench, command, name, arguments):
    """What `parloc COMMAND` writes into the folder NAME (COMMAND.json), in which no folder of this machine is named."""
    out = bench.folder / name
    bench.program(command, "--quiet", "--out", out, *arguments)
    text = (out / f"{command}.json").read_text()
    for folder, name_of in ((str(bench.args.data), "$PARLOC_DATA"), (f"{ROOT}/", ""), (f"{bench.folder}/", "")):
        text = text.replace(folder, name_of)
    return json.loads(text)


def files_of(grid, folder):
    """Options for a simulated log on a map."""
    return ["--map", grid, "--log", folder / "scans.log", "--truth", folder / "truth.tum"]


def pose_errors(trajectory, truth):
    """[(stamp [s], position error [m], heading error [rad])] of the poses that have a truth."""
    errors = []
    for stamp, x, y, heading in trajectory:
        if true := truth.pose(stamp):
            errors.append((stamp, math.hypot(x - true[0], y - true[1]), wrap(heading - true[2])))
    return errors


def rms(values):
    return math.sqrt(sum(v * v for v in values) / len(values)) if values else math.nan


def localize(bench, name, seed, arguments, config=None):
    """The metrics of one run, its pose errors, and the truth. `config` is the text of a configuration, with which no search
    helps the filter."""
    out = bench.folder / "".join(letter for letter in name.replace(" ", "_") if letter not in ",/")
    if config is not None:
        path = out.with_name(f"{out.name}.yaml")
        path.write_text(config + yaml_text({"localize": {"health": False}}))
        arguments = [*arguments, "--config", path]
    try:
        metrics = json.loads(bench.program("run", *arguments, "--seed", seed, "--threads", 1, "--json", "--quiet", "--out",
                                           out))
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
