"""A robot for tests: true ROS 2 processes that play a bag, and listen to what a localization node says of it."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import rclpy
from geometry_msgs.msg import PoseWithCovarianceStamped
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from mcap.reader import make_reader
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSDurabilityPolicy, QoSProfile, QoSReliabilityPolicy
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

ROOT = Path(__file__).resolve().parents[2]
LATCHED = QoSProfile(
    depth=1, reliability=QoSReliabilityPolicy.RELIABLE, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL
)
RELIABLE = QoSProfile(depth=1000)
SCANS = QoSProfile(depth=1000, reliability=QoSReliabilityPolicy.BEST_EFFORT)
KINDS = {
    "sensor_msgs/msg/LaserScan": (LaserScan, SCANS),
    "nav_msgs/msg/Odometry": (Odometry, RELIABLE),
    "tf2_msgs/msg/TFMessage": (TFMessage, RELIABLE),
}


def messages_of(bag):
    """[(stamp_s, topic, type, bytes)] of an MCAP file, in its order."""
    with open(bag, "rb") as file:
        return [
            (message.log_time * 1e-9, channel.topic, schema.name, message.data)
            for schema, channel, message in make_reader(file).iter_messages()
        ]


class AmclProcess:
    """The node `amcl` in a process of its own."""

    def __init__(self, params_file, log_path):
        self._log = open(log_path, "w")
        code = "from parloc_ros.amcl import main; main()"
        command = [sys.executable, "-B", "-c", code, "--ros-args", "--params-file", str(params_file)]
        self.process = subprocess.Popen(command, stdout=self._log, stderr=subprocess.STDOUT)
        self.log_path = log_path

    def said(self):
        return Path(self.log_path).read_text()

    def kill(self):
        self.process.kill()
        self.process.wait(10)

    def end(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
            self.process.wait(20)
        self._log.close()


class World(Node):
    """Plays messages, keeps what the node answers, and turns its lifecycle. Spins in a thread of its own."""

    def __init__(self, name="world"):
        super().__init__(name)
        self.poses, self.transforms, self.arrived_s = [], [], {}
        self.create_subscription(PoseWithCovarianceStamped, "amcl_pose", self._take_pose, RELIABLE)
        self.create_subscription(TFMessage, "/tf", self._take_transform, RELIABLE)
        self._players = {}
        self._map = self.create_publisher(OccupancyGrid, "map", LATCHED)
        self._initial = self.create_publisher(PoseWithCovarianceStamped, "initialpose", RELIABLE)
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self)
        self._thread = threading.Thread(target=self._executor.spin, daemon=True)
        self._thread.start()

    def _take_pose(self, message):
        stamp_s = message.header.stamp.sec + message.header.stamp.nanosec * 1e-9
        self.arrived_s[round(stamp_s, 6)] = time.monotonic()
        self.poses.append((stamp_s, message.pose.pose))

    def _take_transform(self, message):
        self.transforms += [t for t in message.transforms if t.header.frame_id == "map"]

    def call(self, kind, name, request, timeout_s=20.0):
        client = self.create_client(kind, name)
        if not client.wait_for_service(timeout_s):
            raise TimeoutError(f"no service {name}")
        future = client.call_async(request)
        end_s = time.monotonic() + timeout_s
        while not future.done() and time.monotonic() < end_s:
            time.sleep(0.01)
        self.destroy_client(client)
        if not future.done():
            raise TimeoutError(f"no answer of {name}")
        return future.result()

    def turn(self, transition):
        request = ChangeState.Request(transition=Transition(id=transition))
        return self.call(ChangeState, "/amcl/change_state", request).success

    def bring_up(self):
        return self.turn(Transition.TRANSITION_CONFIGURE) and self.turn(Transition.TRANSITION_ACTIVATE)

    def state(self):
        return self.call(GetState, "/amcl/get_state", GetState.Request()).current_state.label

    def show_map(self, data):
        self._map.publish(data)

    def player(self, topic, kind):
        if topic not in self._players:
            message, qos = KINDS[kind]
            latched = topic == "/tf_static"
            self._players[topic] = self.create_publisher(message, topic, LATCHED if latched else qos)
        return self._players[topic]

    def meet(self, messages, timeout_s=20.0):
        """Waits until the node listens to every topic that is played."""
        players = [self.player(topic, kind) for _, topic, kind, _ in messages if kind in KINDS]
        wanted = [p for p in players if p.topic_name != "/odom"]
        end_s = time.monotonic() + timeout_s
        while any(p.get_subscription_count() < 1 for p in wanted):
            if time.monotonic() > end_s:
                raise TimeoutError("nobody listens")
            time.sleep(0.05)

    def play(self, messages, speed):
        """Returns when each scan was sent, by stamp: {stamp_s: monotonic}."""
        sent_s, begun_s, first_s = {}, time.monotonic(), messages[0][0]
        for stamp_s, topic, kind, data in messages:
            if kind not in KINDS:
                continue
            wait_s = begun_s + (stamp_s - first_s) / speed - time.monotonic()
            if wait_s > 0.0:
                time.sleep(wait_s)
            self.player(topic, kind).publish(data)
            if kind == "sensor_msgs/msg/LaserScan":
                sent_s[round(stamp_s, 6)] = time.monotonic()
        return sent_s

    def wait_for(self, condition, timeout_s=20.0):
        end_s = time.monotonic() + timeout_s
        while not condition() and time.monotonic() < end_s:
            time.sleep(0.02)
        return condition()

    def close(self):
        self._executor.shutdown()
        self._thread.join(5)
        self.destroy_node()


def begin():
    """A domain of its own, so that tests beside this one are not heard."""
    os.environ.setdefault("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))
    rclpy.init()
