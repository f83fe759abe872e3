"""Camera: a plain colour camera.

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ Camera    out  images  Image, as the camera gives it, in camera_optical_frame, no depth  │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

Computes nothing: the body's stream ``camera`` is published unchanged, and only while a subscription is open.
"""

from __future__ import annotations

from types import MappingProxyType

from app.messages import Image
from app.modules.stream_module import StreamModule


class Camera(StreamModule):
    title = "Camera"
    relays = MappingProxyType({"images": ("camera", Image)})
