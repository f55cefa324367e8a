"""What the nodes have in common: a lifecycle, and a robot's messages taken as the bytes that they came in."""

import time

from lifecycle_msgs.srv import ChangeState
from nav_msgs.msg import Odometry
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn
from rclpy.qos import QoSDurabilityPolicy, QoSProfile, QoSReliabilityPolicy
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

import parloc
from parloc_ros import parameters
from parloc_ros.delay import Delay
from parloc_ros.heartbeat import Heartbeat

LATCHED = QoSProfile(depth=1, reliability=QoSReliabilityPolicy.RELIABLE, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
TRANSFORMS = QoSProfile(depth=100)
FIXED_TRANSFORMS = QoSProfile(depth=100, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
# More than a second of scans: what comes too late is dropped by the node, in words, and not on the way.
SCANS = QoSProfile(depth=100, reliability=QoSReliabilityPolicy.BEST_EFFORT)


def refuse_what_cannot_be(node):
    """A transition that the node's state does not have is answered with no. rclpy before Kilted lets the node die of it, and
    nav2's lifecycle manager asks for some: it deactivates whatever there is when one of its nodes is gone."""
    (service,) = (service for service in node.services if service.srv_type is ChangeState)
    change = service.callback

    def change_or_refuse(request, response):
        try:
            return change(request, response)
        except RuntimeError as error:
            node.get_logger().warning(f"no transition {request.transition.id} from here: {error}")
            response.success = False
            return response

    service.callback = change_or_refuse


class RobotNode(LifecycleNode):
    """Configure makes topics and services, activate lets answers out, cleanup takes all of it down again.

    A node says in _begin() what takes the messages (self._robot) and what else it needs, in _say() what it makes of an
    answer, and in _end() what is to be kept.
    """

    def __init__(self, name, own_parameters, **options):
        super().__init__(name, **options)
        self._own_parameters = own_parameters
        parameters.declare(self, own_parameters)
        self._made = []  # publishers, subscriptions, services, timers: as (destroyer, thing)
        self._robot = None
        self._active = False
        self._heartbeat = None
        refuse_what_cannot_be(self)
        if self.get_parameter("autostart_node").value:
            self._autostart = self.create_timer(0.0, self._start_itself)

    # ---- the lifecycle -----------------------------------------------------------------------------------------------

    def on_configure(self, state):
        """Reads the parameters, and listens."""
        self._delay, self._dropped = Delay(), 0
        try:
            self._told = parameters.read(self, self._own_parameters)
            self._config = self._told.config()
            self._begin()
        except (parloc.Error, TypeError) as error:
            self.get_logger().error(str(error))
            self._take_down()
            return TransitionCallbackReturn.FAILURE
        self._tf_topic = self._publish_on(TFMessage, "/tf", TRANSFORMS)
        self._listen_to_robot()
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state):
        """Lets answers out."""
        self._active = True
        if self._told["bond_heartbeat_period"] > 0.0:
            try:
                self._heartbeat = Heartbeat(self, self._told["bond_heartbeat_period"])
            except ImportError:
                self.get_logger().warning("no bond with a lifecycle manager: the package bond is not installed")
        return super().on_activate(state)

    def on_deactivate(self, state):
        """Goes on listening."""
        self._rest()
        return super().on_deactivate(state)

    def on_cleanup(self, state):
        """As if it had not been configured."""
        self._take_down()
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, state):
        """For good."""
        self._rest()
        self._take_down()
        return TransitionCallbackReturn.SUCCESS

    def on_error(self, state):
        """Can be configured again."""
        self._rest()
        self._take_down()
        return TransitionCallbackReturn.SUCCESS

    def end(self):
        """The process ends: keeps what is to be kept, and tells the lifecycle manager."""
        self._rest()

    def _start_itself(self):
        self.destroy_timer(self._autostart)
        if self.trigger_configure() == TransitionCallbackReturn.SUCCESS:
            self.trigger_activate()

    def _rest(self):
        self._active = False
        if self._heartbeat is not None:
            self._heartbeat.stop()
            self._heartbeat = None
        if self._robot is not None:
            self._end()

    def _take_down(self):
        for destroy, made in self._made:
            destroy(made)
        self._made.clear()
        self._robot = None

    # ---- topics ------------------------------------------------------------------------------------------------------

    def _publish_on(self, kind, topic, qos):
        publisher = self.create_publisher(kind, topic, qos)
        self._made.append((self.destroy_publisher, publisher))
        return publisher

    def _listen(self, kind, topic, callback, qos, raw=True):
        subscription = self.create_subscription(kind, topic, callback, qos, raw=raw)
        self._made.append((self.destroy_subscription, subscription))

    def _serve(self, kind, name, callback):
        self._made.append((self.destroy_service, self.create_service(kind, name, callback)))

    def _every(self, period_s, callback):
        self._made.append((self.destroy_timer, self.create_timer(period_s, callback)))

    def _listen_to_robot(self):
        def take_as(role, topic):
            return lambda data: self._take(role, topic, data)

        self._listen(TFMessage, "/tf", take_as("transforms", "/tf"), TRANSFORMS)
        self._listen(TFMessage, "/tf_static", take_as("fixed_transforms", "/tf_static"), FIXED_TRANSFORMS)
        for topic in filter(None, (name.strip() for name in self._told["scan_topic"].split(","))):
            self._listen(LaserScan, topic, lambda data, topic=topic: self._take_scan(topic, data), SCANS)
        topic = self._told["odom_topic"]
        if topic:
            self._listen(Odometry, topic, take_as("odometry", topic), TRANSFORMS)

    # ---- messages in, answers out ------------------------------------------------------------------------------------

    def _frames(self):
        return self._told["global_frame_id"], self._told["odom_frame_id"]

    def _take(self, role, topic, data):
        answers = self._robot.take(role, topic, data)
        for trouble in self._robot.troubles():
            self.get_logger().warning(trouble)
        if self._active:
            for answer in answers:
                self._say(answer)

    def _take_scan(self, topic, data):
        stamp_s = parloc.stamp_of_message(data)
        if stamp_s is not None and not self._is_in_time(topic, stamp_s):
            return
        self._take("scan", topic, data)

    def _is_in_time(self, topic, stamp_s):
        log = self.get_logger()
        if self._delay.is_set_back(stamp_s):
            log.warning(f"{topic}: time was set back to {stamp_s:.3f} s: going on from the last pose")
            self._robot.forget()
            self._delay.forget()
        late_s = self._delay.of(time.monotonic(), stamp_s)
        if late_s <= self._told["max_scan_delay"]:
            return True
        self._dropped += 1
        if self._dropped & (self._dropped - 1) == 0:  # the first, the second, the fourth...
            log.warning(f"{topic}: a scan came {late_s:.2f} s late: dropped ({self._dropped} so far)")
        return False

    def _send_transform(self, answer):
        if self._told["tf_broadcast"]:
            self._tf_topic.publish(answer.map_odom_message(*self._frames(), self._told["transform_tolerance"]))
