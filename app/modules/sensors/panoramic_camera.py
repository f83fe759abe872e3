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
from app.runtime.module import ModuleContext


class Imv(StreamModule):
    """The body's ``imv`` stream on a channel."""

    title = "Panoramic camera"
    streams = MappingProxyType({"images": "imv"})

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.images = self.output("images", Image)

    async def start(self) -> None:
        """Attach to the body's stream. Raises ModuleFailed for a body without a panoramic camera."""
        self.relay("imv", self.images, lazy=True)
