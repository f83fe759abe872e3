"""The thesis's experiments and our own, each run unattended: `hbba experiment NAME`."""
