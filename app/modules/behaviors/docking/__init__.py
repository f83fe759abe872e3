"""Docking: finding a dock with the laser, and driving into it until it charges."""
