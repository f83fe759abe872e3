"""A camera's calibration from its CameraInfo, and its pictures rectified to a pinhole camera."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from app.base.geometry import CameraModel

#: Horizontal field of view (rad) of a Kinect, for a camera that nothing is said of.
_UNKNOWN_FOV = math.radians(57.0)
_FISHEYE = ("equidistant", "fisheye")


def assumed(width: int, height: int) -> CameraModel:
    """The camera of a picture that has no CameraInfo."""
    f = 0.5 * width / math.tan(0.5 * _UNKNOWN_FOV)
    return CameraModel(width, height, fx=f, fy=f, cx=0.5 * (width - 1), cy=0.5 * (height - 1))


@dataclass(frozen=True, slots=True, eq=False)
class CameraInfo:
    """A camera's calibration: matrix ``K`` (3, 3) px, distortion ``D`` (any length), ``P`` (3, 4) of rectified ones."""

    width: int
    height: int
    model: str
    K: NDArray[np.float64]
    D: NDArray[np.float64]
    P: NDArray[np.float64]

    @staticmethod
    def of(info: Any) -> CameraInfo | None:
        """The calibration of a sensor_msgs/CameraInfo; None for an uncalibrated camera."""
        upper = not hasattr(info, "k")  # ROS 1 names them D, K, R, P
        K, D, P = (
            np.array(getattr(info, name.upper() if upper else name), dtype=np.float64) for name in ("k", "d", "p")
        )
        if not K[0]:
            return None
        return CameraInfo(
            int(info.width),
            int(info.height),
            model=str(info.distortion_model),
            K=K.reshape(3, 3),
            D=D,
            P=P.reshape(3, 4),
        )


class PinholeCamera:
    """Pictures of one camera and one size (px), as a pinhole camera without distortion would have made them."""

    def __init__(self, calibration: CameraInfo | None, width: int, height: int, *, rectified: bool) -> None:
        """``rectified`` pictures have no distortion any more. Raises ValueError where sizes cannot belong together."""
        self.model = assumed(width, height)
        self._maps: tuple[NDArray[Any], NDArray[Any]] | None = None
        if calibration is None:
            return
        K = calibration.P[:, :3] if rectified and calibration.P[0, 0] else calibration.K
        if calibration.width and (calibration.width, calibration.height) != (width, height):
            scale = width / calibration.width
            if abs(scale * calibration.height - height) > 1:
                raise ValueError(
                    f"its CameraInfo is for {calibration.width} x {calibration.height} px, its pictures have "
                    f"{width} x {height}"
                )
            K = _scaled(K, scale)
        self.model = CameraModel(width, height, *(float(K[i]) for i in ((0, 0), (1, 1), (0, 2), (1, 2))))
        D = calibration.D
        if rectified or not np.any(D):
            return
        size = (width, height)
        if calibration.model in _FISHEYE:
            maps = cv2.fisheye.initUndistortRectifyMap(K, D[:4], np.eye(3), K, size, cv2.CV_16SC2)
        else:
            maps = cv2.initUndistortRectifyMap(K, D, np.eye(3), K, size, cv2.CV_16SC2)
        self._maps = (maps[0], maps[1])

    @property
    def undistorts(self) -> bool:
        """Whether pictures are changed."""
        return self._maps is not None

    def color(self, picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """(H, W, 3) as the pinhole camera would have seen it; black where it saw more than the real one."""
        if self._maps is None:
            return picture
        return np.asarray(cv2.remap(picture, *self._maps, cv2.INTER_LINEAR), np.uint8)

    def depth(self, picture: NDArray[np.uint16]) -> NDArray[np.uint16]:
        """(H, W) likewise, each pixel from the nearest one, since depths must not be mixed."""
        if self._maps is None:
            return picture
        return np.asarray(cv2.remap(picture, *self._maps, cv2.INTER_NEAREST), np.uint16)


def fitted(depth: NDArray[np.uint16], camera: CameraModel) -> NDArray[np.uint16] | None:
    """``depth`` brought to the size of ``camera`` by its nearest pixels; None where its shape is another."""
    height, width = depth.shape
    if (width, height) == (camera.width, camera.height):
        return depth
    if abs(width * camera.height - height * camera.width) > max(camera.width, camera.height):
        return None
    return np.asarray(cv2.resize(depth, (camera.width, camera.height), interpolation=cv2.INTER_NEAREST), np.uint16)


def _scaled(K: NDArray[np.float64], scale: float) -> NDArray[np.float64]:
    """``K`` for pictures ``scale`` times as large; (0, 0) stays the centre of the upper left pixel."""
    scaled = K * scale
    scaled[2, 2] = 1.0
    scaled[:2, 2] = (K[:2, 2] + 0.5) * scale - 0.5
    return scaled
