"""Drawing with OpenGL: one context and one frame buffer for every camera of the body, on the processor or a card.

A camera's image is one or several perspective views in rectangles of the frame buffer, read back at once. Shapes hidden
by walls or outside a view are culled: without a graphics card each drawn shape costs as much as a thousand pixels.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Iterable
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose3
from app.robots.simulated.body import VISUAL_GROUP
from app.robots.simulated.gl import UNUSABLE_GL, GlUnavailable
from app.robots.simulated.occlusion import Occlusion
from app.robots.simulated.world import OUT_OF_REACH_GROUP, WORLD_GROUP

_MAX_GEOMS = 4000
_SHOWN_GROUPS = (WORLD_GROUP, OUT_OF_REACH_GROUP, VISUAL_GROUP)
_CULLED_GROUP = 5
_SURFACE_PX = 16
"""Of the context's own surface, which nothing is drawn on."""
_STILL = 1e-6
"""Motion (m, rad) that counts as none: a hundredth of a millimetre at the end of the corridor."""


@dataclass(frozen=True, slots=True, eq=False)
class WorldSnapshot:
    """The world at one instant: ``qpos`` of the whole model, ``mocap`` (n, 7) the poses (position, quaternion w first)
    of the scripted bodies, and the camera's measured pose.
    """

    stamp: float
    qpos: NDArray[np.float64]
    mocap: NDArray[np.float64]
    X_BC: Pose3

    @staticmethod
    def initial(model: mujoco.MjModel) -> WorldSnapshot:
        mocap = mocap_poses(mujoco.MjData(model))
        return WorldSnapshot(0.0, model.qpos0.copy(), mocap, Pose3.identity())


@dataclass(frozen=True, slots=True)
class FrameRect:
    """A rectangle of the frame buffer (px), counted from its lower left."""

    x: int
    y: int
    width: int
    height: int


@dataclass(frozen=True, slots=True, eq=False)
class PerspectiveView:
    """A perspective image from the camera's position, drawn at ``place``.

    ``rotation`` (3, 3): its axes (right, up, backwards) in the camera's (right, up, backwards). ``left``, ``right``,
    ``bottom``, ``top``: tangents of the angles from its forward axis to its edges.
    """

    rotation: NDArray[np.float64]
    left: float
    right: float
    bottom: float
    top: float
    place: FrameRect


def mocap_poses(data: mujoco.MjData) -> NDArray[np.float64]:
    """The poses (n, 7) of scripted bodies, to be kept in a Snapshot."""
    return np.hstack((data.mocap_pos, data.mocap_quat))


