"""Rendering of the body's cameras, and their sensor models.

A renderer draws in parts, so that a thread with several cameras can switch in between. A view is drawn again only where
something in it moved; without a visible change, the last image comes with fresh noise.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Protocol

import mujoco
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from app.robots.simulated.body import PREFIX
from app.robots.simulated.camera_models import fisheye_model
from app.robots.simulated.color_noise import ColorNoise
from app.robots.simulated.fisheye import Tile, Tiling, tile
from app.robots.simulated.kinect_noise import KinectNoise
from app.robots.simulated.renderer import PerspectiveView, Renderer, ViewState, WorldSnapshot
from app.robots.stream_config import KinectConfig, PanoramicCameraConfig, StreamsConfig


class CameraRenderer(Protocol):
    def draw(self, snapshot: WorldSnapshot) -> Iterator[None]:
        """Draw ``snapshot``; each step is a part of the work, of a few milliseconds."""

    def measure(self, color: NDArray[np.uint8], depth: NDArray[np.uint16] | None) -> None:
        """Write the sensor's output for the last image."""


class ChangeDetector:
    """Detects visible changes of one view of a camera."""

    def __init__(self, renderer: Renderer, camera: int, view: PerspectiveView) -> None:
        self._renderer = renderer
        self._camera = camera
        self._view = view
        self._drawn: ViewState | None = None

    def changed(self, snapshot: WorldSnapshot) -> bool:
        """Whether ``snapshot`` differs visibly from the last one that did; the first one does."""
        state = self._renderer.view_state(snapshot, self._camera, self._view)
        if self._drawn is not None and not state.differs(self._drawn):
            return False
        self._drawn = state
        return True


class KinectRenderer:
    """Colour and depth in one perspective image."""

    def __init__(self, renderer: Renderer, model: mujoco.MjModel, config: KinectConfig, rng: Generator) -> None:
        self._renderer = renderer
        self._camera = model.camera(PREFIX + "kinect").id
        self._noise = KinectNoise(config, rng)
        width, height = config.width, config.height
        x, y = (float(s) for s in model.cam_sensorsize[self._camera] / (2 * model.cam_intrinsic[self._camera][:2]))
        self._view = PerspectiveView(np.eye(3), -x, right=x, bottom=-y, top=y, width=width, height=height)
        self._color = np.zeros((height, width, 3), dtype=np.uint8)
        self._depth = np.zeros((height, width), dtype=np.float32)
        # The depth buffer is affine in 1/z, with 0 at the far plane and 1 at the near one
        self._scale = np.float32((renderer.far - renderer.near) / (renderer.far * renderer.near))
        self._offset = np.float32(1.0 / renderer.far)
        self._watch = ChangeDetector(renderer, self._camera, self._view)
        #: How often it was drawn.
        self.drawn = 0

    def draw(self, snapshot: WorldSnapshot) -> Iterator[None]:
        if self._watch.changed(snapshot):
            self._renderer.draw(snapshot, self._camera, self._view)
            self._renderer.read(self._view, self._color, self._depth)
            self.drawn += 1
        yield

    @property
    def picture(self) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """Colour (H, W, 3) uint8 RGB and inverse depth (H, W) float32 1/m along the optical axis, row 0 on top."""
        inverse_depth = self._depth[::-1] * self._scale
        inverse_depth += self._offset
        return self._color[::-1], inverse_depth

    def measure(self, color: NDArray[np.uint8], depth: NDArray[np.uint16] | None) -> None:
        """Colour with noise and depth as a Kinect measures it."""
        assert depth is not None
        picture, inverse_depth = self.picture
        self._noise.color(picture, color)
        self._noise.depth(inverse_depth, depth)


class FisheyeRenderer:
    """The panoramic camera: five perspective images. It is set up with its first image: without demand it costs no
    start time.
    """

    def __init__(
        self, renderer: Renderer, model: mujoco.MjModel, config: PanoramicCameraConfig, rng: Generator
    ) -> None:
        self._renderer = renderer
        self._camera = model.camera(PREFIX + "panorama").id
        self._config = config
        self._rng = rng
        self._tiling: Tiling | None = None
        self._watches: dict[Tile, ChangeDetector] = {}
        self.picture = np.zeros((config.height, config.width, 3), dtype=np.uint8)
        #: How often any of its views was drawn.
        self.drawn = 0
        self._drawn: NDArray[np.uint8]
        self._noise: ColorNoise

    def draw(self, snapshot: WorldSnapshot) -> Iterator[None]:
        """Draw ``snapshot``, one view in each step."""
        if self._tiling is None:
            self._tiling = self._set_up()
            yield
        # All at first: another camera may draw its own snapshot between the parts
        changed = [piece for piece, watch in self._watches.items() if watch.changed(snapshot)]
        for piece in changed:
            self._renderer.draw(snapshot, self._camera, piece.view)
            self._read(piece)
            yield
        if changed:
            self._tiling.picture(self._drawn, self.picture)
            self.drawn += 1
        yield

    def measure(self, color: NDArray[np.uint8], depth: NDArray[np.uint16] | None) -> None:
        """Colour with noise; black outside the lens's image."""
        assert self._tiling is not None
        self._noise.add(self.picture, color, self._tiling.seen)

    def _read(self, piece: Tile) -> None:
        """Copy one view out of its frame buffer, in which another may be drawn next."""
        view = piece.view
        self._renderer.read(view, self._drawn[piece.y : piece.y + view.height, piece.x : piece.x + view.width])

    def _set_up(self) -> Tiling:
        c = self._config
        tiling = tile(fisheye_model(c))
        self._drawn = np.zeros((tiling.height, tiling.width, 3), dtype=np.uint8)
        self._noise = ColorNoise(c.height, c.width, c.color_noise, self._rng)
        for piece in tiling.tiles:
            self._watches[piece] = ChangeDetector(self._renderer, self._camera, piece.view)
        return tiling


def open_renderers(
    renderer: Renderer, model: mujoco.MjModel, streams: StreamsConfig, rngs: Mapping[str, Generator]
) -> dict[str, CameraRenderer]:
    """The cameras of ``streams``, by stream, each with its own random numbers; OpenGL is ready when it returns."""
    renderers: dict[str, CameraRenderer] = {}
    kinect, panorama = streams.kinect, streams.panorama
    if kinect is not None:
        kinect_renderer = renderers["kinect"] = KinectRenderer(renderer, model, kinect, rngs["kinect"])
        for _ in kinect_renderer.draw(WorldSnapshot.initial(model)):  # OpenGL makes itself ready with the first picture
            pass
    if panorama is not None:
        renderers["panorama"] = FisheyeRenderer(renderer, model, panorama, rngs["panorama"])
    return renderers
