#!/usr/bin/env python3
"""Exports the two real logs in maps/ and their maps from Debian's mrpt-common package. Run once; not part of the build.

    sudo apt-get install mrpt-common python3-numpy python3-scipy
    /usr/bin/python3 tools/studies/export_mrpt.py --out maps

Input: /usr/share/mrpt/datasets (MRPT's own binary objects, possibly gzip).
Output: malaga_{corridor,faculty}.{yaml,pgm} and logs/malaga_{corridor,faculty}.{log.gz,tum} under --out.
maps/logs/README.md says what they are and how good they are. The same input gives the same output.
"""

import argparse
import gzip
import math
import pathlib
from dataclasses import replace
from itertools import pairwise

import numpy as np
from grids import FREE, OCCUPIED, UNKNOWN, grid_of, write_map
from logs import Scan
from measuring import ROOT
from mrpt_objects import RangeScan, Stream
from poses import compose, relative, wrap
from scipy.ndimage import distance_transform_edt
from scipy.spatial import cKDTree

DATASETS = pathlib.Path("/usr/share/mrpt/datasets")
RESOLUTION_M = 0.05
MAP_RANGE_M = 30.0  # beyond it, beams half a degree apart are too sparse for 5 cm cells
NO_RETURN_M = 80.0  # the recordings' maximum; codes for "no return" are 81.83 to 81.91


# ---- the recordings ----------------------------------------------------------------------------------------------------


def transform(pose, points):
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.asarray(pose)[:2] + points @ np.array([[c, s], [-s, c]])


def points_of(scan, max_range_m=MAP_RANGE_M):
    """Reflections in the frame of the base, n x 2."""
    bearing = scan.angle_min_rad + scan.angle_step_rad * np.arange(len(scan.ranges_m))
    keep = (scan.ranges_m > 0.05) & (scan.ranges_m < max_range_m)
    r, a = scan.ranges_m[keep], bearing[keep]
    return transform(scan.T_base_sensor, np.stack([r * np.cos(a), r * np.sin(a)], 1))


def planar(pose):
    """x, y and heading of a pose that has them first and last."""
    return *pose[:2], pose[-1]


def scan_of(scan, T_odom_base=None):
    expected = scan.to_left == 1 and len(scan.ranges_m) == 361 and abs(scan.aperture_rad - np.pi) <= 1e-6
    if not expected or scan.range_max_m != NO_RETURN_M:
        raise ValueError("expected 361 beams over 180 degrees from right to left, 80 m")
    return Scan((scan.ticks - 116444736000000000) / 1e7, np.array(scan.ranges_m), -np.pi / 2, np.pi / 360, NO_RETURN_M,
                planar(scan.pose), T_odom_base)


def read_rawlog(path):
    """Scans, their odometry from the increments between them; the first is at the origin."""
    scans, pose = [], (0.0, 0.0, 0.0)
    for entry in Stream(path.read_bytes()).objects():
        if isinstance(entry[0], RangeScan):
            scans.append(scan_of(entry[0], pose))
        elif scans:  # an increment before the first scan moves nothing that is in the log
            pose = compose(pose, entry[0].delta)
    return scans


# ---- alignment: point to line, Huber's weights -------------------------------------------------------------------------


def normals_of(points):
    """Unit normal at each point from its neighbours in the scan, and whether they lie on a line."""
    normals = np.zeros_like(points)
    good = np.zeros(len(points), bool)
    for i in range(2, len(points) - 2):
        near = points[i - 2:i + 3]
        if np.abs(np.diff(near, axis=0)).max() > 0.5:
            continue
        value, vector = np.linalg.eigh(np.cov(near.T))
        normals[i] = vector[:, 0]
        good[i] = value[0] < 0.02 * value[1] or value[0] < 0.01**2
    return normals, good


def huber(residual_m, width_m=0.03):
    return np.minimum(1.0, width_m / np.maximum(np.abs(residual_m), 1e-9))


