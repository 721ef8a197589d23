"""Start the node; `ros2 launch pianta_ros rooms.launch.py map:=/map building_type:=office`."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description() -> LaunchDescription:
    """The node and its arguments."""
    return LaunchDescription(
        [
            DeclareLaunchArgument("map", default_value="/map", description="Topic of nav_msgs/OccupancyGrid"),
            DeclareLaunchArgument("building_type", default_value="", description="Such as school; empty if unknown"),
            Node(
                package="pianta_ros",
                executable="rooms",
                name="pianta_rooms",
                output="screen",
                remappings=[("map", LaunchConfiguration("map"))],
                parameters=[{"building_type": LaunchConfiguration("building_type")}],
            ),
        ]
    )
