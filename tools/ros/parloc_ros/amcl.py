"""The node `amcl`: localization in the place of nav2_amcl.

Messages go into parloc as the bytes that they came in, and its answers are bytes to be sent: what this node says is
what `parloc run` says of a bag of the same messages, to the bit.
"""

import math
import threading
import time

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid
from rcl_interfaces.msg import SetParametersResult
from rclpy.qos import qos_profile_sensor_data
from std_srvs.srv import Empty

import parloc
from parloc_ros import parameters
from parloc_ros.pose_file import PoseFile
from parloc_ros.robot_node import LATCHED, TRANSFORMS, RobotNode
from parloc_ros.run_node import run_node

HEALTH_EVERY_S = 1.0  # or sooner, when it changes


class Amcl(RobotNode):
    """Answers every scan with a pose."""

    def __init__(self, **options):
        super().__init__("amcl", parameters.OF_AMCL, **options)
        self._making = 0  # the number of what is wanted of those who work beside
        self.add_on_set_parameters_callback(self._on_parameters)

    def _begin(self):
        told = self._told
        self._robot = parloc.LiveLocalizer(self._config, odometry_topic=bool(told["odom_topic"]))
        self._map = self._fingerprint = self._new_fingerprint = None
        self._making += 1  # whoever works for a robot of before works in vain
        self._ready = None  # what was made beside
        self._changed = threading.Lock()
        self._pose_file = PoseFile(told["pose_file"], self.get_fully_qualified_name())
        self._last = None
        self._told_state, self._told_s = "", 0.0
        self._pose_topic = self._publish_on(PoseWithCovarianceStamped, "amcl_pose", LATCHED)
        self._health_topic = self._publish_on(DiagnosticArray, "/diagnostics", 10)
        self._listen(OccupancyGrid, told["map_topic"], self._take_map, LATCHED)
        self._listen(PoseWithCovarianceStamped, "initialpose", self._take_pose, TRANSFORMS, raw=False)
        self._serve(Empty, "reinitialize_global_localization", self._look_everywhere)
        self._serve(Empty, "request_nomotion_update", self._weigh_next)
        self._begin_with_nav2()
        if told["save_pose_rate"] > 0.0:
            self._every(max(1.0 / told["save_pose_rate"], 0.1), self._end)

    def _begin_with_nav2(self):
        """What has nav2's own messages; the service is younger than Humble."""
        self._cloud_topic = None
        try:
            from nav2_msgs.msg import ParticleCloud

            self._cloud_topic = self._publish_on(ParticleCloud, "particle_cloud", qos_profile_sensor_data)
            from nav2_msgs.srv import SetInitialPose

            self._serve(SetInitialPose, "set_initial_pose", self._set_pose)
        except ImportError as error:
            missing = "set_initial_pose" if self._cloud_topic else "particle_cloud and no set_initial_pose"
            self.get_logger().warning(f"no {missing}: {error}")

    def _end(self):
        """Keeps the last pose."""
        if self._last is None or self._fingerprint is None:
            return
        try:
            self._pose_file.write(self._fingerprint, *self._last)
        except OSError as error:
            self.get_logger().error(f"the pose is not kept: {error}", throttle_duration_sec=60.0)

    # ---- answers -----------------------------------------------------------------------------------------------------

    def _take(self, role, topic, data):
        with self._changed:
            ready, self._ready = self._ready, None
        if ready is not None:
            self._robot.put(ready)
            grid = self._map
            self.get_logger().info(f"on a map of {grid.width} x {grid.height} cells of {grid.resolution_m:g} m")
            self._start_if_new()
        super()._take(role, topic, data)

    def _say(self, answer):
        if answer.weighted:
            self._last = (tuple(answer.pose), answer.sigmas)
            self._pose_topic.publish(answer.pose_message(*self._frames()))
            if self._cloud_topic is not None and self._cloud_topic.get_subscription_count() > 0:
                most = self._told["max_shown_particles"]
                self._cloud_topic.publish(self._robot.particles_message(answer, *self._frames(), most))
        self._send_transform(answer)
        now_s = time.monotonic()
        if answer.state != self._told_state or now_s - self._told_s >= HEALTH_EVERY_S:
            self._told_state, self._told_s = answer.state, now_s
            self._health_topic.publish(answer.diagnostics_message(*self._frames(), self.get_fully_qualified_name()))

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
        """Makes what depends on map and settings beside; it takes over with the next message after it is done."""
        self._making += 1
        number, grid, robot = self._making, self._map, self._robot

        def make():
            try:
                ready = robot.prepare(config, grid)
            except parloc.Error as error:
                self.get_logger().error(f"{error}: the map before stays")
                return
            with self._changed:
                if number == self._making:
                    self._ready = ready

        threading.Thread(target=make, daemon=True).start()

    def _start_if_new(self):
        """With the first map: where the node was last, where the parameters say, or where the scans say."""
        same = self._fingerprint == self._new_fingerprint
        self._fingerprint = self._new_fingerprint
        if self._robot.started and (same or not self._told["always_reset_initial_pose"]):
            return
        told, log = self._told, self.get_logger()
        kept, why = self._pose_file.read(self._fingerprint) if told["resume_pose"] else (None, "")
        if why:
            log.warning(why)
        if kept is not None:
            (x, y, yaw), sigma = kept
            log.info(f"starting at ({x:.2f}, {y:.2f}, {yaw:.2f}), where the node was last")
            self._start((x, y, yaw), sigma=sigma)
        elif told["set_initial_pose"]:
            pose = (told["initial_pose.x"], told["initial_pose.y"], told["initial_pose.yaw"])
            self._start(pose, sigma=(self._config.initial_sigma_xy,) * 2 + (self._config.initial_sigma_theta,))
        elif told["find_initial_pose"]:
            log.info("no pose was given: looking on the whole map")
            self._robot.start()
        else:
            log.warning("a pose is wanted: send one on initialpose")

    def _start(self, pose, **spread):
        try:
            self._robot.start(pose, **spread)
        except parloc.Error as error:
            self.get_logger().error(str(error))

    # ---- what people and other nodes say -----------------------------------------------------------------------------

    def _take_pose(self, message):
        log, frame = self.get_logger(), self._told["global_frame_id"]
        if message.header.frame_id.lstrip("/") not in ("", frame):
            log.error(f"initialpose: expected a pose in {frame}, found {message.header.frame_id}")
            return
        place, turn = message.pose.pose.position, message.pose.pose.orientation
        if not abs(turn.w**2 + turn.x**2 + turn.y**2 + turn.z**2 - 1.0) < 1e-2:
            log.error("initialpose: expected a quaternion of unit length")
            return
        yaw = math.atan2(2.0 * (turn.w * turn.z + turn.x * turn.y), 1.0 - 2.0 * (turn.y**2 + turn.z**2))
        log.info(f"starting at ({place.x:.2f}, {place.y:.2f}, {yaw:.2f}), as was said")
        self._start((place.x, place.y, yaw), ros_covariance=message.pose.covariance.tolist())

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

    def _on_parameters(self, changed):
        if self._robot is None:
            return SetParametersResult(successful=True)
        fixed = [p.name for p in changed if p.name in parameters.NEEDS_CONFIGURE]
        if fixed:
            return SetParametersResult(successful=False, reason=f"{fixed[0]}: clean up the node first")
        try:
            told = parameters.read(self, self._own_parameters, changed)
            config = told.config()
        except (parloc.Error, TypeError) as error:
            return SetParametersResult(successful=False, reason=str(error))
        self._told = told
        if config != self._config:
            self._config = config
            if self._map is not None:
                self._make(config)
        return SetParametersResult(successful=True)


def main():
    """Runs the node until it is told to end."""
    return run_node(Amcl)
