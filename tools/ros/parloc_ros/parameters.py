"""The node's parameters: all of nav2_amcl's, with its defaults, and parloc's own beside them.

nav2's are handed to parloc as the text of a parameter file, so that they mean here what docs/nav2.md says.
"""

import json
from dataclasses import dataclass

from rcl_interfaces.msg import ParameterDescriptor

import parloc

# What a robot needs to be told besides nav2's: name, default, meaning.
OWN = [
    ("parloc_config", "", "a configuration file of parloc; what nav2's parameters say goes over it"),
    ("odom_topic", "", "a topic of nav_msgs/Odometry; empty: odometry is the transform odom_frame_id -> base"),
    ("max_scan_delay", 1.0, "a scan that comes so much later than others is dropped [s]"),
    ("threads", 0, "of a step; 0: all cores"),
    ("backend", "auto", "auto, cpu or cuda"),
]
OF_AMCL = [
    *OWN,
    ("find_initial_pose", True, "look for the robot on the whole map where no pose was given"),
    ("resume_pose", True, "start where the node was last on this map, if pose_file says so"),
    ("pose_file", "", "where the pose is kept; empty: ~/.ros/parloc/<node>.json"),
    ("max_shown_particles", 2000, "of particle_cloud"),
]
OF_SLAM = [
    *OWN,
    ("map_file", "", "where the map is saved: by the service save_map, and when the node ends; a YAML file"),
    ("map_update_interval", 5.0, "the map is published so often while it grows [s]"),
]

# Whoever changes one of these while the node runs changes what it listens to or how it starts.
NEEDS_CONFIGURE = {
    "base_frame_id", "odom_frame_id", "scan_topic", "map_topic", "odom_topic", "use_sim_time", "pose_file",
    "first_map_only", "bond_heartbeat_period", "save_pose_rate",
}  # fmt: skip


def value_of(text):
    """A parameter's default as ROS has it: bool, int, float or str."""
    try:
        return json.loads(text)
    except ValueError:
        return text


def declare(node, own):
    """Declares every parameter that is not declared yet: nav2's, and the node's own."""
    for name, default, meaning in own:
        if not node.has_parameter(name):
            node.declare_parameter(name, default, ParameterDescriptor(description=meaning))
    for name, default, meaning in parloc.nav2_parameters():
        if not node.has_parameter(name):
            descriptor = ParameterDescriptor(description=meaning, dynamic_typing=True)
            node.declare_parameter(name, value_of(default), descriptor)


@dataclass(frozen=True)
class Parameters:
    """What the node was told, in words and types of its own."""

    values: dict

    def __getitem__(self, name):
        return self.values[name]

    def nav2_yaml(self):
        """nav2's own as a parameter file, JSON being YAML."""
        told = {name: self.values[name] for name, _, _ in parloc.nav2_parameters()}
        return json.dumps({"amcl": {"ros__parameters": told}})

    def config(self):
        """All of it as parloc's configuration. Raises parloc.ConfigError with one line."""
        base = parloc.read_config(self["parloc_config"]) if self["parloc_config"] else None
        config = parloc.Config.from_yaml(self.nav2_yaml(), "the node's parameters", base)
        config.localize.first_search_at_once = False  # scans are answered meanwhile
        config.threads = self["threads"]
        config.backend = self["backend"]
        return config


def read(node, own, changed=()):
    """The parameters as they are, or as they would be with those in `changed`."""
    names = [name for name, _, _ in own] + [name for name, _, _ in parloc.nav2_parameters()]
    values = {name: node.get_parameter(name).value for name in names}
    values.update({parameter.name: parameter.value for parameter in changed})
    return Parameters(values)
