"""Localization on a map that somebody publishes: the node amcl, brought up by nav2's lifecycle manager."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare


def generate_launch_description():
    """As nav2_bringup's localization launch, with parloc_ros in the place of nav2_amcl."""
    params = LaunchConfiguration("params_file")
    sim_time = LaunchConfiguration("use_sim_time")
    shipped = PathJoinSubstitution([FindPackageShare("parloc_ros"), "config", "nav2_params.yaml"])
    return LaunchDescription(
        [
            DeclareLaunchArgument("params_file", default_value=shipped),
            DeclareLaunchArgument("use_sim_time", default_value="false"),
            Node(
                package="parloc_ros",
                executable="amcl",
                name="amcl",
                output="screen",
                parameters=[params, {"use_sim_time": sim_time}],
            ),
            Node(
                package="nav2_lifecycle_manager",
                executable="lifecycle_manager",
                name="lifecycle_manager_localization",
                output="screen",
                parameters=[{"autostart": True, "node_names": ["amcl"], "use_sim_time": sim_time}],
            ),
        ]
    )