class Renderer:
    """Draws ``model`` into a frame buffer that grows with what is reserved. Make, use and close it in one thread.

    Raises GlUnavailable where there is no OpenGL to draw with.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        self._model = copy.copy(model)  # a copy: culling moves shapes between groups
        self._data = mujoco.MjData(self._model)
        try:
            self._gl = mujoco.GLContext(_SURFACE_PX, _SURFACE_PX)
        except (ImportError, RuntimeError) as failure:
            raise GlUnavailable(UNUSABLE_GL.format(why=str(failure).splitlines()[0])) from None
        self._gl.make_current()
        self._context = mujoco.MjrContext(self._model, mujoco.mjtFontScale.mjFONTSCALE_100)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        self._context.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR
        self._scene = mujoco.MjvScene(self._model, maxgeom=_MAX_GEOMS)
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = 0
        self._scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = 0
        self._option = mujoco.MjvOption()
        self._option.geomgroup[:] = [group in _SHOWN_GROUPS for group in range(6)]
        self._camera = mujoco.MjvCamera()
        self._camera.type = mujoco.mjtCamera.mjCAMERA_FIXED
        self._groups = self._model.geom_group.copy()
        mujoco.mj_kinematics(self._model, self._data)
        self._occlusion = Occlusion(self._model, self._data)
        # Scripted body of each shape, -1 for none: they are all direct children of the world
        self._scripted = self._model.body_mocapid[self._model.body_rootid[self._model.geom_bodyid]]
        self._placed: WorldSnapshot | None = None
        self._unhidden: dict[int, NDArray[np.bool_]] = {}
        self.near = self._model.vis.map.znear * self._model.stat.extent
        self.far = self._model.vis.map.zfar * self._model.stat.extent

    def reserve(self, width: int, height: int) -> None:
        """Enlarge the frame buffer (px) if necessary; its content is lost."""
        width, height = max(width, self._context.offWidth), max(height, self._context.offHeight)
        if (width, height) != (self._context.offWidth, self._context.offHeight):
            self._gl.make_current()
            mujoco.mjr_resizeOffscreen(width, height, self._context)

    def draw(self, snapshot: WorldSnapshot, camera: int, view: PerspectiveView) -> None:
        """Draw ``view`` of the world in ``snapshot`` from the model's camera number ``camera``."""
        self._set(snapshot)
        eye, axes = self._data.cam_xpos[camera], self._data.cam_xmat[camera].reshape(3, 3)
        self._model.geom_group[:] = np.where(self._in_view(camera, view), self._groups, _CULLED_GROUP)
        self._camera.fixedcamid = camera
        mujoco.mjv_updateScene(
            self._model, self._data, self._option, None, self._camera, mujoco.mjtCatBit.mjCAT_ALL, self._scene
        )
        self._aim(eye, axes, view)
        place = view.place
        self._gl.make_current()
        mujoco.mjr_render(mujoco.MjrRect(place.x, place.y, place.width, place.height), self._scene, self._context)

    def seen(self, snapshot: WorldSnapshot, camera: int, views: Iterable[PerspectiveView]) -> NDArray[np.bool_]:
        """Which shapes (ngeom,) may be in any of ``views`` from that camera."""
        self._set(snapshot)
        return np.asarray(np.any([self._in_view(camera, view) for view in views], axis=0))

    def differ(self, a: WorldSnapshot, b: WorldSnapshot, seen: NDArray[np.bool_]) -> bool:
        """Whether the robot, or any of the shapes ``seen`` (ngeom,), has another pose in ``a`` than in ``b``."""
        if np.abs(a.qpos - b.qpos).max(initial=0.0) > _STILL:
            return True
        moved = np.append(np.abs(a.mocap - b.mocap).max(axis=1, initial=0.0) > _STILL, False)
        return bool((moved[self._scripted] & seen).any())

    def read(self, place: FrameRect, color: NDArray[np.uint8], depth: NDArray[np.float32] | None = None) -> None:
        """The image at ``place``, row 0 at the *bottom*: ``color`` (H, W, 3), ``depth`` (H, W) from 0 far to 1."""
        rectangle = mujoco.MjrRect(place.x, place.y, place.width, place.height)
        mujoco.mjr_readPixels(color, depth, rectangle, self._context)

    def close(self) -> None:
        self._context.free()
        self._gl.free()

    def _set(self, snapshot: WorldSnapshot) -> None:
        if snapshot is self._placed:
            return
        self._data.qpos[:] = snapshot.qpos
        self._data.mocap_pos[:] = snapshot.mocap[:, :3]
        self._data.mocap_quat[:] = snapshot.mocap[:, 3:]
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_camlight(self._model, self._data)
        self._placed = snapshot
        self._unhidden.clear()

    def _aim(self, eye: NDArray[np.float64], axes: NDArray[np.float64], view: PerspectiveView) -> None:
        rotation = axes @ view.rotation
        for camera in self._scene.camera:
            camera.pos[:] = eye
            camera.forward[:] = -rotation[:, 2]
            camera.up[:] = rotation[:, 1]
            camera.frustum_center = 0.5 * (view.left + view.right) * self.near
            camera.frustum_width = 0.5 * (view.right - view.left) * self.near
            camera.frustum_bottom, camera.frustum_top = view.bottom * self.near, view.top * self.near
            camera.frustum_near, camera.frustum_far = self.near, self.far
        for light in self._scene.lights[: self._scene.nlight]:
            if light.headlight:  # shines where the camera looks, in each of its views alike: else there were seams
                light.dir[:] = -axes[:, 2]

    def _in_view(self, camera: int, view: PerspectiveView) -> NDArray[np.bool_]:
        """Which shapes (ngeom,) may touch the view: their bounding spheres against its five planes, and the walls."""
        eye = self._data.cam_xpos[camera]
        rotation = self._data.cam_xmat[camera].reshape(3, 3) @ view.rotation
        if camera not in self._unhidden:
            self._unhidden[camera] = ~self._occlusion.hidden(eye, self._data.geom_xpos)
        centers = (self._data.geom_xpos - eye) @ rotation
        radius, ahead = self._model.geom_rbound, -centers[:, 2]
        seen = ahead > -radius
        for axis, low, high in ((0, view.left, view.right), (1, view.bottom, view.top)):
            seen &= centers[:, axis] - high * ahead < radius * math.hypot(1.0, high)
            seen &= low * ahead - centers[:, axis] < radius * math.hypot(1.0, low)
        seen |= radius == 0  # planes are endless and have no bounding sphere
        return np.asarray(seen & self._unhidden[camera])
