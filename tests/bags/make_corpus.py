#!/usr/bin/env python3
"""Writes the small bags of tests/fuzz/corpus anew: one drive of four scans in every container, which tests/unit/bag_test.cpp
reads too, and one message of each type that parloc decodes. Needs rosbags and mcap. Usage: tests/bags/make_corpus.py"""

import math
import pathlib
import shutil
import sqlite3
import tempfile

import numpy as np
from bag_writer import STORES, Message, Messages, without_index, write_mcap, write_ros1, write_ros2
from drive import Drive, Scan, as_messages_hold_it
from mcap.writer import IndexType

CORPUS = pathlib.Path(__file__).resolve().parents[1] / "fuzz/corpus"


def small_drive():
    scans = []
    for k in range(4):
        ranges = np.array([1.0 + 0.25 * beam + 0.125 * k for beam in range(8)], dtype=np.float32)
        ranges[7] = math.inf
        odometry = (0.5 * k, -0.25 * k, as_messages_hold_it(0.125 * k))
        scans.append(Scan(1_700_000_000_000_000_000 + 250_000_000 * k, ranges, odometry))
    return Drive(-1.0, 0.25, 8.0, 0.0, scans)


def small_pages(path):
    """SQLite's smallest pages: a fuzzer gets farther with fewer bytes."""
    bag = sqlite3.connect(path)
    bag.execute("PRAGMA page_size=512")
    bag.execute("VACUUM")
    bag.close()


def write_bags(folder, drive):
    ros1, ros2 = Messages(1).of_drive(drive), Messages(2).of_drive(drive)
    for compression in ("none", "lz4", "zstd"):
        write_mcap(folder / f"mcap/{compression}.mcap", ros2, compression, chunk_size=600)
    write_mcap(folder / "mcap/unchunked.mcap", ros2, use_chunking=False)
    write_mcap(folder / "mcap/disordered.mcap", ros2[:1] + ros2[2::2] + ros2[1::2], chunk_size=600)
    bare = {"index_types": IndexType.NONE, "use_statistics": False, "use_summary_offsets": False}
    write_mcap(folder / "mcap/no_index.mcap", ros2, repeat_channels=False, repeat_schemas=False, **bare)
    write_mcap(folder / "mcap/ros1.mcap", ros1, ros=1)
    for compression in (None, "bz2", "lz4"):
        write_ros1(folder / f"ros1_bag/{compression or 'none'}.bag", ros1, compression)
    shutil.copy(folder / "ros1_bag/none.bag", folder / "ros1_bag/no_index.bag")
    without_index(folder / "ros1_bag/no_index.bag")
    for name, mode, little in (("plain", None, True), ("zstd", "message", True), ("big_endian", None, False)):
        with tempfile.TemporaryDirectory() as work:
            write_ros2(pathlib.Path(work) / "bag", ros2, mode=mode, little_endian=little)
            shutil.copy(next(pathlib.Path(work).glob("bag/*.db3*")), folder / f"sqlite_bag/{name}.db3")
        small_pages(folder / f"sqlite_bag/{name}.db3")


def example_messages(make, drive):
    scan = drive.scans[1]
    yield make.scan(drive, scan)
    yield make.multi_echo_scan(drive, scan)
    yield make.odometry(scan.stamp_ns, scan.odometry)
    yield make.mount(scan.stamp_ns)
    header = make.header(scan.stamp_ns, "map")
    pose = make.new("geometry_msgs/PoseStamped", header=header, pose=make.pose(1.0, 2.0, 0.5))
    yield Message("/pose", "geometry_msgs/msg/PoseStamped", scan.stamp_ns, pose)
    facts = make.new(
        "nav_msgs/MapMetaData",
        map_load_time=header.stamp,
        resolution=0.05,
        width=3,
        height=2,
        origin=make.pose(-1.0, -2.0, 0.0),
    )
    cells = np.array([-1, 0, 100, 0, 0, 50], dtype=np.int8)
    grid = make.new("nav_msgs/OccupancyGrid", header=header, info=facts, data=cells)
    yield Message("/map", "nav_msgs/msg/OccupancyGrid", scan.stamp_ns, grid)
    yield make.cloud(scan.stamp_ns, np.array([[1, 0, 0.5], [0, 2, 0.5], [1, 1, 3]], dtype=np.float32))


def write_messages(folder, drive):
    """The first byte says how to read the rest: tests/fuzz/message_fuzz.cpp."""
    for ros in (1, 2):
        for kind, m in enumerate(example_messages(Messages(ros), drive)):
            store = STORES[ros]
            data = store.serialize_ros1(m.value, m.type) if ros == 1 else store.serialize_cdr(m.value, m.type)
            name = m.type.rpartition("/")[2]
            (folder / f"message/{name}.ros{ros}").write_bytes(bytes([kind + (128 if ros == 1 else 0)]) + bytes(data))


def main():
    for name in ("mcap", "ros1_bag", "sqlite_bag", "message"):
        shutil.rmtree(CORPUS / name, ignore_errors=True)
        (CORPUS / name).mkdir(parents=True)
    write_bags(CORPUS, small_drive())
    write_messages(CORPUS, small_drive())


if __name__ == "__main__":
    main()
