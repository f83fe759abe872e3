"""The 3D view: viser behind our own origin (``/viser/``)."""
