"""Imv: the panoramic camera (immersive video), a full hemisphere in front (thesis 4.2).

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ Imv    out  images  Image, 10 Hz, 1024 x 768, fisheye, in imv_optical_frame, no depth    │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

Computes nothing: the body's stream ``imv`` is published unchanged, and only while a subscription is open.
"""

from __future__ import annotations

from types import MappingProxyType

from app.messages import Image
from app.modules.stream_module import StreamModule


class Imv(StreamModule):
    title = "Panoramic camera"
    relays = MappingProxyType({"images": ("imv", Image)})
