"""Types for rclpy that no installed package of ROS 2 holds."""
