"""Checks that the ROS 2 of get_ros carries what a robot's topics carry, between two processes on the loopback.

A child process publishes transforms, scans (best effort), and a map that was there before its subscriber (transient local), and
is a lifecycle node. This process takes serialized messages, and changes the state of the child by its services.
Usage, after source FOLDER/env.sh: python3 loopback_test.py
"""

import collections
import subprocess
import sys
import time

import rclpy
import rclpy.lifecycle
from bond.msg import Status
from geometry_msgs.msg import TransformStamped
from lifecycle_msgs.msg import State, Transition
from lifecycle_msgs.srv import ChangeState, GetState
from nav2_msgs.msg import Particle, ParticleCloud
from nav2_msgs.srv import SetInitialPose
from nav_msgs.msg import OccupancyGrid
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

BEAMS = 1081
MAP_CELLS = 1000
LITTLE_ENDIAN_CDR = b"\x00\x01\x00\x00"
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
TOPICS = {
    "/tf": (TFMessage, QoSProfile(depth=100)),
    "/scan": (LaserScan, qos_profile_sensor_data),
    "/map": (OccupancyGrid, LATCHED),
    "/particle_cloud": (ParticleCloud, qos_profile_sensor_data),
    "/bond": (Status, QoSProfile(depth=100)),
}
WANTED = {"/tf": 100, "/scan": 80, "/map": 1, "/particle_cloud": 80, "/bond": 80}


class Robot(rclpy.lifecycle.LifecycleNode):
    """Publishes at 40 Hz once it is active; its map was published when it was configured."""

    def on_configure(self, state):
        self.senders = {topic: self.create_publisher(kind, topic, qos) for topic, (kind, qos) in TOPICS.items()}
        self.create_service(SetInitialPose, "set_initial_pose", lambda request, response: response)
        grid = OccupancyGrid(data=[0] * MAP_CELLS**2)
        grid.info.width = grid.info.height = MAP_CELLS
        self.senders["/map"].publish(grid)
        return rclpy.lifecycle.TransitionCallbackReturn.SUCCESS

    def on_activate(self, state):
        self.create_timer(1 / 40, self.publish_sensors)
        self.create_timer(1 / 50, lambda: self.senders["/tf"].publish(TFMessage(transforms=[TransformStamped()])))
        return super().on_activate(state)

    def publish_sensors(self):
        self.senders["/scan"].publish(LaserScan(ranges=[1.0] * BEAMS))
        self.senders["/particle_cloud"].publish(ParticleCloud(particles=[Particle(weight=0.5)]))
        self.senders["/bond"].publish(Status(id="robot", active=True))


def robot():
    rclpy.init()
    rclpy.spin(Robot("robot"))


def call(node, kind, service, request):
    client = node.create_client(kind, service)
    assert client.wait_for_service(20), f"no service {service}"
    future = client.call_async(request)
    rclpy.spin_until_future_complete(node, future, timeout_sec=20)
    assert future.done(), f"no answer of {service}"
    return future.result()


def change_state(node, transition, expected_state):
    request = ChangeState.Request(transition=Transition(id=transition))
    assert call(node, ChangeState, "/robot/change_state", request).success
    state = call(node, GetState, "/robot/get_state", GetState.Request()).current_state
    assert state.id == expected_state, state


def check():
    rclpy.init()
    node = rclpy.create_node("listener")
    change_state(node, Transition.TRANSITION_CONFIGURE, State.PRIMARY_STATE_INACTIVE)
    change_state(node, Transition.TRANSITION_ACTIVATE, State.PRIMARY_STATE_ACTIVE)
    received = collections.defaultdict(list)
    for topic, (kind, qos) in TOPICS.items():
        node.create_subscription(kind, topic, received[topic].append, qos, raw=True)
    end = time.monotonic() + 30
    while any(len(received[topic]) < count for topic, count in WANTED.items()):
        counts = {topic: len(messages) for topic, messages in received.items()}
        assert time.monotonic() < end, f"received {counts} within 30 s, not {WANTED}"
        rclpy.spin_once(node, timeout_sec=1)
    for topic, messages in received.items():
        for message in messages:
            assert isinstance(message, bytes) and message.startswith(LITTLE_ENDIAN_CDR), (topic, message[:8])
        print(topic, len(messages), "messages of", len(messages[0]), "bytes")
    assert len(deserialize_message(received["/scan"][0], LaserScan).ranges) == BEAMS
    assert deserialize_message(received["/particle_cloud"][0], ParticleCloud).particles[0].weight == 0.5
    assert deserialize_message(received["/bond"][0], Status).id == "robot"
    call(node, SetInitialPose, "/set_initial_pose", SetInitialPose.Request())
    change_state(node, Transition.TRANSITION_DEACTIVATE, State.PRIMARY_STATE_INACTIVE)
    change_state(node, Transition.TRANSITION_CLEANUP, State.PRIMARY_STATE_UNCONFIGURED)


if __name__ == "__main__":
    if sys.argv[1:] == ["robot"]:
        robot()
    else:
        child = subprocess.Popen([sys.executable, __file__, "robot"])
        try:
            check()
        finally:
            child.kill()
            child.wait()
