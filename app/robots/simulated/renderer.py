"""Drawing with OpenGL: one context for every camera of the body, on the processor or a card.

A camera's image is one or several perspective views. Shapes hidden by walls or
outside a view are culled: without a graphics card each drawn shape costs as much as a thousand pixels.
"""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose3
from app.robots.simulated.body import VISUAL_GROUP
from app.robots.simulated.frame_buffers import FrameBuffers
from app.robots.simulated.gl import UNUSABLE_GL, GlUnavailable
from app.robots.simulated.occlusion import Occlusion
from app.robots.simulated.world import CAMERA_GROUP, WORLD_GROUP

_MAX_GEOMS = 4000
_SHOWN_GROUPS = (WORLD_GROUP, CAMERA_GROUP, VISUAL_GROUP)
_CULLED_GROUP = 5
_SURFACE_PX = 16
"""Of the context's own surface, which nothing is drawn on."""
_STILL = 1e-4
"""Motion (m, rad) that counts as none: a twentieth of a pixel, a tenth of what depth resolves."""
_LAYERS = 5
"""Within which the order of drawing is the model's: sorting all shapes would cost more than it saves."""
_CORNERS = np.array([(x, y, z) for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])


@dataclass(frozen=True, slots=True, eq=False)
class WorldSnapshot:
    """The world at one instant: ``qpos`` of the whole model, ``mocap`` (n, 7) the poses (position, quaternion w first)
    of the scripted bodies, and the camera's measured pose. Its image ends so many ``periods`` of the stream.
    """

    stamp: float
    qpos: NDArray[np.float64]
    mocap: NDArray[np.float64]
    X_BC: Pose3
    periods: int = 1

    @staticmethod
    def initial(model: mujoco.MjModel) -> WorldSnapshot:
        mocap = mocap_poses(mujoco.MjData(model))
        return WorldSnapshot(0.0, model.qpos0.copy(), mocap, Pose3.identity())


@dataclass(frozen=True, slots=True, eq=False)
class PerspectiveView:
    """A perspective image of ``width`` x ``height`` (px) from the camera's position.

    ``rotation`` (3, 3): its axes (right, up, backwards) in the camera's (right, up, backwards). ``left``, ``right``,
    ``bottom``, ``top``: tangents of the angles from its forward axis to its edges.
    """

    rotation: NDArray[np.float64]
    left: float
    right: float
    bottom: float
    top: float
    width: int
    height: int


@dataclass(frozen=True, slots=True, eq=False)
class ViewState:
    """All that a picture of one view depends on: the camera's pose, the poses of shapes and lights, and which shapes
    (ngeom,) touch the view.
    """

    camera: NDArray[np.float64]
    shapes: NDArray[np.float64]
    lights: NDArray[np.float64]
    seen: NDArray[np.bool_]

    def differs(self, drawn: ViewState) -> bool:
        """Whether the camera, a light, or a shape seen in either, has another pose than in ``drawn``."""
        if _moved(self.camera, drawn.camera) or _moved(self.lights, drawn.lights):
            return True
        seen = self.seen | drawn.seen
        return _moved(self.shapes[seen], drawn.shapes[seen])


def _moved(a: NDArray[np.float64], b: NDArray[np.float64]) -> bool:
    return bool(np.abs(a - b).max(initial=0.0) > _STILL)


def _rectangle(view: PerspectiveView) -> mujoco.MjrRect:
    return mujoco.MjrRect(0, 0, view.width, view.height)


def mocap_poses(data: mujoco.MjData) -> NDArray[np.float64]:
    """The poses (n, 7) of scripted bodies, to be kept in a Snapshot."""
    return np.hstack((data.mocap_pos, data.mocap_quat))


