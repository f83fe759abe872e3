"""Kinect: colour and registered depth from the camera on the head (thesis 4.2).

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ Kinect    out  images  Image, 15 Hz, 640 x 480, in kinect_optical_frame, depth 0.4-5 m   │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

Computes nothing: the body's stream ``kinect`` is published unchanged, and only while a subscription is open. A closed
stream costs no rendering, transport or memory traffic: attention saves most here.
"""

from __future__ import annotations

from types import MappingProxyType

from app.messages import Image
from app.modules.stream_module import StreamModule


class Kinect(StreamModule):
    title = "Kinect"
    relays = MappingProxyType({"images": ("kinect", Image)})
