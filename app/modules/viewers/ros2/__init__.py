"""The program in a graph of ROS 2: its channels as topics, and what others may ask of it."""