class Renderer:
    """Draws ``model`` into frame buffers. Make, use and close it in one thread.

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
        self._buffers = FrameBuffers(self._context)
        self._context.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR
        self._scene = mujoco.MjvScene(self._model, maxgeom=_MAX_GEOMS)
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = 0
        self._scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = 0
        self._option = mujoco.MjvOption()
        self._option.geomgroup[:] = [group in _SHOWN_GROUPS for group in range(6)]
        self._unmoved = mujoco.MjvPerturb()
        self._groups = self._model.geom_group.copy()
        self._shown = np.isin(self._groups, _SHOWN_GROUPS)
        mujoco.mj_kinematics(self._model, self._data)
        self._occlusion = Occlusion(self._model, self._data)
        # Corners (ngeom, 8, 3) of each shape's box, in the shape's axes
        boxes = self._model.geom_aabb[:, None]
        self._corners = boxes[..., :3] + _CORNERS * boxes[..., 3:]
        self._placed: WorldSnapshot | None = None
        self._shapes = self._lights = np.zeros((0, 0))
        self._unhidden: dict[int, NDArray[np.intp]] = {}
        self._touching: dict[tuple[int, PerspectiveView], NDArray[np.bool_]] = {}
        self.near = self._model.vis.map.znear * self._model.stat.extent
        self.far = self._model.vis.map.zfar * self._model.stat.extent

    def draw(self, snapshot: WorldSnapshot, camera: int, view: PerspectiveView) -> None:
        """Draw ``view`` of the world in ``snapshot`` from the model's camera number ``camera``; any drawn before is
        lost."""
        self._set(snapshot)
        eye, axes = self._data.cam_xpos[camera], self._data.cam_xmat[camera].reshape(3, 3)
        self._scene.ngeom = 0
        for layer in self._layers(camera, view):
            self._model.geom_group[:] = _CULLED_GROUP
            self._model.geom_group[layer] = self._groups[layer]
            mujoco.mjv_addGeoms(
                self._model, self._data, self._option, self._unmoved, mujoco.mjtCatBit.mjCAT_ALL, self._scene
            )
        self._aim(eye, axes, view)
        self._gl.make_current()
        self._buffers.use(view.width, view.height)
        mujoco.mjr_render(_rectangle(view), self._scene, self._context)

    def _layers(self, camera: int, view: PerspectiveView) -> list[NDArray[np.intp]]:
        """The shapes in view, the nearest first: of what they hide, only the depth is compared. Planes come last."""
        shapes = np.flatnonzero(self._in_view(camera, view))
        offset = self._data.geom_xpos[shapes] - self._data.cam_xpos[camera]
        distance = np.where(self._model.geom_rbound[shapes] == 0, np.inf, (offset * offset).sum(axis=1))
        return np.array_split(shapes[np.argsort(distance, kind="stable")], _LAYERS)

    def view_state(self, snapshot: WorldSnapshot, camera: int, view: PerspectiveView) -> ViewState:
        """What a picture of ``view`` in ``snapshot`` from the model's camera number ``camera`` depends on."""
        self._set(snapshot)
        pose = np.append(self._data.cam_xpos[camera], self._data.cam_xmat[camera])
        return ViewState(pose, self._shapes, self._lights, self._in_view(camera, view))

    def read(self, view: PerspectiveView, color: NDArray[np.uint8], depth: NDArray[np.float32] | None = None) -> None:
        """The image of ``view``, drawn last, row 0 at the *bottom*: ``color`` (H, W, 3), ``depth`` (H, W) from 0 far to
        1."""
        self._buffers.read_color(color)
        if depth is not None:
            mujoco.mjr_readPixels(None, depth, _rectangle(view), self._context)

    def close(self) -> None:
        self._buffers.free()
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
        self._shapes = np.hstack((self._data.geom_xpos, self._data.geom_xmat))
        self._lights = np.hstack((self._data.light_xpos, self._data.light_xdir))
        self._unhidden.clear()
        self._touching.clear()

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
        mujoco.mjv_makeLights(self._model, self._data, self._scene)
        for light in self._scene.lights[: self._scene.nlight]:
            if light.headlight:  # shines where the camera looks, in each of its views alike: else there were seams
                light.dir[:] = -axes[:, 2]

    def _in_view(self, camera: int, view: PerspectiveView) -> NDArray[np.bool_]:
        """Which shapes (ngeom,) may touch the view: their spheres, then their boxes against its planes, and walls."""
        key = camera, view
        if key not in self._touching:
            self._touching[key] = self._find_in_view(camera, view)
        return self._touching[key]

    def _find_in_view(self, camera: int, view: PerspectiveView) -> NDArray[np.bool_]:
        eye, shapes = self._data.cam_xpos[camera], self._unhidden_from(camera)
        rotation = self._data.cam_xmat[camera].reshape(3, 3) @ view.rotation
        centers = (self._data.geom_xpos[shapes] - eye) @ rotation
        radius, ahead = self._model.geom_rbound[shapes], -centers[:, 2]
        touches = ahead > -radius
        for axis, low, high in ((0, view.left, view.right), (1, view.bottom, view.top)):
            touches &= centers[:, axis] - high * ahead < radius * math.hypot(1.0, high)
            touches &= low * ahead - centers[:, axis] < radius * math.hypot(1.0, low)
        near = np.flatnonzero(touches)
        boxes = shapes[near]
        axes = rotation.T @ self._data.geom_xmat[boxes].reshape(-1, 3, 3)
        touches[near] = self._boxes_touch(centers[near], axes, self._corners[boxes], view)
        # Planes are endless: they have neither sphere nor box
        touches |= radius == 0
        seen = np.zeros(self._model.ngeom, dtype=np.bool_)
        seen[shapes[touches]] = True
        return seen

    def _unhidden_from(self, camera: int) -> NDArray[np.intp]:
        """Numbers of the shapes that no wall hides from ``camera``."""
        if camera not in self._unhidden:
            hidden = self._occlusion.hidden(self._data.cam_xpos[camera], self._data.geom_xpos)
            self._unhidden[camera] = np.flatnonzero(~hidden & self._shown)
        return self._unhidden[camera]

    def _boxes_touch(
        self,
        centers: NDArray[np.float64],
        axes: NDArray[np.float64],
        corners: NDArray[np.float64],
        view: PerspectiveView,
    ) -> NDArray[np.bool_]:
        """Which boxes (n,) are not wholly beyond one of the view's planes: ``corners`` (n, 8, 3) in the shapes' axes,
        which are ``axes`` (n, 3, 3) at ``centers`` (n, 3) in the view's.
        """
        points = centers[:, None] + corners @ axes.transpose(0, 2, 1)
        x, y, ahead = points[..., 0], points[..., 1], -points[..., 2]
        beyond = [
            ahead < 0,
            x < view.left * ahead,
            x > view.right * ahead,
            y < view.bottom * ahead,
            y > view.top * ahead,
        ]
        return ~np.asarray(np.any([outside.all(axis=1) for outside in beyond], axis=0))
