"""The live stream, ``/api/v1/live`` (docs/live-stream.md)."""
