#!/usr/bin/env python3
"""How fast parloc reads a bag: writes a zstd MCAP of 1081-beam scans at 40 Hz with odometry, and reads it once with the program
read_log of tests/bench (scans and odometry decoded and joined), with `parloc log info` (all topics, then the same, then a look
at the mount), and a part of it with the `mcap` package of Python. Needs mcap, mcap-ros2-support, numpy.

Usage: bag_speed.py [BUILD] [GIGABYTES] [FOLDER]       defaults: build/cpu, 2, a temporary folder"""

import pathlib
import resource
import struct
import subprocess
import sys
import tempfile
import time

import numpy as np
from mcap.reader import make_reader
from mcap.writer import Writer
from mcap_ros2.decoder import DecoderFactory

BEAMS, RATE_HZ = 1081, 40
HEADER = "std_msgs/Header header\n"
SCAN = HEADER + "".join(
    f"float32 {name}\n"
    for name in ("angle_min", "angle_max", "angle_increment", "time_increment", "scan_time", "range_min", "range_max")
)
SCAN += "float32[] ranges\nfloat32[] intensities\n"
PARTS = "=" * 80 + "\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n" + "=" * 80
PARTS += "\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"


def text(value):
    return struct.pack("<I", len(value) + 1) + value.encode() + b"\0"


def padded(data, size):
    return data + bytes(-(len(data) - 4) % size)


def scan_message(stamp_ns, ranges_m, intensities):
    head = b"\0\1\0\0" + struct.pack("<iI", stamp_ns // 10**9, stamp_ns % 10**9) + text("base_link")
    step = np.float32(np.deg2rad(0.25))
    head = padded(head, 4) + struct.pack("<7f", -2.356, 2.356, step, 1.7e-5, 0.025, 0.02, 30.0)
    count = struct.pack("<I", BEAMS)
    return head + count + ranges_m.tobytes() + count + intensities.tobytes()


def odometry_message(stamp_ns, x_m):
    head = b"\0\1\0\0" + struct.pack("<iI", stamp_ns // 10**9, stamp_ns % 10**9) + text("odom")
    head = padded(head, 4) + text("base_link")
    head = padded(head, 8)
    return head + struct.pack("<7d", x_m, 0, 0, 0, 0, 0, 1) + bytes(36 * 8) + bytes(6 * 8) + bytes(36 * 8)


def write_bag(path, most_bytes):
    """Walls with noise of 1 cm and steps of 1 mm, as LiDARs give them. Returns the bytes of all messages."""
    noise = np.random.default_rng(1)
    written, k = 0, 0
    angles = np.linspace(-2.356, 2.356, BEAMS)
    with open(path, "wb") as file:
        bag = Writer(file)
        bag.start(profile="ros2", library="bag_speed")
        scan = bag.register_channel(
            "/scan", "cdr", bag.register_schema("sensor_msgs/msg/LaserScan", "ros2msg", (SCAN + PARTS).encode())
        )
        odom = bag.register_channel("/odom", "cdr", bag.register_schema("nav_msgs/msg/Odometry", "ros2msg", b""))
        while written < most_bytes:
            stamp_ns = 1_700_000_000 * 10**9 + k * (10**9 // RATE_HZ)
            walls_m = 3.0 + 2.0 * np.abs(np.sin(2 * angles + 0.001 * k)) + noise.normal(0, 0.01, BEAMS)
            ranges_m = (np.round(walls_m * 1000) / 1000).astype(np.float32)
            intensities = np.round(noise.uniform(100, 4000, BEAMS)).astype(np.float32)
            for channel, data in (
                (odom, odometry_message(stamp_ns, 0.01 * k)),
                (scan, scan_message(stamp_ns, ranges_m, intensities)),
            ):
                bag.add_message(channel, stamp_ns, data, stamp_ns)
                written += len(data)
            k += 1
        bag.finish()
    return written


def time_command(*command):
    """Seconds of a CPU, which other programs beside it do not lengthen as they do those of a clock; memory [MiB]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(["taskset", "-c", "0", *command], check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, after.ru_maxrss / 1024


def time_python(path):
    before = time.process_time()
    beams = 0
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, _, _, message in reader.iter_decoded_messages(topics=["/scan"]):
            beams += len(message.ranges)
    assert beams > 0
    return time.process_time() - before


def main():
    build = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "build/cpu")
    gigabytes = float(sys.argv[2]) if len(sys.argv) > 2 else 2.0
    read = build / "tests/bench/read_log"
    info = (build / "parloc", "log", "info", "--json")
    with tempfile.TemporaryDirectory(dir=sys.argv[3] if len(sys.argv) > 3 else None) as folder:
        large, small = pathlib.Path(folder) / "large.mcap", pathlib.Path(folder) / "small.mcap"
        size = write_bag(large, gigabytes * 1e9)
        part = write_bag(small, 1e8)
        packed = large.stat().st_size
        print(f"{size / 1e9:.2f} GB of messages in {packed / 1e9:.2f} GB of zstd MCAP, seconds of one core")
        seconds, resident_mib = time_command(read, large)  # first: the largest memory is of all so far
        print(f"read once: {seconds:.2f} s, {size / seconds / 1e6:.0f} MB/s, {resident_mib:.0f} MiB resident")
        seconds, resident_mib = time_command(*info, large)
        print(f"log info:  {seconds:.2f} s, {size / seconds / 1e6:.0f} MB/s, {resident_mib:.0f} MiB resident")
        ours = [time_command(read, small)[0] for _ in range(3)]
        info_s = min(time_command(*info, small)[0] for _ in range(3))
        theirs = time_python(small)
        print(f"{part / 1e6:.0f} MB: read once {min(ours):.3f} s, log info {info_s:.3f} s, mcap in Python {theirs:.2f} s:")
        print(f"  {theirs / min(ours):.1f} times as long as reading once, {theirs / info_s:.1f} as log info")


if __name__ == "__main__":
    main()
