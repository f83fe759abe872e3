"""The Recorder: channels on disk."""
