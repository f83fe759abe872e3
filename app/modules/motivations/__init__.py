"""What makes the robot want: motivations post desires into the Intention Workspace."""
