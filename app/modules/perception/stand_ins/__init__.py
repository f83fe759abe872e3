"""Modules that publish what a perception would, out of a simulated body's truth: for rehearsals and tests alone."""
