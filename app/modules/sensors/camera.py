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
from app.runtime.module import ModuleContext


class Camera(StreamModule):
    """The body's ``camera`` stream on a channel."""

    title = "Camera"
    streams = MappingProxyType({"images": "camera"})

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.images = self.output("images", Image)

    async def start(self) -> None:
        """Attach to the body's stream. Raises ModuleFailed for a body without a camera."""
        self.relay("camera", self.images, lazy=True)
