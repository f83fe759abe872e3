"""PanoramicCamera: a full hemisphere in front (thesis 4.2, where it is called IMV, immersive video).

    ┌──────────────────────────────────────────────────────────────────────────────────────────────┐
    │ PanoramicCamera    out  images  Image, 10 Hz, 1024 x 768, fisheye, in panorama_optical_frame │
    └──────────────────────────────────────────────────────────────────────────────────────────────┘

Computes nothing: the body's stream ``panorama`` is published unchanged, without depth, and only while a subscription is
open.
"""

from __future__ import annotations

from types import MappingProxyType

from app.messages import Image
from app.modules.stream_module import StreamModule


class PanoramicCamera(StreamModule):
    title = "Panoramic camera"
    relays = MappingProxyType({"images": ("panorama", Image)})
