"""Sensor modules: publish the body's streams on channels, without computation."""