def jacobian(pose, world, normals):
    """d(residual) / d(x, y, theta) of points that move with the pose."""
    d = world - pose[:2]
    return np.column_stack([normals, normals[:, 1] * d[:, 0] - normals[:, 0] * d[:, 1]])


class Cloud:
    """Points with normals, to be aligned to."""

    def __init__(self, points, normals):
        self.points, self.normals, self.tree = points, normals, cKDTree(points)

    def match(self, world, reach_m):
        distance, index = self.tree.query(world, distance_upper_bound=reach_m)
        found = np.isfinite(distance)
        normals = self.normals[index[found]]
        return found, np.sum((world[found] - self.points[index[found]]) * normals, 1), normals

    def placed(self, pose):
        return Cloud(transform(pose, self.points), transform((0, 0, pose[2]), self.normals))


def lines_of(scan):
    """The points of a scan, in the frame of the base, that lie on a line."""
    points = points_of(scan)
    normals, good = normals_of(points)
    return Cloud(points[good], normals[good])


def refine_keyframes(poses, scans, sweeps=30):
    """All key-frame poses at once: every scan to the lines of every other that it overlaps, and a weak pull (10 cm,
    1 degree) to where MRPT's own mapping put it. The first stays. Returns poses and the mean residual before, after."""
    local = [points_of(scan) for scan in scans]
    lines = [lines_of(scan) for scan in scans]
    poses = poses.copy()
    given = poses.copy()
    residuals = []
    for sweep in range(sweeps):
        reach_m = max(0.10, 0.30 - 0.02 * sweep)
        world = [transform(p, q) for p, q in zip(poses, local, strict=True)]
        clouds = [cloud.placed(pose) for pose, cloud in zip(poses, lines, strict=True)]
        hessian, gradient = np.zeros((len(poses), 3, len(poses), 3)), np.zeros((len(poses), 3))
        total, count = 0.0, 0
        for i in range(len(poses)):
            for j in range(len(poses)):
                if i == j or np.linalg.norm(poses[i][:2] - poses[j][:2]) > 15.0:
                    continue
                found, r, n = clouds[j].match(world[i], reach_m)
                if len(r) < 40:
                    continue
                # A pair counts once, however many points it shares, up to 50: neighbours must not outvote a closed loop.
                w = huber(r) / 0.03**2 * min(1.0, 50 / len(r))
                Ji, Jj = jacobian(poses[i], world[i][found], n), -jacobian(poses[j], world[i][found], n)
                for a, Ja in ((i, Ji), (j, Jj)):
                    gradient[a] += Ja.T @ (w * r)
                    for b, Jb in ((i, Ji), (j, Jj)):
                        hessian[a, :, b] += Ja.T @ (w[:, None] * Jb)
                total, count = total + np.abs(r).sum(), count + len(r)
        residuals.append(total / count)
        pull = np.diag([1 / 0.1**2, 1 / 0.1**2, 1 / np.radians(1.0) ** 2])
        for i in range(len(poses)):
            strength = pull if i else 1e6 * pull
            d = poses[i] - given[i]
            hessian[i, :, i] += strength
            gradient[i] += strength @ np.append(d[:2], wrap(d[2]))
        step = np.linalg.solve(hessian.reshape(gradient.size, -1), -gradient.ravel()).reshape(-1, 3)
        poses += step
        poses[:, 2] = wrap(poses[:, 2])
        if np.abs(step).max() < 1e-5 and reach_m == 0.10:
            break
    return poses, residuals[0], residuals[-1]


def cloud_of_map(poses, scans):
    placed = [lines_of(scan).placed(pose) for pose, scan in zip(poses, scans, strict=True)]
    return Cloud(np.concatenate([cloud.points for cloud in placed]), np.concatenate([cloud.normals for cloud in placed]))


