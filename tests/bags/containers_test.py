#!/usr/bin/env python3
"""`parloc run` on bags that rosbags and mcap wrote: the same bytes as from the CARMEN log with the same numbers, whatever the
container. Usage: containers_test.py PROGRAM"""

import shutil
import unittest

from bag_case import WithDrive  # first: it ends the test where the writers are missing
from bag_writer import shuffled_rows, split_ros2, without_index, write_mcap, write_ros1, write_ros2
from mcap.writer import IndexType


class Containers(WithDrive):
    """Every container gives the bytes of the CARMEN log, in one command without options."""

    def test_ros2_folders(self):
        for storage, mode in (
            ("sqlite3", None),
            ("sqlite3", "file"),
            ("sqlite3", "message"),
            ("mcap", None),
            ("mcap", "file"),
            ("mcap", "storage"),
        ):
            folder = self.work / f"{storage}_{mode}"
            write_ros2(folder, self.messages(), storage, mode)
            self.expect_same_bytes(folder)

    def test_ros2_single_files_and_without_metadata(self):
        folder = self.work / "lone"
        write_ros2(folder, self.messages())
        self.expect_same_bytes(next(folder.glob("*.db3")))
        (folder / "metadata.yaml").unlink()
        self.expect_same_bytes(folder)
        shuffled_rows(next(folder.glob("*.db3")))
        self.expect_same_bytes(folder)

    def test_ros2_split(self):
        split_ros2(self.work / "split", self.messages())
        self.expect_same_bytes(self.work / "split")
        (self.work / "split/metadata.yaml").unlink()
        self.expect_same_bytes(self.work / "split")

    def test_ros2_big_endian(self):
        write_ros2(self.work / "big_endian", self.messages(), little_endian=False)
        self.expect_same_bytes(self.work / "big_endian")

    def test_mcap(self):
        bare = {"index_types": IndexType.NONE, "use_statistics": False, "use_summary_offsets": False}
        variants = {
            "none": {"compression": "none", "chunk_size": 20000},
            "lz4": {"compression": "lz4", "chunk_size": 20000},
            "zstd": {"compression": "zstd", "chunk_size": 20000},
            "unchunked": {"use_chunking": False},
            "no_index": {"repeat_channels": False, "repeat_schemas": False, **bare},
            "no_checksums": {"enable_crcs": False},
        }
        for name, options in variants.items():
            write_mcap(self.work / f"{name}.mcap", self.messages(), **options)
            self.expect_same_bytes(self.work / f"{name}.mcap")
        write_mcap(self.work / "ros1.mcap", self.messages(1), ros=1)
        self.expect_same_bytes(self.work / "ros1.mcap")

    def test_mcap_out_of_order(self):
        messages = self.messages()
        write_mcap(self.work / "disordered.mcap", messages[1::2] + messages[::2], chunk_size=20000)
        self.expect_same_bytes(self.work / "disordered.mcap")

    def test_ros1(self):
        for compression in (None, "bz2", "lz4"):
            path = self.work / f"ros1_{compression}.bag"
            write_ros1(path, self.messages(1), compression)
            self.expect_same_bytes(path)
            without_index(path)
            self.expect_same_bytes(path)

    def test_the_name_says_nothing(self):
        write_ros1(self.work / "a.bag", self.messages(1))
        for name in ("a.log", "a.mcap", "a"):
            shutil.copy(self.work / "a.bag", self.work / name)
            self.expect_same_bytes(self.work / name)

    def test_cut_off_gives_the_beginning(self):
        write_mcap(self.work / "whole.mcap", self.messages(), "zstd", chunk_size=8000)
        data = (self.work / "whole.mcap").read_bytes()
        (self.work / "cut.mcap").write_bytes(data[: len(data) // 2])
        found = self.localize(self.work / "cut.mcap")
        self.assertEqual(found.code, 0, found.error)
        rows, expected = found.trajectory.splitlines(), self.expected.trajectory.splitlines()
        self.assertGreater(len(rows), 3)
        self.assertLess(len(rows), len(expected))
        self.assertEqual(rows, expected[: len(rows)])


if __name__ == "__main__":
    unittest.main()
