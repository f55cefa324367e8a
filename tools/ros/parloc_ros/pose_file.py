"""The robot's last pose on disk, for a node that is killed and started again."""

import hashlib
import json
import math
import os
from pathlib import Path


class PoseFile:
    """One pose with its spread, and the map that it is in."""

    def __init__(self, path, node_name):
        name = node_name.strip("/").replace("/", "_") or "amcl"
        self.path = Path(path).expanduser() if path else Path.home() / ".ros" / "parloc" / f"{name}.json"

    @staticmethod
    def fingerprint(map_bytes):
        """Of a map message without its header, whose stamp changes."""
        return hashlib.sha256(map_bytes[-max(1, len(map_bytes) - 100) :]).hexdigest()

    def write(self, fingerprint, pose, sigma):
        """Replaces the file as a whole: a node that is killed meanwhile leaves the one before. Raises OSError."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        beside = self.path.with_suffix(f".{os.getpid()}.tmp")
        beside.write_text(json.dumps({"map": fingerprint, "pose": list(pose), "sigma": list(sigma)}))
        os.replace(beside, self.path)

    def read(self, fingerprint):
        """(pose, sigma) on that map, or None and why there is none."""
        try:
            kept = json.loads(self.path.read_text())
            pose, sigma = [float(v) for v in kept["pose"]], [float(v) for v in kept["sigma"]]
            if len(pose) != 3 or len(sigma) != 3 or not all(map(math.isfinite, pose + sigma)):
                return None, f"{self.path}: expected a pose of three finite numbers"
        except FileNotFoundError:
            return None, ""
        except (OSError, ValueError, KeyError, TypeError) as error:
            return None, f"{self.path}: expected a pose that this node wrote: {error}"
        if kept.get("map") != fingerprint:
            return None, f"{self.path}: the pose in it is of another map"
        return (pose, sigma), ""
