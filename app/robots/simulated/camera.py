"""The camera's thread: draws the world as the Kinect sees it, colour and depth in one pass, into the image ring.

Drawing takes longer than a control step and releases the interpreter's lock, so it has a thread of its own; the control
loop only leaves it a snapshot when it is free and picks up finished pictures: a computer too slow for the rate gives
fewer pictures, never late ones. The OpenGL context lives and dies in this thread, as it must.
"""

from __future__ import annotations

import copy
import math
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from app.geometry import Pose3
from app.robots.config import KinectConfig
from app.robots.simulated.body import CAMERA, PREFIX, VISUAL_GROUP
from app.robots.simulated.gl import UNUSABLE_GL, GlUnavailable
from app.robots.simulated.image_ring import SLOTS, ImageRing
from app.robots.simulated.kinect import KinectNoise
from app.robots.simulated.wire import ImageNotice
from app.robots.simulated.world import OUT_OF_REACH_GROUP, WORLD_GROUP

_MAX_GEOMS = 4000
_SHOWN_GROUPS = (WORLD_GROUP, OUT_OF_REACH_GROUP, VISUAL_GROUP)
_CULLED_GROUP = 5
_STILL = 1e-6
"""What counts as not having moved, in metres and radians: a hundredth of a millimetre at the end of the corridor."""


@dataclass(frozen=True, slots=True, eq=False)
class Snapshot:
    """The world at one instant: ``qpos`` of the whole model, and the camera's pose as measured then."""

    stamp: float
    qpos: NDArray[np.float64]
    X_BC: Pose3


class Camera:
    """Draws one fixed camera of ``model``; make, use and :meth:`close` it in one thread.

    Raises GlUnavailable where there is no OpenGL to draw with.
    """

    def __init__(self, model: mujoco.MjModel, width: int, height: int) -> None:
        self._model = copy.copy(model)  # its own: culling moves shapes between groups
        self._data = mujoco.MjData(self._model)
        self.drawn = 0
        self._viewport = mujoco.MjrRect(0, 0, width, height)
        try:
            self._gl = mujoco.GLContext(width, height)
        except (ImportError, RuntimeError) as failure:
            raise GlUnavailable(UNUSABLE_GL.format(why=str(failure).splitlines()[0])) from None
        self._gl.make_current()
        self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        self._context.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR
        self._scene = mujoco.MjvScene(model, maxgeom=_MAX_GEOMS)
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = 0
        self._scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = 0
        self._option = mujoco.MjvOption()
        self._option.geomgroup[:] = [group in _SHOWN_GROUPS for group in range(6)]
        self._view = mujoco.MjvCamera()
        self._view.type = mujoco.mjtCamera.mjCAMERA_FIXED
        self._view.fixedcamid = model.camera(PREFIX + CAMERA).id
        self._groups = model.geom_group.copy()
        self._slopes = model.cam_sensorsize[self._view.fixedcamid] / (
            2 * model.cam_intrinsic[self._view.fixedcamid][:2]
        )
        self._color = np.zeros((height, width, 3), dtype=np.uint8)
        self._depth = np.zeros((height, width), dtype=np.float32)
        near = model.vis.map.znear * model.stat.extent
        far = model.vis.map.zfar * model.stat.extent
        # The depth buffer is affine in 1/z, with 0 at the far plane and 1 at the near one
        self._scale, self._offset = (far - near) / (far * near), 1.0 / far

    def draw(self, qpos: NDArray[np.float64]) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """Colour (H, W, 3) uint8 RGB and inverse depth (H, W) float32 1/m along the optical axis, row 0 on top.

        Only the robot moves here: while it stands still the last picture is given again, undrawn.
        """
        if np.abs(qpos - self._data.qpos).max() > _STILL or not self.drawn:
            self._data.qpos[:] = qpos
            self._draw()
            self.drawn += 1
        inverse = np.asarray(self._depth[::-1] * np.float32(self._scale) + np.float32(self._offset))
        return self._color[::-1], inverse

    def _draw(self) -> None:
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_camlight(self._model, self._data)
        self._model.geom_group[:] = np.where(self._in_view(), self._groups, _CULLED_GROUP)
        mujoco.mjv_updateScene(
            self._model, self._data, self._option, None, self._view, mujoco.mjtCatBit.mjCAT_ALL, self._scene
        )
        self._gl.make_current()
        mujoco.mjr_render(self._viewport, self._scene, self._context)
        mujoco.mjr_readPixels(self._color, self._depth, self._viewport, self._context)

    def _in_view(self) -> NDArray[np.bool_]:
        """Which shapes (ngeom,) may touch the view: their bounding spheres against its five planes."""
        camera = self._view.fixedcamid
        centers = (self._data.geom_xpos - self._data.cam_xpos[camera]) @ self._data.cam_xmat[camera].reshape(3, 3)
        radius, ahead = self._model.geom_rbound, -centers[:, 2]
        seen = ahead > -radius
        for axis, slope in enumerate(self._slopes):
            seen &= np.abs(centers[:, axis]) - slope * ahead < radius * math.hypot(1.0, slope)
        return np.asarray(seen | (radius == 0))  # planes are endless and have no bounding sphere

    def close(self) -> None:
        """Release the OpenGL context."""
        self._context.free()
        self._gl.free()