def align(cloud, scan, guess, pull_m=0.2, pull_deg=3.0, reaches_m=(0.6, 0.4, 0.3, 0.2, 0.15, 0.15, 0.15)):
    """The pose of the base that lays the scan on the map, from a guess that pulls weakly. Returns pose, share of the
    points within 15 cm of a line of the map, and their mean residual."""
    local = points_of(scan)
    pose = guess.copy()
    prior = np.diag([1 / pull_m**2, 1 / pull_m**2, 1 / np.radians(pull_deg) ** 2])
    for reach_m in reaches_m:
        for _ in range(8):
            world = transform(pose, local)
            found, r, n = cloud.match(world, reach_m)
            w = huber(r) / 0.03**2 / max(1.0, len(r) / 100)
            J = jacobian(pose, world[found], n)
            d = pose - guess
            d[2] = wrap(d[2])
            step = np.linalg.solve(J.T @ (w[:, None] * J) + prior, -J.T @ (w * r) - prior @ d)
            pose = pose + step
            pose[2] = wrap(pose[2])
            if np.abs(step).max() < 1e-6:
                break
    found, r, _ = cloud.match(transform(pose, local), 0.15)
    return pose, len(r) / len(local), np.abs(r).mean()


def half_of(scan, first):
    """The scan with every other beam only."""
    ranges_m = scan.ranges_m.copy()
    ranges_m[1 - first :: 2] = np.inf
    return replace(scan, ranges_m=ranges_m)


def precision(cloud, scans, poses):
    """Poses from the even and the odd beams alone, half their difference as the error of the whole: RMS in metres and
    radians. It sees noise of the beams, not errors of the map."""
    d = np.array([relative(align(cloud, half_of(s, 0), p)[0], align(cloud, half_of(s, 1), p)[0])
                  for s, p in zip(scans, poses, strict=True)]) / 2
    return np.sqrt((d[:, :2] ** 2).sum(1).mean()), np.sqrt((d[:, 2] ** 2).mean())


def track(cloud, scans, start):
    """Scan by scan: odometry predicts, alignment corrects. Returns poses, shares and residuals."""
    found = [align(cloud, scans[0], start)]
    for before, scan in pairwise(scans):
        guess = compose(found[-1][0], relative(scan.T_odom_base, before.T_odom_base))
        found.append(align(cloud, scan, np.array(guess)))
    return map(np.array, zip(*found, strict=True))


def global_start(grid, origin, cloud, scan):
    """The start pose, with no guess: every free place on a 20 cm lattice and every 3 degrees, by the mean of a clamped
    distance to the nearest wall; the best 50 are aligned, and the one that explains most of the scan is taken.
    Returns pose, share, and the share of the best rival more than 1 m or 20 degrees away."""
    clamped = np.minimum(distance_transform_edt(grid != OCCUPIED) * RESOLUTION_M, 0.5)
    points = points_of(scan, 20.0)[::4]
    free = np.argwhere(grid[2::4, 2::4] == FREE) * 4 + 2
    places = origin + (free[:, ::-1] + 0.5) * RESOLUTION_M
    scored = []
    for theta in np.radians(np.arange(-180, 180, 3)):
        turned = transform(np.array([0, 0, theta]), points)
        cost = np.zeros(len(places))
        for p in turned:
            cell = np.floor((places + p - origin) / RESOLUTION_M).astype(int)
            inside = (cell >= 0).all(1) & (cell[:, 0] < grid.shape[1]) & (cell[:, 1] < grid.shape[0])
            cost += np.where(inside, clamped[np.where(inside, cell[:, 1], 0), np.where(inside, cell[:, 0], 0)], 0.5)
        for k in np.argsort(cost)[:20]:
            scored.append((cost[k] / len(points), *places[k], theta))
    scored.sort()
    ends = sorted((align(cloud, scan, np.array(s[1:]), pull_m=1.0, pull_deg=math.degrees(0.3)) for s in scored[:50]),
                  key=lambda e: -e[1])
    best = ends[0]
    far = [e[1] for e in ends
           if np.linalg.norm(e[0][:2] - best[0][:2]) > 1.0 or abs(wrap(e[0][2] - best[0][2])) > np.radians(20)]
    return best[0], best[1], max(far, default=0.0)


