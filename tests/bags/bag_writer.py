"""Writes a drive as bags of every kind, with the writers of others: rosbags for ROS 1 and 2, mcap for MCAP."""

import dataclasses
import pathlib
import sqlite3

import numpy as np
from drive import yaw_quaternion
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Ros2Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

STORES = {1: get_typestore(Stores.ROS1_NOETIC), 2: get_typestore(Stores.ROS2_HUMBLE)}
STORES[1].register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms\n", "tf2_msgs/msg/TFMessage"))


@dataclasses.dataclass
class Message:
    topic: str
    type: str  # "sensor_msgs/msg/LaserScan"
    stamp_ns: int
    value: object


class Messages:
    """Makes messages of one version of ROS."""

    def __init__(self, ros):
        self.ros = ros
        self.types = STORES[ros].types

    def new(self, type_name, **fields):
        package, short = type_name.split("/")
        return self.types[f"{package}/msg/{short}"](**fields)

    def header(self, stamp_ns, frame):
        sequence = {"seq": 0} if self.ros == 1 else {}
        stamp = self.new("builtin_interfaces/Time", sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9)
        return self.new("std_msgs/Header", stamp=stamp, frame_id=frame, **sequence)

    def quaternion(self, x, y, z, w):
        return self.new("geometry_msgs/Quaternion", x=x, y=y, z=z, w=w)

    def pose(self, x, y, yaw):
        z, w = yaw_quaternion(yaw)
        position = self.new("geometry_msgs/Point", x=x, y=y, z=0.0)
        return self.new("geometry_msgs/Pose", position=position, orientation=self.quaternion(0.0, 0.0, z, w))

    def scan(self, drive, scan, topic="/scan", frame="laser", **changed):
        n = len(scan.ranges_m)
        fields = {
            "header": self.header(scan.stamp_ns, frame),
            "angle_min": drive.angle_min_rad,
            "angle_max": drive.angle_min_rad + drive.angle_step_rad * (n - 1),
            "angle_increment": drive.angle_step_rad,
            "time_increment": 0.0,
            "scan_time": 0.0,
            "range_min": 0.0,
            "range_max": drive.range_max_m,
            "ranges": scan.ranges_m,
            "intensities": np.ones(n, dtype=np.float32),
        }
        fields.update(changed)
        return Message(topic, "sensor_msgs/msg/LaserScan", scan.stamp_ns, self.new("sensor_msgs/LaserScan", **fields))

    def multi_echo_scan(self, drive, scan, topic="/scan", frame="laser"):
        one = self.scan(drive, scan, topic, frame).value
        echoes = [
            self.new("sensor_msgs/LaserEcho", echoes=np.array([r, r + 1], dtype=np.float32)[: 1 + k % 2])
            for k, r in enumerate(scan.ranges_m)
        ]
        none = [self.new("sensor_msgs/LaserEcho", echoes=np.zeros(1, dtype=np.float32))] * len(echoes)
        names = ("header", "angle_min", "angle_max", "angle_increment", "time_increment", "scan_time", "range_min", "range_max")
        fields = {name: getattr(one, name) for name in names}
        value = self.new("sensor_msgs/MultiEchoLaserScan", ranges=echoes, intensities=none, **fields)
        return Message(topic, "sensor_msgs/msg/MultiEchoLaserScan", scan.stamp_ns, value)

    def odometry(self, stamp_ns, pose, topic="/odom", parent="odom", child="base_link"):
        zeros = np.zeros(36)
        vector = self.new("geometry_msgs/Vector3", x=0.0, y=0.0, z=0.0)
        twist = self.new("geometry_msgs/Twist", linear=vector, angular=vector)
        value = self.new(
            "nav_msgs/Odometry",
            header=self.header(stamp_ns, parent),
            child_frame_id=child,
            pose=self.new("geometry_msgs/PoseWithCovariance", pose=self.pose(*pose), covariance=zeros),
            twist=self.new("geometry_msgs/TwistWithCovariance", twist=twist, covariance=zeros),
        )
        return Message(topic, "nav_msgs/msg/Odometry", stamp_ns, value)

    def transforms(self, stamp_ns, transforms, topic="/tf"):
        """(parent, child, (x, y, z), (qx, qy, qz, qw)) each."""
        stamped = []
        for parent, child, (x, y, z), rotation in transforms:
            move = self.new("geometry_msgs/Vector3", x=x, y=y, z=z)
            transform = self.new("geometry_msgs/Transform", translation=move, rotation=self.quaternion(*rotation))
            header = self.header(stamp_ns, parent)
            stamped.append(self.new("geometry_msgs/TransformStamped", header=header, child_frame_id=child, transform=transform))
        return Message(topic, "tf2_msgs/msg/TFMessage", stamp_ns, self.new("tf2_msgs/TFMessage", transforms=stamped))

    def cloud(self, stamp_ns, points, topic="/points", frame="laser"):
        fields = [
            self.new("sensor_msgs/PointField", name=name, offset=4 * k, datatype=7, count=1) for k, name in enumerate("xyz")
        ]
        value = self.new(
            "sensor_msgs/PointCloud2",
            header=self.header(stamp_ns, frame),
            height=1,
            width=len(points),
            fields=fields,
            is_bigendian=False,
            point_step=12,
            row_step=12 * len(points),
            data=np.frombuffer(points.tobytes(), dtype=np.uint8),
            is_dense=True,
        )
        return Message(topic, "sensor_msgs/msg/PointCloud2", stamp_ns, value)

    def occupancy_grid(self, stamp_ns, image, resolution_m, origin, topic="/map"):
        """`image`: rows from the top, as a PGM has them, of -1 to 100."""
        header = self.header(stamp_ns, "map")
        height, width = image.shape
        facts = self.new(
            "nav_msgs/MapMetaData",
            map_load_time=header.stamp,
            resolution=resolution_m,
            width=width,
            height=height,
            origin=self.pose(*origin),
        )
        cells = image[::-1].astype(np.int8).reshape(-1)
        value = self.new("nav_msgs/OccupancyGrid", header=header, info=facts, data=cells)
        return Message(topic, "nav_msgs/msg/OccupancyGrid", stamp_ns, value)

    def pose_stamped(self, stamp_ns, pose, topic="/truth"):
        value = self.new("geometry_msgs/PoseStamped", header=self.header(stamp_ns, "map"), pose=self.pose(*pose))
        return Message(topic, "geometry_msgs/msg/PoseStamped", stamp_ns, value)

    def planar_transform(self, stamp_ns, parent, child, pose, topic="/tf"):
        z, w = yaw_quaternion(pose[2])
        return self.transforms(stamp_ns, [(parent, child, (pose[0], pose[1], 0.0), (0.0, 0.0, z, w))], topic)

    def mount(self, stamp_ns, move=(0.0, 0.0, 0.0), rotation=(0.0, 0.0, 0.0, 1.0), child="laser", parent="base_link"):
        return self.transforms(stamp_ns, [(parent, child, move, rotation)], "/tf_static")

    def of_drive(self, drive):
        """As a robot sends it: the mount once, odometry, then the scan of the same time."""
        messages = [self.mount(drive.scans[0].stamp_ns, (drive.ahead_m, 0.0, 0.0))]
        for scan in drive.scans:
            messages += [self.odometry(scan.stamp_ns, scan.odometry), self.scan(drive, scan)]
        return messages


