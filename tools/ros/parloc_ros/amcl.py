"""The node `amcl`: localization in the place of nav2_amcl.

Messages go into parloc as the bytes that they came in, and its answers are bytes to be sent: what this node says is
what `parloc run` says of a bag of the same messages, to the bit.
"""

import math
import threading
import time

import parloc
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from rcl_interfaces.msg import SetParametersResult
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn
from rclpy.qos import QoSDurabilityPolicy, QoSProfile, QoSReliabilityPolicy, qos_profile_sensor_data
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Empty
from tf2_msgs.msg import TFMessage

from parloc_ros import parameters
from parloc_ros.delay import Delay
from parloc_ros.heartbeat import Heartbeat
from parloc_ros.pose_file import PoseFile

LATCHED = QoSProfile(
    depth=1, reliability=QoSReliabilityPolicy.RELIABLE, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL
)
TRANSFORMS = QoSProfile(depth=100)
FIXED_TRANSFORMS = QoSProfile(depth=100, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
SCANS = QoSProfile(depth=10, reliability=QoSReliabilityPolicy.BEST_EFFORT)
HEALTH_EVERY_S = 1.0  # or sooner, when it changes


class Amcl(LifecycleNode):
    """Configure makes topics and services, activate lets answers out, cleanup takes all of it down again."""

    def __init__(self, **options):
        super().__init__("amcl", **options)
        parameters.declare(self)
        self._made = []  # publishers, subscriptions, services, timers: as (destroyer, thing)
        self._robot = None
        self._active = False
        self._heartbeat = None

    # ---- the lifecycle ---------------------------------------------------------------------------------------------

    def on_configure(self, state):
        self._told = parameters.read(self)
        try:
            self._config = self._told.config()
        except parloc.Error as error:
            self.get_logger().error(str(error))
            return TransitionCallbackReturn.FAILURE
        self._robot = parloc.LiveLocalizer(self._config, odometry_topic=bool(self._told["odom_topic"]))
        self._delay = Delay()
        self._dropped = 0
        self._map_bytes = self._map = self._fingerprint = None
        self._ready, self._making = None, 0  # a localizer that was made beside, and the number of the one wanted
        self._changed = threading.Lock()
        self._pose_file = PoseFile(self._told["pose_file"], self.get_fully_qualified_name())
        self._last = None
        self._told_state, self._told_s = "", 0.0
        self._make_publishers()
        self._make_subscriptions()
        self._make_services()
        self.add_on_set_parameters_callback(self._on_parameters)
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state):
        self._active = True
        if self._told["bond_heartbeat_period"] > 0.0:
            try:
                self._heartbeat = Heartbeat(self, self._told["bond_heartbeat_period"])
            except ImportError:
                self.get_logger().warning("no bond with a lifecycle manager: the package bond is not installed")
        return super().on_activate(state)

    def on_deactivate(self, state):
        self._active = False
        self._stop_heartbeat()
        self._save_pose()
        return super().on_deactivate(state)

    def on_cleanup(self, state):
        self._take_down()
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, state):
        self._active = False
        self._stop_heartbeat()
        self._save_pose()
        self._take_down()
        return TransitionCallbackReturn.SUCCESS

    def on_error(self, state):
        self._take_down()
        return TransitionCallbackReturn.SUCCESS

    def _stop_heartbeat(self):
        if self._heartbeat is not None:
            self._heartbeat.stop()
            self._heartbeat = None

    def _take_down(self):
        for destroy, made in self._made:
            destroy(made)
        self._made.clear()
        self.remove_on_set_parameters_callback(self._on_parameters)
        self._robot = None

    # ---- what is listened to, and what is said -----------------------------------------------------------------------

    def _publish_on(self, kind, topic, qos):
        publisher = self.create_publisher(kind, topic, qos)
        self._made.append((self.destroy_publisher, publisher))
        return publisher

    def _listen(self, kind, topic, callback, qos):
        subscription = self.create_subscription(kind, topic, callback, qos, raw=True)
        self._made.append((self.destroy_subscription, subscription))

    def _make_publishers(self):
        self._pose_topic = self._publish_on(PoseWithCovarianceStamped, "amcl_pose", LATCHED)
        self._tf_topic = self._publish_on(TFMessage, "/tf", TRANSFORMS)
        self._health_topic = self._publish_on(DiagnosticArray, "/diagnostics", 10)
        self._cloud_topic = None
        try:
            from nav2_msgs.msg import ParticleCloud
        except ImportError:
            self.get_logger().warning("no particle_cloud: the package nav2_msgs is not installed")
        else:
            self._cloud_topic = self._publish_on(ParticleCloud, "particle_cloud", qos_profile_sensor_data)

    def _make_subscriptions(self):
        told = self._told
        self._listen(TFMessage, "/tf", lambda data: self._take("transforms", "/tf", data), TRANSFORMS)
        self._listen(
            TFMessage, "/tf_static", lambda data: self._take("fixed_transforms", "/tf_static", data), FIXED_TRANSFORMS
        )
        for topic in filter(None, (name.strip() for name in told["scan_topic"].split(","))):
            self._listen(LaserScan, topic, lambda data, topic=topic: self._take_scan(topic, data), SCANS)
        if told["odom_topic"]:
            topic = told["odom_topic"]
            self._listen(Odometry, topic, lambda data: self._take("odometry", topic, data), TRANSFORMS)
        self._listen(OccupancyGrid, told["map_topic"], self._take_map, LATCHED)
        pose_kind = PoseWithCovarianceStamped
        subscription = self.create_subscription(pose_kind, "initialpose", self._take_pose, TRANSFORMS)
        self._made.append((self.destroy_subscription, subscription))
        if told["save_pose_rate"] > 0.0:
            period_s = max(1.0 / told["save_pose_rate"], 0.1)
            self._made.append((self.destroy_timer, self.create_timer(period_s, self._save_pose)))

    def _make_services(self):
        def serve(kind, name, callback):
            self._made.append((self.destroy_service, self.create_service(kind, name, callback)))

        serve(Empty, "reinitialize_global_localization", self._look_everywhere)
        serve(Empty, "request_nomotion_update", self._weigh_next)
        try:
            from nav2_msgs.srv import SetInitialPose
        except ImportError:
            self.get_logger().warning("no service set_initial_pose: the package nav2_msgs is not installed")
        else:
            serve(SetInitialPose, "set_initial_pose", self._set_pose)

    # ---- messages in, answers out ------------------------------------------------------------------------------------

    def _take(self, role, topic, data):
        with self._changed:
            ready, self._ready = self._ready, None
        if ready is not None:
            self._robot.put(ready)
            grid = self._map
            self.get_logger().info(f"on a map of {grid.width} x {grid.height} cells of {grid.resolution_m:g} m")
            self._start_if_new()
        answers = self._robot.take(role, topic, data)
        for trouble in self._robot.troubles():
            self.get_logger().warning(trouble)
        if not self._active:
            return
        for answer in answers:
            self._say(answer)

    def _take_scan(self, topic, data):
        stamp_s = parloc.stamp_of_message(data)
        if stamp_s is not None:
            if self._delay.is_set_back(stamp_s):
                self.get_logger().warning(f"{topic}: time was set back to {stamp_s:.3f} s: starting from the last pose")
                self._robot.forget()
                self._delay.forget()
            late_s = self._delay.of(time.monotonic(), stamp_s)
            if late_s > self._told["max_scan_delay"]:
                self._dropped += 1
                if self._dropped & (self._dropped - 1) == 0:  # the first, the second, the fourth...
                    self.get_logger().warning(f"{topic}: a scan came {late_s:.2f} s late: dropped ({self._dropped} so far)")
                return
        self._take("scan", topic, data)

    def _say(self, answer):
        told = self._told
        frames = (told["global_frame_id"], told["odom_frame_id"])
        if answer.weighted:
            self._last = (tuple(answer.pose), answer.sigmas)
            self._pose_topic.publish(answer.pose_message(*frames))
            if self._cloud_topic is not None and self._cloud_topic.get_subscription_count() > 0:
                self._cloud_topic.publish(self._robot.particles_message(answer, *frames, told["max_shown_particles"]))
        if told["tf_broadcast"]:
            self._tf_topic.publish(answer.map_odom_message(*frames, told["transform_tolerance"]))
        now_s = time.monotonic()
        if answer.state != self._told_state or now_s - self._told_s >= HEALTH_EVERY_S:
            self._told_state, self._told_s = answer.state, now_s
            self._health_topic.publish(answer.diagnostics_message(*frames, self.get_fully_qualified_name()))

    # ---- the map -----------------------------------------------------------------------------------------------------

    def _take_map(self, data):
        if self._told["first_map_only"] and self._map is not None:
            return
        try:
            grid = parloc.map_from_message(data, self._told["map_topic"])
        except parloc.Error as error:
            self.get_logger().error(f"{error}: the map before stays")
            return
        self._map, self._new_fingerprint = grid, PoseFile.fingerprint(data)
        self._make(self._config)

    def _make(self, config):
        """Makes a localizer beside, which takes over with the next message after it is done."""
        self._making += 1
        number, grid = self._making, self._map

        def make():
            try:
                ready = parloc.LiveLocalizer.prepare(config, grid)
            except parloc.Error as error:
                self.get_logger().error(f"{error}: the map before stays")
                return
            with self._changed:
                if number == self._making:
                    self._ready = ready

        threading.Thread(target=make, daemon=True).start()

    def _start_if_new(self):
        """With the first map: where a pose says, where the node was last, or where the scans say."""
        same = self._fingerprint == self._new_fingerprint
        self._fingerprint = self._new_fingerprint
        if self._robot.started and not (self._told["always_reset_initial_pose"] and not same):
            return
        told, log = self._told, self.get_logger()
        kept, why = self._pose_file.read(self._fingerprint) if told["resume_pose"] else (None, "")
        if why:
            log.warning(why)
        if kept is not None:
            pose, sigma = kept
            log.info(f"starting at ({pose[0]:.2f}, {pose[1]:.2f}, {pose[2]:.2f}), where the node was last")
            self._robot.start(pose, sigma)
        elif told["set_initial_pose"]:
            pose = (told["initial_pose.x"], told["initial_pose.y"], told["initial_pose.yaw"])
            self._start(pose, (self._config.initial_sigma_xy,) * 2 + (self._config.initial_sigma_theta,))
        elif told["find_initial_pose"]:
            log.info("no pose was given: looking on the whole map")
            self._robot.start()
        else:
            log.warning("a pose is wanted: send one on initialpose")

    def _start(self, pose, sigma):
        try:
            self._robot.start(pose, sigma)
        except parloc.Error as error:
            self.get_logger().error(str(error))

    # ---- what people and other nodes say -------------------------------------------------------------------------------

    def _take_pose(self, message):
        if message.header.frame_id.lstrip("/") not in ("", self._told["global_frame_id"]):
            self.get_logger().error(
                f"initialpose: expected a pose in {self._told['global_frame_id']}, found {message.header.frame_id}"
            )
            return
        place, turn = message.pose.pose.position, message.pose.pose.orientation
        norm = turn.w**2 + turn.x**2 + turn.y**2 + turn.z**2
        if not abs(norm - 1.0) < 1e-2:
            self.get_logger().error("initialpose: expected a quaternion of unit length")
            return
        yaw = math.atan2(2.0 * (turn.w * turn.z + turn.x * turn.y), 1.0 - 2.0 * (turn.y**2 + turn.z**2))
        variances = message.pose.covariance[0], message.pose.covariance[7], message.pose.covariance[35]
        self._start((place.x, place.y, yaw), [math.sqrt(max(v, 0.0)) for v in variances])

    def _set_pose(self, request, response):
        self._take_pose(request.pose)
        return response

    def _look_everywhere(self, request, response):
        self.get_logger().info("looking on the whole map, as was asked")
        self._robot.start()
        return response

    def _weigh_next(self, request, response):
        self._robot.weigh_next()
        return response

    def _save_pose(self):
        if self._last is None or self._fingerprint is None:
            return
        try:
            self._pose_file.write(self._fingerprint, *self._last)
        except OSError as error:
            self.get_logger().error(f"the pose is not kept: {error}", throttle_duration_sec=60.0)

    def _on_parameters(self, changed):
        fixed = [p.name for p in changed if p.name in parameters.NEEDS_CONFIGURE]
        if fixed:
            return SetParametersResult(successful=False, reason=f"{fixed[0]}: clean up the node first")
        told = parameters.read(self, changed)
        try:
            config = told.config()
        except parloc.Error as error:
            return SetParametersResult(successful=False, reason=str(error))
        except TypeError as error:
            return SetParametersResult(successful=False, reason=str(error))
        self._told = told
        if config != self._config:
            self._config = config
            if self._map is not None:
                self._make(config)
        return SetParametersResult(successful=True)


def main(args=None):
    """Runs the node until it is told to end."""
    rclpy.init(args=args)
    node = Amcl()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
