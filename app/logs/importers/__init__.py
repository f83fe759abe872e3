"""Logs that other programs wrote, read as if they were ours: ROS 1 and ROS 2 bags, CARMEN laser logs."""
