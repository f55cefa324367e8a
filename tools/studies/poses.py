"""Poses in the plane, as tuples: x [m], y [m], heading [rad]."""

import math


def wrap(angle_rad):
    return (angle_rad + math.pi) % (2 * math.pi) - math.pi


def compose(a, b):
    s, c = math.sin(a[2]), math.cos(a[2])
    return a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], wrap(a[2] + b[2])


def relative(a, b):
    """Pose a seen from pose b."""
    s, c, dx, dy = math.sin(b[2]), math.cos(b[2]), a[0] - b[0], a[1] - b[1]
    return c * dx + s * dy, -s * dx + c * dy, wrap(a[2] - b[2])
