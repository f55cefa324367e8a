"""Runs a node in a process of its own."""

import os
import signal
import sys
import threading

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions


def run_node(kind):
    """Until somebody ends it by SIGINT or SIGTERM, as `ros2 launch` does. rclpy's own handlers would shut everything down at
    once; here the node can still say its last words, and keep what is to be kept. Returns the exit code."""
    told, tell = os.pipe()  # of whoever ends it
    os.set_blocking(tell, False)
    signal.set_wakeup_fd(tell)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: None)
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node, executor = kind(), SingleThreadedExecutor()
    executor.add_node(node)
    broken = []

    def spin():
        try:
            executor.spin()
        except ExternalShutdownException:
            pass
        except Exception:
            broken.append(True)
            sys.excepthook(*sys.exc_info())
        finally:
            os.write(tell, b"\0")

    thread = threading.Thread(target=spin)
    thread.start()
    os.read(told, 1)
    executor.shutdown()
    thread.join()
    node.end()
    node.destroy_node()
    rclpy.try_shutdown()
    return 1 if broken else 0
