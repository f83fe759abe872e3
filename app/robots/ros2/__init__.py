"""A robot that speaks ROS 2: its topics as streams, its motors behind our guard, in a process that holds rclpy."""
