"""Notices scans that come late, whatever the clock of whoever stamps them."""

import collections


class Delay:
    """How much later than the promptest of the last minute a stamp comes, and whether time was set back.

    A recording that is played at another speed, or a LiDAR with a clock of its own, is not late.
    """

    REMEMBERED_S = 60.0
    SET_BACK_S = 1.0

    def __init__(self):
        self._promptest = collections.deque()  # (received, offset), both rising
        self._newest = None

    def of(self, received_s, stamp_s):
        """The delay in seconds, at least 0."""
        offset = received_s - stamp_s
        while self._promptest and self._promptest[-1][1] >= offset:
            self._promptest.pop()
        self._promptest.append((received_s, offset))
        while self._promptest[0][0] < received_s - self.REMEMBERED_S:
            self._promptest.popleft()
        return offset - self._promptest[0][1]

    def is_set_back(self, stamp_s):
        """Whether this stamp says that the clock was set back, or that a recording began anew."""
        back = self._newest is not None and stamp_s < self._newest - self.SET_BACK_S
        self._newest = stamp_s if back or self._newest is None else max(self._newest, stamp_s)
        return back

    def forget(self):
        """Time starts anew."""
        self._promptest.clear()
        self._newest = None
