#!/usr/bin/env python3
"""What `parloc run --mcap` and `parloc log convert` write, read by readers that are not ours: mcap (with its checksums),
mcap-ros2-support (by the definitions in the file) and rosbags. Usage: mcap_program_test.py PARLOC [unittest arguments].
Skipped where they are missing."""

import gzip
import json
import math
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

try:
    from mcap.reader import make_reader
    from mcap.stream_reader import StreamReader
    from mcap_ros2.decoder import DecoderFactory
    from rosbags.highlevel import AnyReader
except ImportError as missing:
    print(f"skipped: {missing} (pip install mcap mcap-ros2-support rosbags)")
    sys.exit(77)

ROOT = pathlib.Path(__file__).resolve().parents[2]
PARLOC = sys.argv.pop(1)
LOG = ROOT / "maps/logs/malaga_faculty.log.gz"
TOPICS = ["/map", "/scan", "/tf", "/tf_static", "/amcl_pose", "/particle_cloud", "/path", "/truth", "/truth_path", "/health"]


def run_on(name):
    files = ["--map", ROOT / f"maps/{name}.yaml", "--truth", ROOT / f"maps/logs/{name}.tum"]
    return ["run", *files, "--quiet", "--backend", "cpu"]


RUN = run_on("malaga_faculty")


def parloc(*words, code=0):
    done = subprocess.run([PARLOC, *map(str, words)], capture_output=True, text=True, timeout=120)
    assert done.returncode == code, (words, done.returncode, done.stderr)
    return done


def decoded(path):
    """{topic: [(recorded [ns], message)]}, in the order of the file's index, checksums held."""
    topics = {}
    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for _, channel, raw, message in reader.iter_decoded_messages():
            topics.setdefault(channel.topic, []).append((raw.log_time, message))
    return topics


def records(path):
    """All records one after the other, the end included; raises where a checksum is wrong."""
    with open(path, "rb") as file:
        return list(StreamReader(file, validate_crcs=True).records)


def seconds(stamp):
    return stamp.sec + stamp.nanosec / 1e9


def yaw(q):
    return math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z))


def compose(a, b):
    c, s = math.cos(a[2]), math.sin(a[2])
    return (a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], a[2] + b[2])


def planar(transform):
    return (transform.translation.x, transform.translation.y, yaw(transform.rotation))


def rows(path):
    return [[float(x) for x in line.split()] for line in path.read_text().splitlines() if not line.startswith("#")]


def carmen(path):
    content = path.read_bytes()
    text = (gzip.decompress(content) if path.suffix == ".gz" else content).decode()
    return [line.split() for line in text.splitlines() if line.startswith("ROBOTLASER")]


