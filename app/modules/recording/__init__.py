"""The Recorder: what the robot lives, on disk."""
