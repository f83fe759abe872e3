"""Voices: localization, tracking, speech detection and separation of sound sources with a microphone array."""
