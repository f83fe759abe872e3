"""Points as PCD, version 0.7, binary: what PCL, Open3D and CloudCompare read.

Points are in ``base_link`` at the message's stamp, m; colours are packed as PCL does (0x00RRGGBB in a float's bits).
Format: https://pointclouds.org/documentation/tutorials/pcd_file_format.html
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.log_tools.export.target import Format, Target, Write, stamp_name
from app.logs.log import LoggedChannel
from app.messages import Image, LaserScan, PointCloud

Points = NDArray[np.float32]


class Pcd(Format):
    """``<channel>-points/<stamp>.pcd``."""

    def accepts(self, message_type: type[Any]) -> bool:
        return message_type in (PointCloud, LaserScan, Image)

    @contextmanager
    def writer(self, channel: LoggedChannel, target: Target) -> Iterator[Write]:
        folder: Target | None = None
        count, flat = 0, 0

        def write(message: Any) -> None:
            nonlocal folder, count, flat
            if isinstance(message, Image) and message.depth is None:
                flat += 1
                return
            folder = folder or target.subfolder(f"{channel.name}-points")
            folder.put(f"{stamp_name(message.stamp)}.pcd", pcd(*cloud_of(message)))
            count += 1

        yield write
        if folder is not None:
            target.written.append(f"{folder.folder}: {count} point clouds in base_link")
        elif flat:
            target.written.append(f"{channel.name}: its {flat} images have no depth, so there are no points")


def cloud_of(message: PointCloud | LaserScan | Image) -> tuple[Points, Mapping[str, Points]]:
    """Points (N, 3) float32 in ``base_link``, m, and further columns (N,) float32 by name.

    Only measured points: rays with a return between ``range_min`` and ``range_max``, pixels with depth.
    """
    if isinstance(message, PointCloud):
        return message.points, {"rgb": packed(message.colors)}
    if isinstance(message, LaserScan):
        met = np.isfinite(message.ranges)
        met &= (message.ranges >= message.range_min) & (message.ranges <= message.range_max)
        angles = message.angle_min + np.flatnonzero(met) * message.angle_increment
        ranges = message.ranges[met]
        rays = np.stack((ranges * np.cos(angles), ranges * np.sin(angles), np.zeros(len(ranges))), axis=-1)
        columns = {}
        if len(message.intensities) == len(message.ranges):
            columns["intensity"] = message.intensities[met]
        return message.X_BL.transform(rays.astype(np.float32)), columns
    if message.depth is None:
        raise ValueError("an image without depth has no points")
    rows, places = np.nonzero(message.depth)
    pixels = np.stack((places, rows), axis=-1).astype(np.float32)
    # Depth is registered to the colours; a camera whose model is for another size says where its pixels would be.
    scale = np.array([message.camera.width, message.camera.height]) / message.depth.shape[::-1]
    pixels = ((pixels + 0.5) * scale - 0.5).astype(np.float32)
    depth = message.depth[rows, places].astype(np.float32) * np.float32(1e-3)
    points = message.X_BC.transform(message.camera.back_project(pixels, depth).astype(np.float32))
    if message.color.shape[:2] == message.depth.shape:
        return points, {"rgb": packed(message.color[rows, places])}
    return points, {}


def packed(colors: NDArray[np.uint8]) -> Points:
    """Colours (N, 3) uint8 RGB as PCL packs them: the bits of a float32 (N,)."""
    wide = colors.astype(np.uint32)
    bits = (wide[:, 0] << 16) | (wide[:, 1] << 8) | wide[:, 2]
    return bits.astype(np.uint32, copy=False).view(np.float32)


def pcd(points: Points, columns: Mapping[str, Points]) -> bytes:
    """The file's bytes."""
    fields = ["x", "y", "z", *columns]
    table = np.column_stack([points.astype("<f4", copy=False), *columns.values()]) if columns else points
    header = "\n".join(
        (
            "# .PCD v0.7 - Point Cloud Data file format",
            "VERSION 0.7",
            f"FIELDS {' '.join(fields)}",
            f"SIZE{' 4' * len(fields)}",
            f"TYPE{' F' * len(fields)}",
            f"COUNT{' 1' * len(fields)}",
            f"WIDTH {len(points)}",
            "HEIGHT 1",
            "VIEWPOINT 0 0 0 1 0 0 0",
            f"POINTS {len(points)}",
            "DATA binary",
            "",
        )
    )
    return header.encode("ascii") + np.ascontiguousarray(table, "<f4").tobytes()
