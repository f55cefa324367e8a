"""The bond with nav2's lifecycle manager, which takes a node for dead whose heart does not beat."""

import uuid


class Heartbeat:
    """Says that the node is alive, as the package bond has it."""

    TIMEOUT_S = 4.0

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
        self._publisher = node.create_publisher(Status, "/bond", 100)
        self._timer = node.create_timer(period_s, self._beat)

    def _beat(self):
        self._status.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(self._status)

    def stop(self):
        """Says that the bond is broken on purpose."""
        self._status.active = False
        self._beat()
        self._node.destroy_timer(self._timer)
        self._node.destroy_publisher(self._publisher)