class McapProgram(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.at = pathlib.Path(cls.folder.name)
        cls.mcap = cls.at / "run.mcap"
        parloc(*RUN, "--log", LOG, "--out", cls.at / "with", "--mcap", cls.mcap)
        cls.topics = decoded(cls.mcap)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_the_run_stays_what_it_was(self):
        parloc(*RUN, "--log", LOG, "--out", self.at / "without")
        for name in ["trajectory.tum", "poses.csv"]:
            self.assertEqual((self.at / "with" / name).read_bytes(), (self.at / "without" / name).read_bytes())
        self.assertEqual(json.loads((self.at / "with/metrics.json").read_text())["mcap"], str(self.mcap))
        self.assertIsNone(json.loads((self.at / "without/metrics.json").read_text())["mcap"])
        self.assertIn("run.mcap", (self.at / "with/report.html").read_text())

    def test_has_every_topic(self):
        scans = len(carmen(LOG))
        counts = {topic: len(messages) for topic, messages in self.topics.items()}
        self.assertEqual(sorted(counts), sorted(TOPICS))
        for topic in ["/scan", "/tf", "/amcl_pose", "/health"]:
            self.assertEqual(counts[topic], scans, topic)
        for topic in ["/map", "/tf_static", "/truth_path"]:
            self.assertEqual(counts[topic], 1, topic)
        self.assertLessEqual(counts["/particle_cloud"], 2 * 59.1 + 2)
        self.assertLessEqual(counts["/path"], 59.1 / 5 + 2)

    def test_poses_are_those_of_the_trajectory(self):
        trajectory = rows(self.at / "with/trajectory.tum")
        said_and_tf = zip(self.topics["/amcl_pose"], self.topics["/tf"], strict=True)
        for ((_, said), (_, tf)), row, line in zip(said_and_tf, trajectory, carmen(LOG), strict=True):
            self.assertAlmostEqual(seconds(said.header.stamp), row[0], places=5)
            self.assertEqual(said.header.frame_id, "map")
            pose = said.pose.pose
            self.assertAlmostEqual(pose.position.x, row[1], places=5)
            self.assertAlmostEqual(pose.position.y, row[2], places=5)
            self.assertAlmostEqual(pose.orientation.z, row[6], places=5)
            for place in [0, 7, 35]:
                self.assertGreater(said.pose.covariance[place], 0.0)
            self.assertAlmostEqual(said.pose.covariance[1], said.pose.covariance[6])
            to_odom, to_base = tf.transforms
            self.assertEqual((to_odom.header.frame_id, to_odom.child_frame_id), ("map", "odom"))
            self.assertEqual((to_base.header.frame_id, to_base.child_frame_id), ("odom", "base_link"))
            x, y, _ = compose(planar(to_odom.transform), planar(to_base.transform))
            self.assertAlmostEqual(x, pose.position.x, places=9)
            self.assertAlmostEqual(y, pose.position.y, places=9)
            self.assertEqual(to_base.transform.translation.x, float(line[9 + 361 + 1 + 3]))

    def test_scans_are_those_of_the_log(self):
        for (recorded_ns, scan), line in zip(self.topics["/scan"], carmen(LOG), strict=True):
            self.assertEqual(recorded_ns, scan.header.stamp.sec * 1_000_000_000 + scan.header.stamp.nanosec)
            self.assertEqual(f"{scan.header.stamp.sec}.{scan.header.stamp.nanosec // 1000:06d}", line[-3])
            self.assertEqual([f"{r:.2f}" for r in scan.ranges], [f"{float(r):.2f}" for r in line[9 : 9 + 361]])
            self.assertAlmostEqual(scan.angle_min, -math.pi / 2, places=6)
            self.assertAlmostEqual(scan.angle_max, math.pi / 2, places=6)
            self.assertAlmostEqual(scan.angle_increment, math.pi / 360, places=8)
            self.assertEqual(scan.range_max, 80.0)
        [(_, fixed)] = self.topics["/tf_static"]
        [mount] = fixed.transforms
        self.assertEqual(mount.header.frame_id, "base_link")
        self.assertEqual(mount.child_frame_id, self.topics["/scan"][0][1].header.frame_id)
        self.assertAlmostEqual(mount.transform.translation.x, 0.78, places=6)

    def test_map_particles_path_truth_and_health(self):
        [(_, grid)] = self.topics["/map"]
        self.assertEqual(len(grid.data), grid.info.width * grid.info.height)
        self.assertAlmostEqual(grid.info.resolution, 0.05, places=7)
        self.assertEqual(set(grid.data), {-1, 0, 100})
        _, cloud = self.topics["/particle_cloud"][-1]
        self.assertTrue(100 < len(cloud.particles) <= 500)
        _, path = self.topics["/path"][-1]
        self.assertGreater(len(path.poses), 200)
        self.assertEqual(seconds(path.poses[-1].header.stamp), seconds(path.header.stamp))
        truth = rows(ROOT / "maps/logs/malaga_faculty.tum")
        self.assertAlmostEqual(self.topics["/truth"][-1][1].pose.position.x, truth[-1][1], places=6)
        self.assertEqual(len(self.topics["/truth_path"][0][1].poses), len(truth))
        [status] = self.topics["/health"][-1][1].status
        values = {value.key: value.value for value in status.values}
        self.assertEqual(status.message, values["state"])
        self.assertTrue(0.0 <= float(values["probability"]) <= 1.0)
        self.assertGreater(float(values["n_eff"]), 1.0)

    def test_file_is_what_ros_expects(self):
        with open(self.mcap, "rb") as file:
            reader = make_reader(file, validate_crcs=True)
            self.assertEqual(reader.get_header().profile, "ros2")
            summary = reader.get_summary()
        self.assertEqual(summary.statistics.message_count, sum(map(len, self.topics.values())))
        for index in summary.chunk_indexes:
            self.assertEqual(index.compression, "zstd")
        records(self.mcap)
        for channel in summary.channels.values():
            self.assertEqual(channel.message_encoding, "cdr")
            self.assertEqual(summary.schemas[channel.schema_id].encoding, "ros2msg")
            latched = channel.topic in ["/map", "/tf_static", "/truth_path"]
            self.assertIn(f"durability: {1 if latched else 2}\n", channel.metadata["offered_qos_profiles"])

    def test_rosbags_reads_it(self):
        with AnyReader([self.mcap]) as reader:
            for connection, _, raw in reader.messages():
                reader.deserialize(raw, connection.msgtype)
            self.assertEqual(reader.message_count, sum(map(len, self.topics.values())))
            self.assertTrue(all(len(connection.ext.offered_qos_profiles) == 1 for connection in reader.connections))

    def slow_run(self, name):
        """A run that takes long enough to be broken off, once a few chunks are there."""
        out = self.at / f"{name}.mcap"
        slow = ["--particles", "200000", "--threads", "1"]
        run = subprocess.Popen(
            [PARLOC, *map(str, [*RUN, "--log", LOG, "--out", self.at / name, "--mcap", out, *slow])],
            stderr=subprocess.DEVNULL,
            env={**os.environ, "GOMP_SPINCOUNT": "3000"},
        )
        waited = time.monotonic() + 60
        sizes = set()
        while run.poll() is None and time.monotonic() < waited and len(sizes) < 4:  # empty, the map, and two chunks more
            time.sleep(0.05)
            sizes.add(out.stat().st_size if out.exists() else 0)
        self.assertIsNone(run.poll(), "the run was over too soon")
        return run, out

    def test_interrupted_it_is_whole(self):
        run, out = self.slow_run("interrupted")
        run.send_signal(signal.SIGINT)
        self.assertEqual(run.wait(60), 130)
        self.assertEqual(len(decoded(out)["/amcl_pose"]), len(rows(self.at / "interrupted/trajectory.tum")))
        records(out)

    def test_killed_it_is_readable_up_to_the_last_chunk(self):
        run, out = self.slow_run("killed")
        run.kill()
        run.wait(60)
        topics = {}
        with open(out, "rb") as file:
            decoders, names, schemas = {}, {}, {}
            try:
                for record in StreamReader(file, validate_crcs=True).records:
                    if type(record).__name__ == "Schema":
                        schemas[record.id] = record
                    elif type(record).__name__ == "Channel":
                        names[record.id] = record.topic
                        decoders[record.id] = DecoderFactory().decoder_for("cdr", schemas[record.schema_id])
                    elif type(record).__name__ == "Message":
                        topics.setdefault(names[record.channel_id], []).append(decoders[record.channel_id](record.data))
            except Exception as end:  # of the file, where the run was killed
                self.assertNotIn("CRC", str(end))
        self.assertGreaterEqual(len(topics["/amcl_pose"]), 1)
        self.assertEqual(len(topics["/map"]), 1)
        # And by parloc itself, which says that it is cut off.
        self.assertIn("cut off", parloc("log", "convert", out, "--output", self.at / "cut.log").stdout)

    def test_refuses_what_cannot_be_written(self):
        for target, code, words in [
            (self.at, 5, "cannot be written: Is a directory"),
            (self.at / "none/run.mcap", 5, "cannot be written: No such file"),
            (LOG, 2, "is read in this run"),
        ]:
            done = parloc(*RUN, "--log", LOG, "--out", self.at / "refused", "--mcap", target, code=code)
            self.assertIn(words, done.stderr)
            self.assertEqual(done.stderr.count("\n"), 1)
            self.assertFalse((self.at / "refused").exists())

    def test_a_log_and_what_it_was_converted_to_give_the_same_bits(self):
        # MCAP has angles in single precision: the log that has the same numbers is the one that is made of it.
        for name in ["malaga_faculty", "malaga_corridor"]:
            first, text, second = self.at / f"{name}1.mcap", self.at / f"{name}.log", self.at / f"{name}2.mcap"
            parloc("log", "convert", ROOT / f"maps/logs/{name}.log.gz", "--output", first)
            parloc("log", "convert", first, "--output", text)
            parloc("log", "convert", text, "--output", second)
            results = set()
            for log in [first, text, second]:
                parloc(*run_on(name), "--log", log, "--out", self.at / "converted")
                results.add((self.at / "converted/trajectory.tum").read_bytes())
            self.assertEqual(len(results), 1, name)

    def test_a_log_with_numbers_of_single_precision_gives_the_same_bits_as_mcap(self):
        text, mcap = self.at / "single.log", self.at / "single.mcap"
        lines = []
        for line in carmen(LOG):
            x, y, theta = line[9 + 361 + 1 + 3 : 9 + 361 + 1 + 6]
            line[2:5] = ["-1.40625", str(360 * 0.0078125), "0.0078125"]
            line[9 + 361 + 1 : 9 + 361 + 4] = [x, y, theta]  # at the robot's own place, to the bit
            lines.append(" ".join(line) + "\n")
        text.write_text("".join(lines))
        done = parloc("log", "convert", text, "--output", mcap)
        self.assertNotIn("warning", done.stdout)
        # Angles that are not the LiDAR's do not fit the map: without judging it, nobody searches.
        settings = self.at / "bare.yaml"
        settings.write_text("localize:\n  health: false\n")
        for log in [text, mcap]:
            parloc(*RUN, "--config", settings, "--log", log, "--out", self.at / log.suffix[1:])
        self.assertEqual((self.at / "log/trajectory.tum").read_bytes(), (self.at / "mcap/trajectory.tum").read_bytes())

    def test_converted_log_by_other_readers(self):
        out = self.at / "converted.mcap"
        parloc("log", "convert", LOG, "--output", out)
        topics = decoded(out)
        records(out)
        lines = carmen(LOG)
        counts = {topic: len(messages) for topic, messages in topics.items()}
        self.assertEqual(counts, {"/robotlaser1": 225, "/odom": 225, "/tf": 225, "/tf_static": 1})
        for (_, scan), (_, odometry), line in zip(topics["/robotlaser1"], topics["/odom"], lines, strict=True):
            self.assertEqual(seconds(scan.header.stamp), seconds(odometry.header.stamp))
            self.assertEqual(odometry.child_frame_id, "base_link")
            self.assertEqual(odometry.pose.pose.position.x, float(line[9 + 361 + 1 + 3]))
            self.assertAlmostEqual(yaw(odometry.pose.pose.orientation), float(line[9 + 361 + 1 + 5]), places=12)
        with AnyReader([out]) as reader:
            self.assertEqual(reader.message_count, 676)

    def test_convert_interrupted_is_whole(self):
        pipe, out = self.at / "pipe", self.at / "part.mcap"
        os.mkfifo(pipe)
        convert = subprocess.Popen([PARLOC, "log", "convert", pipe, "--output", out, "--quiet"])
        lines = [f"FLASER 5 1 2 3 4 5 0 0 0 0.1 0 0 {k / 10} host 0\n" for k in range(8000)]
        blocks = ["".join(lines[k : k + 500]).encode() for k in range(0, len(lines), 200)]
        log = os.open(pipe, os.O_WRONLY)
        for block in blocks[:20]:
            os.write(log, block)  # all but what a pipe holds has been read
        convert.send_signal(signal.SIGINT)
        try:
            for block in blocks[20:]:
                os.write(log, block)
        except BrokenPipeError:  # as soon as it ends
            pass
        os.close(log)
        self.assertEqual(convert.wait(60), 130)
        scans = len(decoded(out)["/front"])
        self.assertTrue(2000 < scans <= 8000, scans)
        records(out)

    def test_convert_refuses_in_one_line(self):
        for words, code, said in [
            ((LOG, "--output", self.at / "a.bag"), 2, "expected a name that ends in .mcap or .log"),
            ((LOG, "--output", LOG), 2, "expected a name"),
            ((self.at / "none.log", "--output", self.at / "a.mcap"), 3, "none.log"),
            ((LOG, "--output", self.at / "none/a.mcap"), 5, "cannot be written"),
        ]:
            done = parloc("log", "convert", *words, code=code)
            self.assertIn(said, done.stderr)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        empty = self.at / "empty.log"
        empty.write_text("ODOM 0 0 0 0 0 0 1.0 host 1.0\n")
        kept = self.at / "kept.mcap"
        kept.write_text("as it was")
        parloc("log", "convert", empty, "--output", kept, code=3)
        self.assertEqual(kept.read_text(), "as it was")
        self.assertEqual(list(self.at.glob("*.part*")), [])


if __name__ == "__main__":
    unittest.main()
