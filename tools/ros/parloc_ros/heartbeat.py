"""The bond with nav2's lifecycle manager, which takes a node for dead whose heart does not beat.

The manager listens on `bond` of its own namespace, for the node's name; it waits 2 s for the first beat and 4 s for every
other, unless its bond_timeout says otherwise. What it says there itself needs no answer.
"""

import uuid

from rclpy.duration import Duration


class Heartbeat:
    """Says that the node is alive, as the package bond has it."""

    TIMEOUT_S = 4.0
    FAREWELL_S = 0.2  # at most, until the last word is heard

    def __init__(self, node, period_s):
        from bond.msg import Status  # not everybody has a lifecycle manager

        self._node = node
        self._status = Status(
            id=node.get_name(),
            instance_id=str(uuid.uuid4()),
            active=True,
            heartbeat_timeout=self.TIMEOUT_S,
            heartbeat_period=period_s,
        )
        self._publisher = node.create_publisher(Status, "bond", 100)
        self._timer = node.create_timer(period_s, self._beat)

    def _beat(self):
        self._status.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(self._status)

    def stop(self):
        """Says that the bond is broken on purpose, unless the node is ended and cannot say anything more."""
        self._status.active = False
        if self._node.context.ok():
            self._beat()
            self._publisher.wait_for_all_acked(Duration(seconds=self.FAREWELL_S))
        self._node.destroy_timer(self._timer)
        self._node.destroy_publisher(self._publisher)
