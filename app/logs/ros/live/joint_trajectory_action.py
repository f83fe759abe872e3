"""``control_msgs/action/FollowJointTrajectory``, by which many robots take joints' trajectories.

``control_msgs`` is not among ROS 2's wheels. The definition is that of the ROS 2 that is sourced, or of Humble to
Jazzy. Parts that stay empty (tolerances, joints of many degrees) do not show in what is sent.
"""

from __future__ import annotations

from typing import Any

from app.logs.ros import typestore
from app.logs.ros.live.graph import installed_definition

FOLLOW = "control_msgs/action/FollowJointTrajectory"
_USED = {
    "control_msgs/msg/JointTolerance": "string name\nfloat64 position\nfloat64 velocity\nfloat64 acceleration\n",
    "control_msgs/msg/JointComponentTolerance": (
        "string joint_name\nuint16 component\nfloat64 position\nfloat64 velocity\nfloat64 acceleration\n"
    ),
}
_OF_JAZZY = """\
trajectory_msgs/JointTrajectory trajectory
trajectory_msgs/MultiDOFJointTrajectory multi_dof_trajectory
control_msgs/JointTolerance[] path_tolerance
control_msgs/JointComponentTolerance[] component_path_tolerance
control_msgs/JointTolerance[] goal_tolerance
control_msgs/JointComponentTolerance[] component_goal_tolerance
builtin_interfaces/Duration goal_time_tolerance
---
int32 error_code
string error_string
---
std_msgs/Header header
string[] joint_names
trajectory_msgs/JointTrajectoryPoint desired
trajectory_msgs/JointTrajectoryPoint actual
trajectory_msgs/JointTrajectoryPoint error
string[] multi_dof_joint_names
trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_desired
trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_actual
trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_error
"""


def follow_joint_trajectory() -> type[Any]:
    """The action's class for rclpy. Raises app.logs.ros.live.classes.Unsupported."""
    from app.logs.ros.live.actions import action_class

    for name, text in _USED.items():
        typestore.add(name, installed_definition(f"{name}.msg") or text)
    return action_class(FOLLOW, installed_definition(f"{FOLLOW}.action") or _OF_JAZZY)
