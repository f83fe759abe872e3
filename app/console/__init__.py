"""The operator console: REST, live stream, control lease, the 3D view, and the page, at one address."""
