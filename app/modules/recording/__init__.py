"""The Recorder: writes the program's channels to disk."""
