"""A robot for tests: true ROS 2 processes that play a bag, and listen to what a localization node says of it."""

import math
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
from rcl_interfaces.srv import SetParameters
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
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


class NodeProcess:
    """A node of parloc_ros in a process of its own."""

    def __init__(self, params_file, log_path, kind="amcl", *more):
        self._log = Path(log_path).open("w")  # noqa: SIM115
        code = f"from parloc_ros.{kind} import main; raise SystemExit(main())"
        command = [sys.executable, "-B", "-c", code, "--ros-args", "--params-file", str(params_file), *more]
        self.process = subprocess.Popen(command, stdout=self._log, stderr=subprocess.STDOUT)
        self.log_path = log_path

    def said(self):
        return Path(self.log_path).read_text()

    def kill(self):
        self.process.kill()
        self.process.wait(10)

    def end(self, by=signal.SIGINT):
        if self.process.poll() is None:
            self.process.send_signal(by)
            self.process.wait(20)
        self._log.close()


class World(Node):
    """Plays messages, keeps what the node answers, and turns its lifecycle. Spins in a thread of its own."""

    def __init__(self, hears_transforms=True, namespace=None):
        super().__init__("world", namespace=namespace)
        self.poses, self.transforms, self.arrived_s = [], [], {}
        self.create_subscription(PoseWithCovarianceStamped, "amcl_pose", self._take_pose, RELIABLE)
        if hears_transforms:
            self.create_subscription(TFMessage, "/tf", self._take_transform, RELIABLE)
        self.maps = []
        self._players = {}
        self._in_step = []  # scans of play_in_step that wait for odometry after them: (stamp_s, player, bytes)
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

    def hear_maps(self):
        """Where the node makes them."""
        self.create_subscription(OccupancyGrid, "map", self.maps.append, LATCHED)

    def call(self, kind, name, request, timeout_s=20.0):
        client = self.create_client(kind, name)
        try:
            if not client.wait_for_service(timeout_s):
                raise TimeoutError(f"no service {name}")
            future = client.call_async(request)
            if not self.wait_for(future.done, timeout_s):
                raise TimeoutError(f"no answer of {name}")
            return future.result()
        finally:
            self.destroy_client(client)

    def turn(self, transition, node="amcl"):
        request = ChangeState.Request(transition=Transition(id=transition))
        return self.call(ChangeState, f"{node}/change_state", request).success

    def wait_for_state(self, node="amcl"):
        """Of a node that is being started; one that was killed is still known for a while, and does not answer."""
        for _ in range(20):
            try:
                return self.call(GetState, f"{node}/get_state", GetState.Request(), 2.0).current_state.label
            except TimeoutError:
                continue
        return ""

    def bring_up(self, node="amcl"):
        self.wait_for_state(node)
        return self.turn(Transition.TRANSITION_CONFIGURE, node) and self.turn(Transition.TRANSITION_ACTIVATE, node)

    def state(self, node="amcl"):
        return self.call(GetState, f"{node}/get_state", GetState.Request()).current_state.label

    def set_parameter(self, name, value):
        request = SetParameters.Request(parameters=[Parameter(name, value=value).to_parameter_msg()])
        return self.call(SetParameters, "amcl/set_parameters", request).results[0]

    def send_pose(self, x_m, y_m, theta_rad):
        message = PoseWithCovarianceStamped()
        message.header.frame_id = "map"
        message.pose.pose.position.x, message.pose.pose.position.y = x_m, y_m
        message.pose.pose.orientation.z = math.sin(theta_rad / 2.0)
        message.pose.pose.orientation.w = math.cos(theta_rad / 2.0)
        for k, variance in ((0, 0.04), (7, 0.04), (35, 0.01)):
            message.pose.covariance[k] = variance
        self._initial.publish(message)

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
        """Returns when each message was sent, by topic and stamp: {(topic, stamp_s): monotonic}."""
        sent_s, begun_s, first_s = {}, time.monotonic(), messages[0][0]
        for stamp_s, topic, kind, data in messages:
            if kind not in KINDS:
                continue
            wait_s = begun_s + (stamp_s - first_s) / speed - time.monotonic()
            if wait_s > 0.0:
                time.sleep(wait_s)
            self.player(topic, kind).publish(data)
            sent_s[topic, round(stamp_s, 6)] = time.monotonic()
        return sent_s

    def play_in_step(self, messages, unanswered=()):
        """Goes on when the scans of before the odometry are answered: whatever else the machine does, the node takes the
        messages in this order. Returns the stamps of scans without an answer; the topics `unanswered` wait for none. Scans
        that wait for odometry at the end are waited for by the next call."""
        missing = []
        for stamp_s, topic, kind, data in messages:
            if kind not in KINDS:
                continue
            player = self.player(topic, kind)
            player.publish(data)
            if kind == "sensor_msgs/msg/LaserScan" and topic not in unanswered:
                self.arrived_s.pop(round(stamp_s, 6), None)
                self._in_step.append((round(stamp_s, 6), player, data))
            while topic == "/tf" and self._in_step and self._in_step[0][0] <= stamp_s:
                waiting = self._in_step.pop(0)
                if not self._is_answered(*waiting):
                    missing.append(waiting[0])
        return missing

    def _is_answered(self, stamp_s, player, data):
        """Scans are sent with best effort: on a busy machine one may be lost on its way, and is sent again. One that comes
        twice counts once."""
        for _ in range(6):
            if self.wait_for(lambda: stamp_s in self.arrived_s, 3.0):
                return True
            player.publish(data)
        return False

    def wait_for(self, condition, timeout_s=20.0):
        end_s = time.monotonic() + timeout_s
        while not condition() and time.monotonic() < end_s:
            time.sleep(0.02)
        return condition()

    def place_at(self, stamp_s):
        """The position that was said for that scan last."""
        return [pose for stamp, pose in self.poses if abs(stamp - stamp_s) < 1e-6][-1].position

    def close(self):
        self._executor.shutdown()
        self._thread.join(5)
        self.destroy_node()


def begin():
    """A domain of its own, so that tests beside this one are not heard."""
    os.environ["ROS_DOMAIN_ID"] = str(1 + os.getpid() % 100)
    rclpy.init()
