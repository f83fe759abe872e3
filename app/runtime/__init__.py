"""The runtime: modules joined by bounded channels, each behind a rate filter, watched and metered.

Knows nothing of robots, sensors or attention; imports only ``app.messages`` and ``app.base``.
"""
