#!/usr/bin/env python3
"""Measures `parloc learn --what mount,odometry,delay` on simulated drives with known mounts, scales and delays.

    tools/studies/calibration.py --parloc build/cpu/parloc [--drive office] [--view 10Hz] [--seeds 1] [--noise 1]

Prints a row per drive (error and stated standard deviation), how many keep the bars, and how often errors are within
one and two standard deviations. The log's mount is overruled by zeros, so that nothing of it can help.
"""

import argparse
import json
import math
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DRIVES = {  # map, path
    "office": ("maps/fine/office.yaml", "maps/paths/office_tour.yaml"),
    "hall": ("maps/fine/hall_obstacles.yaml", "maps/paths/hall_spins.yaml"),
    "works": ("maps/fine/works.yaml", "maps/paths/works_tour.yaml"),
}
VIEWS = {  # scans/s, odometry/s, beams, first beam and step [degrees], range [m], time of a scan [s]
    "40Hz": (40, 40, 1081, -135.0, 0.25, 30.0, 0.0),
    "10Hz": (10, 20, 360, -180.0, 1.0, 12.0, 0.0),
    "5Hz": (5, 20, 360, -180.0, 1.0, 3.5, 0.0),
    "5Hz_slow": (5, 20, 360, -180.0, 1.0, 3.5, 0.2),  # every beam from where the robot was then
    "10Hz_half": (10, 10, 541, -90.0, 1 / 3, 20.0, 0.0),
    "1Hz": (1, 20, 360, -180.0, 1.0, 12.0, 0.0),
}
MOUNTS = {  # x, y [m], yaw [degrees], upside down
    "forward": (0.2, 0.0, 0.0, False),
    "half turn": (-0.1, 0.0, 180.0, False),
    "left": (0.1, 0.15, 90.0, False),
    "upside down": (0.15, -0.05, 20.0, True),
    "beside": (0.0, -0.3, -30.0, False),
}
ODOMETRY = [(1.0, 1.0, 0.0), (0.9, 1.1, 0.05), (1.1, 0.95, 0.2), (1.03, 0.9, 0.1), (0.97, 1.04, 0.15)]  # drive, turn, delay
BARS = {"x": 0.01, "y": 0.01, "yaw": math.radians(0.5), "drive": 0.005, "turn": 0.005, "delay": 0.01}
SHOWN = {"x": (100, "cm"), "y": (100, "cm"), "yaw": (180 / math.pi, "deg"), "drive": (100, "%"), "turn": (100, "%"),
         "delay": (1000, "ms")}


def scenario(drive, view, mount, odometry, seed, noise):
    rate, odometry_rate, beams, first, step, reach, scan_time = VIEWS[view]
    map_file, path = DRIVES[drive]
    x, y, yaw, upside_down = MOUNTS[mount]
    drive_scale, turn_scale, delay = odometry
    return f"""map: {ROOT / map_file}
path: {ROOT / path}
seed: {seed}
scan_rate: {rate}
lidar: {{beams: {beams}, angle_min_deg: {first}, angle_step_deg: {step}, range_min: 0.05, range_max: {reach},
  sigma_range: 0.02, dropout_probability: 0.02, mount: [{x}, {y}, {yaw}], upside_down: {str(upside_down).lower()},
  scan_time: {scan_time}}}
odometry: {{rate: {odometry_rate}, form: seed, alpha1: {0.1 * noise}, alpha2: {0.05 * noise},
  alpha3: {0.1 * noise}, alpha4: {0.02 * noise},
  scale_translation: {drive_scale}, scale_rotation: {turn_scale}, delay: {delay}}}
"""


def learn(parloc, folder, text, scan_time):
    (folder / "s.yaml").write_text(text)
    subprocess.run([parloc, "simulate", "--scenario", folder / "s.yaml", "--out", folder / "log", "--quiet"], check=True,
                   capture_output=True)
    (folder / "c.yaml").write_text(
        f"lidars:\n  robotlaser1: {{x: 0, y: 0, yaw: 0, upside_down: false, scan_time: {scan_time}}}\n")
    done = subprocess.run([parloc, "learn", "--log", folder / "log/scans.log", "--what", "mount,odometry,delay", "--config",
                           folder / "c.yaml", "--out", folder / "out", "--quiet", "--json"], check=True, capture_output=True)
    return json.loads(done.stdout)


def compare(found, mount, odometry):
    """By name: error, standard deviation, and whether it is determined."""
    x, y, yaw, _ = MOUNTS[mount]
    lidar, wheels = found["lidars"][0], found["odometry"]
    rows = {"x": (lidar["x"], x), "y": (lidar["y"], y), "yaw": (lidar["yaw"], math.radians(yaw)),
            "drive": (wheels["odometry_scale_drive"], 1 / odometry[0]),
            "turn": (wheels["odometry_scale_turn"], 1 / odometry[1]),
            "delay": (wheels["odometry_delay_s"], odometry[2])}
    result = {}
    for name, (one, truth) in rows.items():
        error = math.nan if one["value"] is None else one["value"] - truth
        result[name] = (math.remainder(error, 2 * math.pi) if name == "yaw" and one["determined"] else error, one["sigma"],
                        one["determined"])
    return result


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--parloc", default=str(ROOT / "build/cpu/parloc"))
    parser.add_argument("--drive", default="office", choices=[*DRIVES, "all"])
    parser.add_argument("--view", default="all", choices=[*VIEWS, "all"])
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--noise", type=float, default=1.0, help="of the odometry")
    options = parser.parse_args()
    errors, kept, rows = {name: [] for name in BARS}, 0, 0
    print("| drive | view | mount | " + " | ".join(f"{n} [{SHOWN[n][1]}]" for n in BARS) + " | bars |")
    print("|---" * (len(BARS) + 4) + "|")
    for drive in DRIVES if options.drive == "all" else [options.drive]:
        for number, view in enumerate(VIEWS):
            for place, mount in enumerate(MOUNTS):
                for seed in range(options.seeds):
                    if options.view not in ("all", view):
                        continue
                    odometry = ODOMETRY[(number + place) % len(ODOMETRY)]
                    text = scenario(drive, view, mount, odometry, 1000 * seed + 10 * number + place + 1, options.noise)
                    with tempfile.TemporaryDirectory() as folder:
                        found = learn(options.parloc, Path(folder), text, VIEWS[view][6])
                    result = compare(found, mount, odometry)
                    keeps = found["lidars"][0]["upside_down"]["value"] == MOUNTS[mount][3] and all(
                        sure and abs(error) <= BARS[name] for name, (error, _, sure) in result.items())
                    rows, kept = rows + 1, kept + keeps
                    cells = []
                    for name, (error, sigma, sure) in result.items():
                        unit = SHOWN[name][0]
                        cells.append(f"{error * unit:+.2f} ({sigma * unit:.2f})" if sure else "open")
                        if sure:
                            errors[name].append(abs(error) / sigma)
                    cells = [drive, view, mount, *cells, "kept" if keeps else "not"]
                    print("| " + " | ".join(cells) + " |", flush=True)
    print(f"\n{kept} of {rows} keep all bars")
    for name, ratios in errors.items():
        within = [sum(r <= most for r in ratios) for most in (1, 2)]
        print(f"{name}: within one standard deviation {within[0]}, two {within[1]}, of {len(ratios)}")


if __name__ == "__main__":
    main()
