"""Behaviors of the base and body: each proposes a command, the arbiter selects one."""