def write_ros1(path, messages, compression=None):
    store = STORES[1]
    bag = Ros1Writer(path)
    if compression:
        bag.set_compression(Ros1Writer.CompressionFormat[compression.upper()])
    with bag:
        connections = {}
        for m in messages:
            if m.topic not in connections:
                connections[m.topic] = bag.add_connection(m.topic, m.type, typestore=store)
            bag.write(connections[m.topic], m.stamp_ns, store.serialize_ros1(m.value, m.type))


def write_ros2(folder, messages, storage="sqlite3", mode=None, little_endian=True):
    store = STORES[2]
    bag = Ros2Writer(folder, version=9, storage_plugin=StoragePlugin[storage.upper()])
    if mode:
        bag.set_compression(CompressionMode[mode.upper()], CompressionFormat.ZSTD)
    with bag:
        connections = {}
        for m in messages:
            if m.topic not in connections:
                connections[m.topic] = bag.add_connection(m.topic, m.type, typestore=store)
            bag.write(connections[m.topic], m.stamp_ns, store.serialize_cdr(m.value, m.type, little_endian=little_endian))


def write_mcap(path, messages, compression="zstd", ros=2, **options):
    store = STORES[ros]
    with open(path, "wb") as file:
        bag = McapWriter(file, compression=CompressionType[compression.upper()], **options)
        bag.start(profile=f"ros{ros}", library="drive")
        channels = {}
        for m in messages:
            if m.topic not in channels:
                definition = store.generate_msgdef(m.type, ros_version=ros)[0].encode()
                schema = bag.register_schema(m.type if ros == 2 else m.type.replace("/msg", ""), f"ros{ros}msg", definition)
                channels[m.topic] = bag.register_channel(m.topic, "cdr" if ros == 2 else "ros1", schema)
            data = store.serialize_cdr(m.value, m.type) if ros == 2 else store.serialize_ros1(m.value, m.type)
            bag.add_message(channels[m.topic], m.stamp_ns, bytes(data), m.stamp_ns)
        bag.finish()


def split_ros2(folder, messages, parts=3):
    """A bag in several files, as `ros2 bag record --max-bag-size` leaves it: the names in the order of the metadata alone."""
    folder = pathlib.Path(folder)
    folder.mkdir()
    names, size = [], -(-len(messages) // parts)
    for part in range(parts):
        write_ros2(folder / "one", messages[part * size : (part + 1) * size])
        names.append(f"{'zya'[part % 3]}_{part}.db3")
        (folder / "one" / "one.db3").rename(folder / names[-1])
        metadata = (folder / "one" / "metadata.yaml").read_text()
        for path in (folder / "one").iterdir():
            path.unlink()
        (folder / "one").rmdir()
    lines = []
    for line in metadata.splitlines():
        lines += [line.replace("one.db3", name) for name in names] if line.strip() == "- one.db3" else [line]
    (folder / "metadata.yaml").write_text("\n".join(lines) + "\n")


def shuffled_rows(path):
    """The rows of a SQLite bag in another order than that of their stamps."""
    with sqlite3.connect(path) as bag:
        rows = bag.execute("SELECT topic_id, timestamp, data FROM messages ORDER BY id").fetchall()
        bag.execute("DELETE FROM messages")
        rows = rows[1::2] + rows[::2]
        bag.executemany("INSERT INTO messages (topic_id, timestamp, data) VALUES (?, ?, ?)", rows)


def without_index(path):
    """A ROS 1 bag as it is while it is being recorded: its header does not say where the index is."""
    data = bytearray(pathlib.Path(path).read_bytes())
    at = data.index(b"index_pos=") + len(b"index_pos=")
    index_at = int.from_bytes(data[at : at + 8], "little")
    data[at : at + 8] = bytes(8)
    pathlib.Path(path).write_bytes(data[:index_at])
