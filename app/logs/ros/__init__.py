"""Our messages as ROS 2 types in CDR and back, without ROS: what a recording is made of (docs/recording-format.md)."""
