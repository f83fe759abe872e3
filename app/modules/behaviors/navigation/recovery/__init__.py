"""Recovery behaviors: what is tried when the robot does not advance."""
