"""The nodes of the picture around the robot's camera: strips of a curved screen, fed only while it is shown."""

from __future__ import annotations

import math

import cv2
import numpy as np
import viser
from numpy.typing import NDArray

from app.base.geometry import Pose3
from app.console.view.scene_state import Picture
from app.console.view.screen import RADIUS_M, CurvedScreen, curved_screen

_QUALITY = 70


class Screens:
    """Pictures bent for the screen, once for all viewers. For one thread."""

    def __init__(self) -> None:
        self._of: Picture | None = None
        self._screen: CurvedScreen | None = None
        self._strips: list[NDArray[np.uint8]] = []

    def of(self, picture: Picture) -> tuple[CurvedScreen, list[NDArray[np.uint8]]] | None:
        """The screen, and what each strip shows; None for a picture that cannot be read."""
        if self._of is not picture:
            before, self._of, self._strips = self._of, picture, []
            # A camera by its own values: another picture brings another object.
            if before is None or (before.camera, before.image.width) != (picture.camera, picture.image.width):
                self._screen = curved_screen(picture.camera, picture.image.width, picture.image.height)
            decoded = cv2.imdecode(np.frombuffer(picture.image.jpeg, np.uint8), cv2.IMREAD_COLOR)
            if decoded is not None and self._screen is not None:
                self._strips = self._screen.strips(
                    cv2.cvtColor(decoded, cv2.COLOR_BGR2RGB).astype(np.uint8, copy=False)
                )
        return None if self._screen is None or not self._strips else (self._screen, self._strips)


class Screen:
    """The screen of one viewer, below the node ``world`` of its ``client``."""

    def __init__(self, client: viser.ClientHandle, world: str, screens: Screens) -> None:
        self._scene = client.scene
        self._name = f"{world}/screen"
        self._screens = screens
        self._frame = client.scene.add_frame(self._name, show_axes=False, visible=False)
        self._images: list[viser.ImageHandle] = []
        self._shape: CurvedScreen | None = None
        self._drawn: Picture | None = None
        self._shown = False

    def draw(self, picture: Picture | None, *, shown: bool) -> int:
        """Show ``picture`` where it was taken, or nothing. Returns how many parts were new."""
        bent = self._screens.of(picture) if shown and picture is not None and picture is not self._drawn else None
        if bent is not None and picture is not None:
            self._drawn = picture
            screen, strips = bent
            self._place(picture.X_OC)
            self._fill(screen, strips)
        visible = shown and picture is not None and self._drawn is not None
        if visible != self._shown:
            self._shown = self._frame.visible = visible
        return int(bent is not None)

    def _place(self, X_OC: Pose3) -> None:
        self._frame.wxyz, self._frame.position = np.array(X_OC.quaternion_wxyz()), X_OC.translation

    def _fill(self, screen: CurvedScreen, strips: list[NDArray[np.uint8]]) -> None:
        if screen is not self._shape:
            self._shape = screen
            for image in self._images:
                image.remove()
            self._images = [self._strip(screen, number, strip) for number, strip in enumerate(strips)]
            return
        for image, strip in zip(self._images, strips, strict=True):
            image.image = strip

    def _strip(self, screen: CurvedScreen, number: int, strip: NDArray[np.uint8]) -> viser.ImageHandle:
        azimuth = screen.azimuths[number]
        return self._scene.add_image(
            f"{self._name}/{number}",
            strip,
            *screen.size,
            format="jpeg",
            jpeg_quality=_QUALITY,
            # About the downward axis of the picture.
            wxyz=(math.cos(azimuth / 2), 0.0, math.sin(azimuth / 2), 0.0),
            position=(RADIUS_M * math.sin(azimuth), screen.below, RADIUS_M * math.cos(azimuth)),
            cast_shadow=False,
            receive_shadow=False,
        )
