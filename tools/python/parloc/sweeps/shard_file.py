"""How far a shard is, told from its file alone: the trials that are whole in it (docs/shards.md)."""

from __future__ import annotations

import json
import struct
from pathlib import Path

_MAGIC = b"parloc shard\n"
_MARK = 0x4C414954
_BEFORE = struct.Struct("<IQdI")  # mark, item, seconds, number of bytes; then the bytes, and 4 of a checksum
_AFTER = 4


class ShardCount:
    """Counts the trials in a file that grows, without reading twice what it has seen. `parloc merge` checks them."""

    def __init__(self, path: Path):
        self._path = path
        self._at = 0
        self._expected: int | None = None
        self.trials = 0

    def update(self) -> int:
        """Trials that are there by now."""
        try:
            with self._path.open("rb") as file:
                if self._at == 0:
                    self._read_head(file)
                while self._at and self._skip_trial(file):
                    self.trials += 1
        except (OSError, ValueError, KeyError):  # not there yet, or none: then `parloc` says so itself
            pass
        return self.trials

    @property
    def is_whole(self) -> bool:
        """Whether all trials of the shard are there."""
        return self.update() == self._expected

    def _read_head(self, file) -> None:
        start = file.read(len(_MAGIC) + 12)
        if len(start) < len(_MAGIC) + 12 or not start.startswith(_MAGIC):
            return
        (size,) = struct.unpack_from("<Q", start, len(_MAGIC) + 4)
        text = file.read(size)
        if len(text) < size:
            return
        head = json.loads(text)
        self._expected = len(range(head["shard"] - 1, head["items"], head["of"]))
        self._at = len(start) + size

    def _skip_trial(self, file) -> bool:
        end = self._path.stat().st_size
        if end < self._at + _BEFORE.size + _AFTER:
            return False
        file.seek(self._at)
        mark, _, _, size = _BEFORE.unpack(file.read(_BEFORE.size))
        after = self._at + _BEFORE.size + size + _AFTER
        if mark != _MARK or after > end:
            return False
        self._at = after
        return True
