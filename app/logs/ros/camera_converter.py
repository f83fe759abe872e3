"""Images of cameras: JPEG for colour, raw millimetres for depth, and what a viewer needs to place them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from app.base.geometry import CameraModel, FisheyeModel, Pose3
from app.base.image_source import decoded
from app.logs.ros import typestore
from app.logs.ros.frames import BASE, TF, Transform, header, pose3_numbers
from app.logs.ros.generated import generated
from app.logs.ros.info import InfoTopic, RestTopic, pose_key
from app.logs.ros.record import MAIN, Record, RecordTopic
from app.logs.ros.record_templates import assembled, stamped, with_length
from app.messages import EncodedImage, Image, read_only

_COMPRESSED = "sensor_msgs/msg/CompressedImage"
_RAW = "sensor_msgs/msg/Image"
_CAMERA_INFO = "sensor_msgs/msg/CameraInfo"
_NO_BYTES = np.zeros(0, np.uint8)


@dataclass(frozen=True, slots=True)
class ImageInfo:
    """An Image without its pixels; ``has_depth`` distinguishes a camera without depth from lost depth."""

    stamp: float
    frame: str
    has_depth: bool
    camera: CameraModel
    X_BC: Pose3


@dataclass(frozen=True, slots=True)
class FisheyeImageInfo:
    """The same of a fisheye's Image. A class of its own, so that the format of other recordings does not change."""

    stamp: float
    frame: str
    has_depth: bool
    camera: FisheyeModel
    X_BC: Pose3


