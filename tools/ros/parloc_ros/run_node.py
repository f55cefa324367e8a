"""Runs a node in a process of its own."""

import rclpy
from rclpy.executors import ExternalShutdownException


def run_node(kind):
    """Until somebody ends it."""
    rclpy.init()
    node = kind()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
