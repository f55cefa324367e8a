#!/usr/bin/env python3
"""tools/studies/scheduler.py: the time of runs that can be worked out by hand, and that no time is lost count of."""

import math
import pathlib
import random
import struct
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools/studies"))
import scheduler  # noqa: E402
from scheduler import Cluster, simulate  # noqa: E402

EXACT = {"dying": 0.0, "dispatch_s": 0.0, "start_s": 0.0, "append_s": 0.0}


class SchedulerTest(unittest.TestCase):
    def test_equal_trials_without_losses(self):
        run = simulate([2.0] * 120, 12, Cluster(workers=4, **EXACT))  # 3 parts of 10 trials each
        self.assertEqual(run.makespan_s, 60.0)
        self.assertEqual(run.starts, 12)
        self.assertEqual(run.deaths, 0)
        self.assertEqual(set(run.lost.values()), {0.0})

    def test_the_last_parts(self):
        run = simulate([2.0] * 50, 5, Cluster(workers=4, **EXACT))  # one worker has two parts, three wait for it
        self.assertEqual(run.makespan_s, 40.0)
        self.assertEqual(run.lost["last"], 60.0)

    def test_what_a_part_costs(self):
        cluster = Cluster(workers=2, **{**EXACT, "start_s": 3.0, "append_s": 0.5})
        run = simulate([1.0] * 20, 4, cluster)  # 2 parts each, of 3 + 5 * 1.5 s
        self.assertEqual(run.makespan_s, 21.0)
        self.assertEqual(run.lost["starting"], 12.0)
        self.assertEqual(run.lost["appending"], 10.0)

    def test_the_scheduler_starts_one_after_the_other(self):
        cluster = Cluster(workers=3, **{**EXACT, "dispatch_s": 1.0})
        run = simulate([10.0] * 3, 3, cluster)
        self.assertEqual(run.makespan_s, 13.0)
        self.assertEqual(run.lost["waiting"], 6.0)  # 1 + 2 + 3
        self.assertEqual(run.lost["last"], 3.0)  # 2 + 1

    def test_a_death_costs_its_trial_and_the_time_until_it_is_replaced(self):
        drawn = random.Random(1)
        rate = -math.log1p(-0.9) / 100.0
        death_s = drawn.expovariate(rate)
        self.assertLess(death_s, 100.0)  # within the work
        cluster = Cluster(workers=1, **{**EXACT, "dying": 0.9, "restart_s": 7.0, "notice_s": 1.0})
        run = simulate([1.0] * 100, 1, cluster, seed=1)
        self.assertGreaterEqual(run.deaths, 1)
        # Of every life whole trials count; the next one begins 7 s after its end.
        at_s, left, life_ends_s = 0.0, 100, death_s
        while at_s + left > life_ends_s:
            left -= math.floor(life_ends_s - at_s)
            at_s = life_ends_s + 7.0
            life_ends_s = at_s + drawn.expovariate(rate)
        self.assertAlmostEqual(run.makespan_s, at_s + left, places=9)

    def test_all_time_is_accounted_for(self):
        drawn = random.Random(1)
        trial_s = [drawn.uniform(0.5, 2.0) for _ in range(5000)]
        for parts in (20, 100, 5000):
            cluster = Cluster(workers=20, dying=0.5, restart_s=10.0, notice_s=2.0, dispatch_s=0.01)
            run = simulate(trial_s, parts, cluster)
            self.assertGreater(run.deaths, 0)
            self.assertGreaterEqual(run.starts, parts)
            self.assertAlmostEqual(run.work_s, math.fsum(trial_s), places=6)
            self.assertAlmostEqual(run.makespan_s * 20, run.work_s + math.fsum(run.lost.values()), places=6)
            for name, lost_s in run.lost.items():
                self.assertGreaterEqual(lost_s, -1e-6, name)

    def test_parts_are_as_large_as_shards(self):
        self.assertEqual(scheduler.part_sizes(7, 3), [3, 2, 2])
        self.assertEqual(scheduler.part_sizes(2, 3), [1, 1, 0])

    def test_times_of_a_shard(self):
        trials = b"".join(struct.pack("<IQdI", 0x4C414954, k, 0.5 + k, 3) + b"abc" + b"\0" * 4 for k in range(2))
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "shard.parloc"
            file.write_bytes(b"parloc shard\n" + struct.pack("<IQ", 1, 2) + b"{}" + trials)
            self.assertEqual(scheduler.times_of_shard(file), [0.5, 1.5])
            file.write_bytes(b"else")
            with self.assertRaises(SystemExit):
                scheduler.times_of_shard(file)


if __name__ == "__main__":
    unittest.main()