# ---- the grid ----------------------------------------------------------------------------------------------------------


def build_grid(poses, scans):
    """Counts per cell how many beams ended in it and how many went through. Returns cells (row 0 lowest), origin."""
    ends = np.concatenate([transform(p, points_of(s)) for p, s in zip(poses, scans, strict=True)] + [poses[:, :2]])
    origin = np.floor(ends.min(0) - 0.5)
    width, height = np.ceil((ends.max(0) + 0.5 - origin) / RESOLUTION_M).astype(int)
    hits, passes = np.zeros(width * height, int), np.zeros(width * height, int)

    def cells_of(points):
        cell = np.floor((points - origin) / RESOLUTION_M).astype(int)
        return cell[:, 1] * width + cell[:, 0]

    for pose, scan in zip(poses, scans, strict=True):
        sensor = compose(pose, scan.T_base_sensor)[:2]
        world = transform(pose, points_of(scan))
        end_cells = cells_of(world)
        np.add.at(hits, end_cells, 1)
        for end, end_cell in zip(world, end_cells, strict=True):
            length_m = np.linalg.norm(end - sensor)
            steps = np.arange(0.0, length_m, 0.3 * RESOLUTION_M)[:, None] / length_m
            through = np.unique(cells_of(sensor + steps * (end - sensor)))
            passes[through[through != end_cell]] += 1
    share = hits / np.maximum(hits + passes, 1)
    # A wall seen at a shallow angle is passed by the beams that end further along it: a quarter is a wall. One lone
    # return that others saw through is a person or a mixed pixel.
    cells = np.full(width * height, UNKNOWN)
    cells[passes > 0] = FREE
    cells[(hits > 0) & (share > 0.05)] = UNKNOWN
    cells[((hits >= 2) & (share >= 0.25)) | ((hits >= 1) & (passes == 0))] = OCCUPIED
    return cells.reshape(height, width), origin


# ---- logs --------------------------------------------------------------------------------------------------------------


def write_log(path, scans):
    lines = ["# ROBOTLASER1 type start_angle fov resolution max_range accuracy remission_mode n ranges 0 "
             "laser_pose robot_pose tv rv forward side axis timestamp host logger_timestamp",
             "# From Debian's mrpt-common, BSD-3-Clause; see README.md beside this file."]
    for scan in scans:
        ranges = " ".join(f"{r:.2f}" for r in scan.ranges_m)
        poses = " ".join(f"{v:.6f}" for v in (*compose(scan.T_odom_base, scan.T_base_sensor), *scan.T_odom_base))
        lines.append(f"ROBOTLASER1 0 {-np.pi / 2:.9f} {np.pi:.9f} {np.pi / 360:.9f} {NO_RETURN_M:.1f} 0.01 0 "
                     f"{len(scan.ranges_m)} {ranges} 0 {poses} 0 0 0 0 0 {scan.stamp_s:.6f} malaga "
                     f"{scan.stamp_s - scans[0].stamp_s:.6f}")
    path.write_bytes(gzip.compress(("\n".join(lines) + "\n").encode(), 9, mtime=0))


def write_tum(path, scans, poses, comment):
    rows = [f"# {comment}; see README.md beside this file", "# timestamp x y z qx qy qz qw"]
    for scan, (x, y, theta) in zip(scans, poses, strict=True):
        rows.append(f"{scan.stamp_s:.6f} {x:.6f} {y:.6f} 0 0 0 {np.sin(theta / 2):.9f} {np.cos(theta / 2):.9f}")
    path.write_text("\n".join(rows) + "\n")


