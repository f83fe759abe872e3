"""Experiments of the thesis and of this project, each run unattended: `hbba experiment NAME`."""