class ImageConverter:
    """Colour (JPEG), depth (raw 16UC1, mm), camera and the camera's pose, all of one stamp.

    Everything but the colour's pixels comes back exactly. A channel's images are all a pinhole's or all a fisheye's.
    """

    def __init__(self, channel: str, jpeg_quality: int, main_type: str | None = None) -> None:
        """``jpeg_quality`` 1 to 100; ``main_type`` of a channel that a file has, else the first image decides."""
        self._color = RecordTopic(f"/{channel}/color/compressed", _COMPRESSED, "color")
        self._depth = RecordTopic(f"/{channel}/depth", _RAW, "depth")
        self._camera = RecordTopic(f"/{channel}/camera_info", _CAMERA_INFO, None)
        self._channel = channel
        self._info: InfoTopic[Any]
        self._set_lens(FisheyeModel if main_type == generated(FisheyeImageInfo).type else CameraModel)
        self._decided = main_type is not None
        self._options = (cv2.IMWRITE_JPEG_QUALITY, jpeg_quality)
        self._known: tuple[str, CameraModel | FisheyeModel, tuple[int, ...]] | None = None

    @property
    def topics(self) -> tuple[RecordTopic, ...]:
        """Colour, depth, camera, transform, info: the type of the last one names the lens."""
        return (self._color, self._depth, self._camera, TF, self._info.topic)

    def encode(self, message: Image, stamp_ns: int) -> list[Record]:
        """Colour, depth if there is any, camera, transform, info.

        Raises cv2.error for what JPEG cannot hold, and ValueError for an image through another lens than the first.
        """
        if not self._decided:
            self._set_lens(type(message.camera))
            self._decided = True
        if type(message.camera) is not self._lens:
            given, kept = type(message.camera).__name__, self._lens.__name__
            raise ValueError(f"an image through a {given} among those of a {kept}")
        depth = message.depth
        shape = () if depth is None else depth.shape
        known = (message.frame, message.camera, shape)
        if known != self._known:
            self._prepare(message.frame, message.camera, shape)
            self._known = known
        jpeg = cv2.imencode(".jpg", cv2.cvtColor(message.color, cv2.COLOR_RGB2BGR), self._options)[1]
        color = assembled(self._color_head, stamp_ns, *with_length(jpeg.data, jpeg.size))
        records = [Record(self._color.name, _COMPRESSED, stamp_ns, color)]
        if depth is not None:
            bulk = np.ascontiguousarray(depth, "<u2")
            raw = assembled(self._depth_head, stamp_ns, *with_length(bulk.data.cast("B"), bulk.nbytes))
            records.append(Record(self._depth.name, _RAW, stamp_ns, raw))
        pose = pose3_numbers(message.X_BC)
        info = self._kind(message.stamp, message.frame, depth is not None, message.camera, message.X_BC)
        records += (
            Record(self._camera.name, _CAMERA_INFO, stamp_ns, stamped(self._camera_data, stamp_ns)),
            self._transform.record(stamp_ns, pose),
            self._info.record(info, stamp_ns, (known, pose_key(message.X_BC))),
        )
        return records

    def decode(self, parts: Mapping[str, bytes]) -> Image | None:
        info = self._info.decode(parts[MAIN])
        if "color" not in parts or (info.has_depth and "depth" not in parts):
            return None
        jpeg = typestore.deserialise(_COMPRESSED, parts["color"]).data
        color = decoded(jpeg, cv2.IMREAD_COLOR_RGB)
        if color is None:
            raise ValueError("the colour image is no JPEG")
        depth: NDArray[np.uint16] | None = None
        if info.has_depth:
            raw = typestore.deserialise(_RAW, parts["depth"])
            depth = raw.data.view("<u2").reshape(raw.height, raw.width)
        pixels = read_only(color.astype(np.uint8, copy=False))
        return Image(info.stamp, info.frame, color=pixels, depth=depth, camera=info.camera, X_BC=info.X_BC)

    def _set_lens(self, lens: type[CameraModel] | type[FisheyeModel]) -> None:
        self._lens = lens
        self._kind: type[Any] = ImageInfo if lens is CameraModel else FisheyeImageInfo
        self._info = InfoTopic(self._channel, self._kind)

    def _prepare(self, frame: str, camera: CameraModel | FisheyeModel, depth: tuple[int, ...]) -> None:
        self._transform = Transform(BASE, frame)
        # Both end with the length of their data, still 0.
        self._color_head = typestore.serialise(_COMPRESSED, header(frame), "jpeg", _NO_BYTES)[:-4]
        if depth:
            height, width = depth
            fields = (height, width, "16UC1", 0, 2 * width, _NO_BYTES)
            self._depth_head = typestore.serialise(_RAW, header(frame), *fields)[:-4]
        k = np.array([camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1], np.float64)
        p = np.array([camera.fx, 0, camera.cx, 0, 0, camera.fy, camera.cy, 0, 0, 0, 1, 0], np.float64)
        region = typestore.make("sensor_msgs/msg/RegionOfInterest", 0, 0, 0, 0, False)
        model, terms = ("plumb_bob", 5) if isinstance(camera, CameraModel) else ("equidistant", 4)
        self._camera_data = typestore.serialise(
            _CAMERA_INFO, header(frame), camera.height, camera.width, model, np.zeros(terms), k,
            np.eye(3).reshape(-1), p, 0, 0, region,
        )  # fmt: skip


class EncodedImageConverter:
    """``sensor_msgs/CompressedImage`` of the JPEG as it is."""

    def __init__(self, channel: str) -> None:
        self._picture = RecordTopic(f"/{channel}", _COMPRESSED, "jpeg")
        self._info = RestTopic(channel, EncodedImage, "frame", "jpeg")
        self.topics = (self._picture, self._info.topic)

    def encode(self, message: EncodedImage, stamp_ns: int) -> list[Record]:
        head = typestore.serialise(_COMPRESSED, header(message.frame), "jpeg", _NO_BYTES)[:-4]
        data = assembled(head, stamp_ns, *with_length(message.jpeg, len(message.jpeg)))
        key = (message.width, message.height, pose_key(message.X_BC))
        return [
            Record(self._picture.name, _COMPRESSED, stamp_ns, data),
            self._info.record_of(message, stamp_ns, key),
        ]

    def decode(self, parts: Mapping[str, bytes]) -> EncodedImage | None:
        if "jpeg" not in parts:
            return None
        ros = typestore.deserialise(_COMPRESSED, parts["jpeg"])
        picture: EncodedImage = self._info.message(parts[MAIN], frame=ros.header.frame_id, jpeg=ros.data.tobytes())
        return picture
