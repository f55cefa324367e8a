"""The node `slam`: makes a map while the robot drives, publishes it as it grows, and saves it."""

import time

from nav_msgs.msg import OccupancyGrid
from std_srvs.srv import Trigger

import parloc
from parloc_ros import parameters
from parloc_ros.robot_node import LATCHED, RobotNode
from parloc_ros.run_node import run_node


class Slam(RobotNode):
    """Answers every scan with a pose in the map that it makes."""

    def __init__(self, **options):
        super().__init__("slam", parameters.OF_SLAM, **options)

    def _begin(self):
        told = self._told
        self._robot = parloc.LiveSlam(self._config, odometry_topic=bool(told["odom_topic"]))
        self._drawn_s, self._taken_in = 0.0, 0
        self._map_topic = self._publish_on(OccupancyGrid, told["map_topic"], LATCHED)
        self._serve(Trigger, "save_map", self._save_map)

    def _end(self):
        if self._taken_in > 0 and self._told["map_file"]:
            self._save()

    def _say(self, answer):
        self._send_transform(answer)
        self._taken_in += answer.taken_in
        now_s = time.monotonic()
        if answer.taken_in and now_s - self._drawn_s >= self._told["map_update_interval"]:
            self._drawn_s = now_s
            self._map_topic.publish(parloc.map_message(self._robot.map_so_far(), answer.stamp_s, self._frames()[0]))

    def _save(self):
        """The path, or None and why it could not be written."""
        grid, path = self._robot.map_so_far(), self._told["map_file"]
        if grid is None:
            return None, "there is no map yet"
        if not path:
            return None, "map_file: expected the path of a YAML file"
        try:
            grid.save(path)
        except parloc.Error as error:
            self.get_logger().error(str(error))
            return None, str(error)
        self.get_logger().info(f"{path}: {grid.width} x {grid.height} cells")
        return path, ""

    def _save_map(self, request, response):
        path, why = self._save()
        response.success, response.message = path is not None, path or why
        return response


def main():
    """Runs the node until it is told to end."""
    return run_node(Slam)
