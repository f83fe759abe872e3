"""Camera models of a configured body: lens and image format, by stream. Used by both processes, without OpenGL."""

from __future__ import annotations

import math

from app.base.geometry import CameraModel, FisheyeModel
from app.robots.config import RobotConfig
from app.robots.simulated.image_ring import PictureFormat
from app.robots.simulated.kinect_noise import camera_model
from app.robots.stream_config import PanoramicCameraConfig


def fisheye_model(config: PanoramicCameraConfig) -> FisheyeModel:
    horizontal, vertical = (math.radians(angle) for angle in config.fov_deg)
    return FisheyeModel.from_fov(config.width, config.height, horizontal, vertical)


def lenses(robot: RobotConfig) -> dict[str, tuple[str, CameraModel | FisheyeModel]]:
    """Optical frame and lens of each camera."""
    kinect, panorama = robot.streams.kinect, robot.streams.panorama
    found: dict[str, tuple[str, CameraModel | FisheyeModel]] = {}
    if kinect is not None:
        found["kinect"] = (kinect.link, camera_model(kinect))
    if panorama is not None:
        found["panorama"] = (panorama.link, fisheye_model(panorama))
    return found


def picture_formats(robot: RobotConfig) -> dict[str, PictureFormat]:
    return {
        stream: PictureFormat(lens.width, lens.height, has_depth=isinstance(lens, CameraModel))
        for stream, (_, lens) in lenses(robot).items()
    }
