"""A robot whose topics are reached by rosbridge's WebSocket: neither ROS nor its libraries are needed here."""
