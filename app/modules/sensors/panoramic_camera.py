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
from app.runtime.module import ModuleContext


class PanoramicCamera(StreamModule):
    """The body's ``panorama`` stream on a channel."""

    title = "Panoramic camera"
    streams = MappingProxyType({"images": "panorama"})

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.images = self.output("images", Image)

    async def start(self) -> None:
        """Attach to the body's stream. Raises ModuleFailed for a body without a panoramic camera."""
        self.relay("panorama", self.images, lazy=True)
