"""Planar laser scans."""

from __future__ import annotations

from collections.abc import Hashable, Mapping

import numpy as np
from numpy.typing import NDArray

from app.logs.ros import typestore
from app.logs.ros.cloud_converter import XYZ, CloudHead
from app.logs.ros.frames import BASE, TF, Transform, header, pose3_numbers
from app.logs.ros.info import RestTopic, pose_key
from app.logs.ros.record import MAIN, Record, RecordTopic
from app.logs.ros.record_templates import assembled, with_length
from app.logs.stamps import SECOND
from app.messages import LaserScan, read_only

_SCAN = "sensor_msgs/msg/LaserScan"
#: Scans are drawn as points about ten times a second, for viewers that know no LaserScan; all are kept as scans.
#: A little less than the period, or a clock's jitter would halve the rate.
POINTS_PERIOD_NS = 95 * SECOND // 1000
#: A static transform is repeated once a second, for readers that begin in the middle.
TRANSFORM_PERIOD_NS = 95 * SECOND // 100


class LaserScanConverter:
    """``sensor_msgs/LaserScan``, some of them also as points, and the laser's transform."""

    def __init__(self, channel: str, rate_hz: float | None) -> None:
        """``rate_hz``: nominal rate of scans, None where it is not known."""
        self._scan = RecordTopic(f"/{channel}", _SCAN, "scan")
        self._points = RecordTopic(f"/{channel}/points", CloudHead.TYPE, None)
        self._info = RestTopic(channel, LaserScan, "ranges", "intensities")
        self.topics = (self._scan, self._points, TF, self._info.topic)
        self._scan_time = 0.0 if rate_hz is None else 1.0 / rate_hz
        self._known: Hashable = None
        self._points_ns: int | None = None
        self._transform_key: Hashable = None
        self._transform_ns = 0

    def encode(self, message: LaserScan, stamp_ns: int) -> list[Record]:
        count = len(message.ranges)
        known = (
            message.frame, message.angle_min, message.angle_increment, message.range_min, message.range_max,
            message.duration_s, count,
        )  # fmt: skip
        if known != self._known:
            self._prepare(message, count)
            self._known = known
        ranges = np.ascontiguousarray(message.ranges, "<f4")
        intensities = np.ascontiguousarray(message.intensities, "<f4")
        scan = assembled(
            self._scan_head, stamp_ns,
            *with_length(ranges.data.cast("B"), count), *with_length(intensities.data.cast("B"), len(intensities)),
        )  # fmt: skip
        records = [Record(self._scan.name, _SCAN, stamp_ns, scan)]
        if self._points_ns is None or not 0 <= stamp_ns - self._points_ns < POINTS_PERIOD_NS:
            self._points_ns = stamp_ns
            data = self._cloud.encode(stamp_ns, self._in_laser(message, ranges))
            records.append(Record(self._points.name, CloudHead.TYPE, stamp_ns, data))
        pose = pose_key(message.X_BL)
        placed = (message.frame, pose)
        if placed != self._transform_key or not 0 <= stamp_ns - self._transform_ns < TRANSFORM_PERIOD_NS:
            self._transform_key, self._transform_ns = placed, stamp_ns
            records.append(Transform(BASE, message.frame).record(stamp_ns, pose3_numbers(message.X_BL)))
        records.append(self._info.record_of(message, stamp_ns, (known, pose)))
        return records

    def decode(self, parts: Mapping[str, bytes]) -> LaserScan | None:
        if "scan" not in parts:
            return None
        ros = typestore.deserialise(_SCAN, parts["scan"])
        rays = {"ranges": read_only(ros.ranges), "intensities": read_only(ros.intensities)}
        scan: LaserScan = self._info.message(parts[MAIN], **rays)
        return scan

    def _prepare(self, message: LaserScan, count: int) -> None:
        none = np.zeros(0, np.float32)
        angle_max = message.angle_min + message.angle_increment * max(count - 1, 0)
        data = typestore.serialise(
            _SCAN, header(message.frame), message.angle_min, angle_max, message.angle_increment,
            message.duration_s / max(count - 1, 1), self._scan_time, message.range_min, message.range_max, none, none,
        )  # fmt: skip
        # The two lengths, still 0.
        self._scan_head = data[:-8]
        angles = message.angle_min + message.angle_increment * np.arange(count)
        self._directions = np.stack((np.cos(angles), np.sin(angles), np.zeros(count)), axis=1).astype(np.float32)
        self._cloud = CloudHead(message.frame, XYZ)

    def _in_laser(self, message: LaserScan, ranges: NDArray[np.float32]) -> NDArray[np.float32]:
        seen = (ranges >= message.range_min) & (ranges <= message.range_max)
        points: NDArray[np.float32] = self._directions[seen] * ranges[seen, np.newaxis]
        return points
