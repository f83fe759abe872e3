"""The topics of a camera of a simulated robot that speaks ROS 2."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import CameraInfo as RosCameraInfo
from sensor_msgs.msg import CompressedImage
from sensor_msgs.msg import Image as RosImage

from app.base.geometry import CameraModel
from app.messages import Image
from app.robots.ros2.config import CAMERA_INFO, COMPRESSED_IMAGE, DEPTH, IMAGE, INFO, Ros2Config

_QUALITY = (cv2.IMWRITE_JPEG_QUALITY, 90)


class CameraPublisher:
    """The topics of the camera ``name`` of a mapping, as a driver publishes them."""

    def __init__(self, node: Any, config: Ros2Config, name: str, stamp: Callable[[Any, float], None]) -> None:
        """``stamp`` writes a time (s) of the body into a header, as the robot's computer would."""
        self._stamp = stamp
        kinds = {IMAGE: RosImage, COMPRESSED_IMAGE: CompressedImage, CAMERA_INFO: RosCameraInfo}
        self._publishers: dict[str, Any] = {
            part.partition(".")[2]: node.create_publisher(kinds[kind], topic, qos_profile_sensor_data)
            for part, (topic, kind) in config.readings.items()
            if part.partition(".")[0] == name
        }

    def give(self, image: Image) -> None:
        """Publish ``image``."""
        parts = {"": self._picture(image), INFO: self._info(image), DEPTH: self._depth(image)}
        for part, publisher in self._publishers.items():
            message = parts[part]
            self._stamp(message.header, image.stamp)
            message.header.frame_id = image.frame
            publisher.publish(message)

    def _picture(self, image: Image) -> Any:
        if self._publishers[""].msg_type is CompressedImage:
            coded = cv2.imencode(".jpg", cv2.cvtColor(image.color, cv2.COLOR_RGB2BGR), _QUALITY)
            return CompressedImage(format="rgb8; jpeg compressed bgr8", data=coded[1].tobytes())
        return _raw(image.color, "rgb8")

    def _depth(self, image: Image) -> Any:
        return RosImage() if image.depth is None else _raw(image.depth, "16UC1")

    def _info(self, image: Image) -> Any:
        camera = image.camera
        message = RosCameraInfo(width=camera.width, height=camera.height, distortion_model="plumb_bob", d=[0.0] * 5)
        if isinstance(camera, CameraModel):
            K = [camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0]
            message.k, message.p = K, [*K[:3], 0.0, *K[3:6], 0.0, *K[6:], 0.0]
        return message


def _raw(pixels: NDArray[Any], encoding: str) -> Any:
    height, width = pixels.shape[:2]
    row = pixels.dtype.itemsize * pixels.size // height
    return RosImage(
        height=height, width=width, encoding=encoding, step=row, data=np.ascontiguousarray(pixels).tobytes()
    )
