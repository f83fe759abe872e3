"""What the robot can do with its base and body: each behavior proposes, the arbiter disposes."""
