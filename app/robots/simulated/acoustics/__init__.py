"""The sound of the simulated world: rooms, the torso among the microphones, sounds, and what the microphones hear."""