class CameraThread:
    """Draws snapshots as they come. ``make_camera`` is called in the thread."""

    def __init__(
        self, model: mujoco.MjModel, config: KinectConfig, ring: ImageRing, rng: Generator, wake: Callable[[], None]
    ) -> None:
        self._model = model
        self._config = config
        self._ring = ring
        self._noise = KinectNoise(config, rng)
        self._wake = wake
        self._condition = threading.Condition()
        self._snapshot: Snapshot | None = None
        self._ending = False
        self._busy = False
        self._ready = threading.Event()
        self._count = 0
        self._thread = threading.Thread(target=self._run, name="camera", daemon=True)
        self.finished: deque[ImageNotice] = deque(maxlen=SLOTS - 1)
        self.failure: BaseException | None = None
        self._thread.start()

    def wait_ready(self, timeout_s: float) -> None:
        """Wait until it can draw; raises what went wrong in the thread, or TimeoutError."""
        if not self._ready.wait(timeout_s):
            raise TimeoutError(f"the camera could not be set up in {timeout_s:.0f} s")
        if self.failure is not None:
            raise self.failure

    @property
    def busy(self) -> bool:
        """Whether the last snapshot is not finished yet."""
        return self._busy

    def request(self, snapshot: Snapshot) -> None:
        """Have ``snapshot`` drawn; not while ``busy``."""
        with self._condition:
            self._busy = True
            self._snapshot = snapshot
            self._condition.notify()

    def close(self, timeout_s: float) -> None:
        """End the thread, waiting for a picture in work."""
        with self._condition:
            self._ending = True
            self._condition.notify()
        self._thread.join(timeout_s)

    def _run(self) -> None:
        try:
            camera = Camera(self._model, self._config.width, self._config.height)
            camera.draw(self._model.qpos0)
            self._ready.set()
            while (snapshot := self._next()) is not None:
                self._draw(camera, snapshot)
            camera.close()
        except BaseException as failure:  # noqa: BLE001  # handed to the control loop, which ends the process with it
            self.failure = failure
            self._ready.set()
            self._wake()

    def _next(self) -> Snapshot | None:
        with self._condition:
            while self._snapshot is None and not self._ending:
                self._condition.wait()
            snapshot, self._snapshot = self._snapshot, None
            return None if self._ending else snapshot

    def _draw(self, camera: Camera, snapshot: Snapshot) -> None:
        picture, inverse_depth = camera.draw(snapshot.qpos)
        slot = self._count % SLOTS
        self._count += 1
        color, depth = self._ring.begin(slot)
        self._noise.color(picture, color)
        self._noise.depth(inverse_depth, depth)
        sequence = 2 * self._count
        self._ring.finish(slot, sequence)
        self.finished.append(ImageNotice("kinect", slot, sequence, snapshot.stamp, snapshot.X_BC))
        with self._condition:
            self._busy = False
        self._wake()
