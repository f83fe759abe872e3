"""A camera's topics made into images: pictures, their calibration, and depth registered to them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose3
from app.base.joint_buffer import JointBuffer
from app.base.kinematic_model import KinematicModel
from app.logs.importers import ros_messages
from app.logs.importers.ros_camera import CameraInfo, PinholeCamera, fitted
from app.logs.importers.ros_messages import Unreadable
from app.messages import Image, read_only
from app.robots.ros2.config import CameraTopicConfig, DepthCameraTopicConfig

#: How far (s) a depth may be from its picture, as a share of the time between two pictures.
_APART = 0.5
#: Pose, in a camera's frame, of that of its pictures turned clockwise by a quarter: x along -y, y along x.
_QUARTER = Pose3(np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), np.zeros(3))


@dataclass(frozen=True, slots=True)
class CameraSetting:
    """``frame``: the link of the optical frame; ``rate_hz`` of its pictures; ``rectified``: they have no distortion;
    ``has_depth``: an image needs one; ``fov`` (rad, horizontal) of a camera without CameraInfo, else None;
    ``quarters``: turns by 90 degrees, clockwise, until pictures stand upright."""

    frame: str
    rate_hz: float
    rectified: bool = False
    has_depth: bool = False
    fov: float | None = None
    quarters: int = 0


def setting(camera: CameraTopicConfig) -> CameraSetting:
    """What the mapping says of ``camera``."""
    fov = camera.horizontal_fov_deg
    return CameraSetting(
        camera.link,
        camera.rate_hz,
        rectified=camera.is_rectified,
        has_depth=isinstance(camera, DepthCameraTopicConfig),
        fov=None if fov is None else math.radians(fov),
        quarters=camera.turned_deg // 90,
    )


class CameraReader:
    """Assembles the images of one camera. Its pose is that of its link, with the joints as they were at the stamp.

    A picture waits for its calibration and its depth, and is dropped where a newer one comes first.
    """

    def __init__(self, setting: CameraSetting, model: KinematicModel, joints: JointBuffer) -> None:
        """``joints`` is filled by others; it is asked only for a link that joints move."""
        self._setting = setting
        self._model = model
        self._joints = joints
        self._moves = bool(model.moved_by(setting.frame))
        self._info: Any = None
        self._cameras: dict[tuple[int, int], PinholeCamera] = {}
        self._picture: tuple[float, NDArray[np.uint8]] | None = None
        self._depth: tuple[float, NDArray[np.uint16]] | None = None

    def info(self, message: Any, at: float) -> None:
        """Take a CameraInfo; a changed one holds from the next picture on."""
        known = _values(message)
        if self._info is None or known != _values(self._info):
            self._info = message
            self._cameras.clear()

    def picture(self, message: Any, at: float) -> Image | None:
        """Take an Image or CompressedImage of time ``at`` (s); the image that is complete now. Raises Unreadable."""
        if self._setting.fov is None and self._info is None:
            return None
        self._picture = (at, ros_messages.color_image(message))
        return self._complete()

    def depth(self, message: Any, at: float) -> Image | None:
        """Take a depth of time ``at`` (s); the image that is complete now. Raises Unreadable."""
        self._depth = (at, ros_messages.depth_image(message))
        return self._complete()

    def _complete(self) -> Image | None:
        if self._picture is None:
            return None
        at, picture = self._picture
        depth: NDArray[np.uint16] | None = None
        if self._setting.has_depth:
            if self._depth is None or abs(self._depth[0] - at) > _APART / self._setting.rate_hz:
                return None
            depth = self._depth[1]
        positions = self._joints.at(at) if self._moves else {}
        if positions is None:
            return None
        self._picture = None
        camera = self._camera(picture.shape[1], picture.shape[0])
        if depth is not None:
            height, width = depth.shape
            depth = fitted(depth, camera.model)
            if depth is None:
                raise Unreadable(
                    f"a depth of {width} x {height} px is not registered to a picture of {camera.model.width} x "
                    f"{camera.model.height} px"
                )
            depth = camera.depth(depth)
        X_BC = self._model.pose(self._setting.frame, positions)
        image = Image(at, self._setting.frame, camera.color(picture), depth, camera=camera.model, X_BC=X_BC)
        for _ in range(self._setting.quarters):
            image = turned(image)
        depth = None if image.depth is None else read_only(np.ascontiguousarray(image.depth))
        return replace(image, color=read_only(np.ascontiguousarray(image.color)), depth=depth)

    def _camera(self, width: int, height: int) -> PinholeCamera:
        known = self._cameras.get((width, height))
        if known is None:
            try:
                known = PinholeCamera(
                    self._calibration(width, height), width, height, rectified=self._setting.rectified
                )
            except ValueError as failure:
                raise Unreadable(str(failure)) from None
            self._cameras[width, height] = known
        return known

    def _calibration(self, width: int, height: int) -> CameraInfo:
        if self._setting.fov is not None:
            f = 0.5 * width / math.tan(0.5 * self._setting.fov)
            K = np.array([[f, 0.0, 0.5 * (width - 1)], [0.0, f, 0.5 * (height - 1)], [0.0, 0.0, 1.0]])
            P = np.hstack([K, np.zeros((3, 1))])
            return CameraInfo(width, height, "plumb_bob", K=K, D=np.zeros(5), P=P)
        calibration = CameraInfo.of(self._info)
        if calibration is None:
            raise Unreadable("its CameraInfo says that it is not calibrated; horizontal_fov_deg does without one")
        return calibration


def turned(image: Image) -> Image:
    """``image`` turned clockwise by a quarter, its camera and its frame with it: each pixel is the same ray."""
    was = image.camera
    camera = replace(
        was, width=was.height, height=was.width, fx=was.fy, fy=was.fx, cx=was.height - 1 - was.cy, cy=was.cx
    )
    depth = None if image.depth is None else np.rot90(image.depth, -1)
    return replace(image, color=np.rot90(image.color, -1), depth=depth, camera=camera, X_BC=image.X_BC @ _QUARTER)


def _values(info: Any) -> tuple[Any, ...]:
    return (info.width, info.height, info.distortion_model, *map(tuple, (info.k, info.d, info.p)))
