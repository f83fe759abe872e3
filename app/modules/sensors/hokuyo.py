"""Hokuyo: the laser range finder at 0.40 m above the ground (thesis 4.2: UTM-30LX).

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ Hokuyo    out  scans  LaserScan, 40 Hz, 720 rays over 180 deg, 30 m, in hokuyo_link      │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

Computes nothing: the body's stream ``hokuyo`` is published unchanged, and only while a subscription is open.
"""

from __future__ import annotations

from types import MappingProxyType

from app.messages import LaserScan
from app.modules.stream_module import StreamModule


class Hokuyo(StreamModule):
    title = "Hokuyo laser"
    relays = MappingProxyType({"scans": ("hokuyo", LaserScan)})
