"""What the tests of bags have in common: a drive, the CARMEN log of the same numbers, and what the program makes of a bag.
Skips the test where the writers of bags are missing."""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

try:
    import numpy as np
    from bag_writer import Messages, write_mcap
    from drive import carmen_text, read_drive
except ImportError as missing:
    print(f"skipped: {missing} (pip install rosbags mcap lz4)")
    sys.exit(77)

ROOT = pathlib.Path(__file__).resolve().parents[2]
MAP = ROOT / "maps/malaga_corridor.yaml"
START = "3.452733,-10.171480,-0.485216"
PROGRAM = os.path.abspath(sys.argv.pop(1))


class Localized:
    def __init__(self, result, folder):
        self.code, self.error = result.returncode, result.stderr
        path = folder / "trajectory.tum"
        self.trajectory = path.read_bytes() if path.exists() else b""

    def places(self):
        rows = [line.split() for line in self.trajectory.decode().splitlines() if not line.startswith("#")]
        return np.array([[float(word) for word in row[:3]] for row in rows])


class WithDrive(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.drive = read_drive(ROOT / "maps/logs/malaga_corridor.log.gz")
        cls.work = pathlib.Path(tempfile.mkdtemp(prefix="parloc_bags_"))
        cls.ahead = (cls.drive.ahead_m, 0.0, 0.0)
        cls.log = cls.work / "same.log"
        cls.log.write_text(carmen_text(cls.drive))
        cls.make = {1: Messages(1), 2: Messages(2)}
        cls.expected = cls.localize(cls.log)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.work)

    @classmethod
    def localize(cls, log, *options):
        out = pathlib.Path(tempfile.mkdtemp(dir=cls.work))
        command = [PROGRAM, "run", "--log", log, "--map", MAP, "--init", START, "--out", out, "--threads", "1", "--quiet"]
        result = subprocess.run([*command, *options], capture_output=True, text=True, timeout=120)
        return Localized(result, out)

    def messages(self, ros=2):
        return self.make[ros].of_drive(self.drive)

    def bag(self, messages, name="bag.mcap"):
        path = pathlib.Path(tempfile.mkdtemp(dir=self.work)) / name
        write_mcap(path, messages)
        return path

    def expect_same_bytes(self, log, *options):
        found = self.localize(log, *options)
        self.assertEqual(found.code, 0, found.error)
        self.assertEqual(found.error, "")
        self.assertGreater(len(found.trajectory), 1000)
        self.assertTrue(found.trajectory == self.expected.trajectory, f"{log}: another trajectory")

    def expect_near(self, log, most_m, *options):
        found = self.localize(log, *options)
        self.assertEqual(found.code, 0, found.error)
        apart = np.linalg.norm((found.places() - self.expected.places())[:, 1:3], axis=1)
        self.assertLess(apart.max(), most_m)

    def expect_refused(self, log, *parts, options=()):
        found = self.localize(log, *options)
        self.assertEqual(found.code, 3, found.error)
        self.assertEqual(found.error.count("\n"), 1, found.error)
        for part in parts:
            self.assertIn(part, found.error)
