"""Camera: a plain colour camera.

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ Camera    out  images  Image, as the camera gives it, in camera_optical_frame, no depth  │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

Computes nothing: what the body's stream ``camera`` gives is published as it comes, and only while somebody wants it.
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
        """Listen to the body. Raises ModuleFailed for a body without one."""
        self.relay("camera", self.images, lazy=True)
