"""The table: which converter a message class has. A class that is not in it is recorded by its own fields."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from app.logs.ros.camera_converter import EncodedImageConverter, ImageConverter
from app.logs.ros.cloud_converter import PointCloudConverter
from app.logs.ros.landmarks_converter import LandmarksConverter
from app.logs.ros.laser_converter import LaserScanConverter
from app.logs.ros.native_types import (
    GeneratedConverter,
    JointStateConverter,
    LogLineConverter,
    OdometryConverter,
    TwistConverter,
)
from app.logs.ros.navigation_converters import OccupancyGridConverter, PlannedPathConverter
from app.logs.ros.record import Converter
from app.messages import (
    EncodedImage,
    Image,
    JointState,
    Landmarks,
    LaserScan,
    LogLine,
    OccupancyGrid,
    Odometry,
    PlannedPath,
    PointCloud,
    Twist,
)


@dataclass(frozen=True, slots=True)
class Options:
    """Options of converters: nominal rate of the channel (Hz), quality of JPEG (1 to 100).

    ``main_type`` is the ROS type of the main records in a file that is read, ``definition`` theirs, where
    the class, or one within it, has got more fields since (None: it is today's).
    """

    rate_hz: float | None = None
    jpeg_quality: int = 90
    main_type: str | None = None
    definition: str | None = None


CONVERTERS: Mapping[type[Any], Callable[[str, Options], Converter]] = {
    EncodedImage: lambda channel, _: EncodedImageConverter(channel),
    Image: lambda channel, options: ImageConverter(channel, options.jpeg_quality, options.main_type),
    JointState: lambda channel, _: JointStateConverter(channel),
    Landmarks: lambda channel, _: LandmarksConverter(channel),
    LaserScan: lambda channel, options: LaserScanConverter(channel, options.rate_hz),
    LogLine: lambda channel, _: LogLineConverter(channel),
    OccupancyGrid: lambda channel, _: OccupancyGridConverter(channel),
    Odometry: lambda channel, _: OdometryConverter(channel),
    PlannedPath: lambda channel, _: PlannedPathConverter(channel),
    PointCloud: lambda channel, _: PointCloudConverter(channel),
    Twist: lambda channel, _: TwistConverter(channel),
}


def converter(channel: str, message_type: type[Any], options: Options | None = None) -> Converter:
    """The converter of a channel of such messages. Raises UnrecordableType for a class that ROS can say nothing of."""
    options = options or Options()
    make = CONVERTERS.get(message_type)
    if make is None:
        return GeneratedConverter(channel, message_type, options.definition)
    return make(channel, options)