def export(name, simplemap, rawlog, title, out):
    keyframes = Stream((DATASETS / simplemap).read_bytes()).read()
    key_scans = [scan_of(scan) for _, scan in keyframes]
    given = np.array([planar(pose) for pose, _ in keyframes])
    poses, before, after = refine_keyframes(given, key_scans)
    shift = np.linalg.norm((poses - given)[:, :2], axis=1)
    print(f"{name}: {len(poses)} key frames, residual {100 * before:.2f} -> {100 * after:.2f} cm, moved "
          f"{100 * shift.mean():.1f} cm in the mean, {100 * shift.max():.1f} at most")
    cells, origin = build_grid(poses, key_scans)
    cloud = cloud_of_map(poses, key_scans)
    scans = read_rawlog(DATASETS / rawlog)
    start, share, rival = global_start(cells, origin, cloud, scans[0])
    print(f"{name}: start {np.round(start, 4)} explains {share:.3f} of the first scan; best rival elsewhere {rival:.3f}")
    track_, shares, residuals = track(cloud, scans, start)
    print(f"{name}: {len(scans)} scans, {np.linalg.norm(np.diff(track_[:, :2], axis=0), axis=1).sum():.1f} m, "
          f"{scans[-1].stamp_s - scans[0].stamp_s:.1f} s; on the map: share {shares.mean():.3f} (least {shares.min():.3f}), "
          f"residual {100 * residuals.mean():.2f} cm (most {100 * residuals.max():.2f})")
    repeat_m, repeat_rad = precision(cloud, scans, track_)
    print(f"{name}: from half the beams, the poses repeat to {100 * repeat_m:.2f} cm, {np.degrees(repeat_rad):.3f} degrees")
    odometry = [scan.T_odom_base for scan in scans]
    steps = [(relative(b, a), relative(v, u)) for (a, b), (u, v) in zip(pairwise(track_), pairwise(odometry), strict=True)]
    along = [np.hypot(*a[:2]) - np.hypot(*b[:2]) for a, b in steps]
    turn = [wrap(a[2] - b[2]) for a, b in steps]
    print(f"{name}: odometry per scan differs by {np.sqrt(np.mean(np.square(along))):.3f} m, "
          f"{np.degrees(np.sqrt(np.mean(np.square(turn)))):.2f} degrees RMS; at the end by "
          f"{np.round(relative(compose(start, odometry[-1]), track_[-1]), 3)}")
    stamps = {round(s.stamp_s * 1e6): p for s, p in zip(key_scans, poses, strict=True)}
    same = [(p, stamps[round(s.stamp_s * 1e6)]) for s, p in zip(scans, track_, strict=True)
            if round(s.stamp_s * 1e6) in stamps]
    if same:
        off = [np.linalg.norm(a[:2] - b[:2]) for a, b in same]
        print(f"{name}: {len(same)} scans are key frames of the map; there the track differs from the map's own pose by "
              f"{100 * np.mean(off):.2f} cm, {100 * np.max(off):.2f} at most")
    write_map(out / f"{name}.yaml", grid_of(cells.astype(np.uint8), RESOLUTION_M, tuple(origin)),
              decimals=3, before=f"# {title}; see logs/README.md\n", mode="")
    write_log(out / "logs" / f"{name}.log.gz", scans)
    write_tum(out / "logs" / f"{name}.tum", scans, track_, "Reference: scans aligned to the map, not a survey")
    print(f"{name}: {cells.shape[1]} x {cells.shape[0]} cells, origin {origin}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "maps", help="folder for maps, with logs/ in it (maps)")
    out = parser.parse_args().out
    (out / "logs").mkdir(parents=True, exist_ok=True)
    export("malaga_corridor", "localization_demo.simplemap.gz", "localization_demo.rawlog",
           "Corridor in Malaga, 19 January 2006", out)
    export("malaga_faculty", "malaga-cs-fac-building.simplemap.gz", "2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog",
           "Telecom Faculty in Malaga, 21 January 2006", out)


if __name__ == "__main__":
    main()
