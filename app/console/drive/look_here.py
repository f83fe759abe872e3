"""A point of the camera's picture that an operator clicked, as a point of the room, and as a desire to look there.

The picture says when it was taken; with the camera's pose and the robot's at that instant the click is a ray, however
far head and robot have turned since. The point is where the camera measured something on the ray; else where the ray
meets the floor, or, where it does not within ``FAR_M``, at that distance: of a direction, little depends on it.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.attention.desires import Source
from app.attention.workspace import IntentionWorkspace, UnknownDesire
from app.base.geometry import CameraModel, FisheyeModel, Pose3
from app.base.pose_buffer import PoseBuffer
from app.messages import Image, Odometry
from app.runtime.graph import Graph

#: The desire class that turns the head to a point.
LOOK_AT = "LookAt"
INTENSITY = 7.0
UTILITY = 1.0
#: The head stays so long (s) where it was asked to look.
LASTS_S = 30.0
FAR_M = 4.0
#: Pictures that were taken longer ago (s) than this are too old to look by.
OLDEST_S = 3.0
_MOST_IMAGES = 64
#: Of the depth so much is kept: a row and a column of so many; a click means the cells within so many of it.
_THINNED, _AROUND = 4, 2

TOO_OLD = "That picture is too old to look by: click on a newer one."


@dataclass(frozen=True, slots=True)
class Taken:
    """How an image was taken: by ``camera`` at ``X_BC``, ``width`` x ``height`` px, at ``stamp``.

    ``depth`` (H, W) uint16: mm along the optical axis, 0 = not measured, evenly over the picture; None without depth.
    """

    stamp: float
    camera: CameraModel | FisheyeModel
    X_BC: Pose3
    width: int
    height: int
    depth: NDArray[np.uint16] | None = None


@dataclass(frozen=True, slots=True)
class ClickedPoint:
    """A point x, y, z (m); ``measured``: by depth, or only guessed on its ray."""

    x: float
    y: float
    z: float
    measured: bool


def clicked_point(taken: Taken, X_OB: Pose3, u: float, v: float) -> ClickedPoint:
    """The point in ``odom`` of a click at ``u``, ``v`` in [0, 1] of the picture's width and height."""
    ray_C = taken.camera.rays(np.array([[u * taken.width, v * taken.height]]))[0]
    ray_C = ray_C / np.linalg.norm(ray_C)
    X_OC = X_OB @ taken.X_BC
    ray_O = X_OC.rotation @ ray_C
    depth_m = _depth_at(taken.depth, u, v)
    if depth_m is not None and ray_C[2] > 0:
        range_m = depth_m / float(ray_C[2])
    elif ray_O[2] < 0:
        range_m = min(FAR_M, float(-X_OC.translation[2] / ray_O[2]))
    else:
        range_m = FAR_M
    x, y, z = (X_OC.translation + range_m * ray_O).tolist()
    return ClickedPoint(x, y, z, depth_m is not None)


def _depth_at(depth: NDArray[np.uint16] | None, u: float, v: float) -> float | None:
    """The median (m) of what was measured around the click; None where nothing was."""
    if depth is None:
        return None
    height, width = depth.shape
    row, column = min(int(v * height), height - 1), min(int(u * width), width - 1)
    around = depth[max(0, row - _AROUND) : row + _AROUND + 1, max(0, column - _AROUND) : column + _AROUND + 1]
    measured = around[around > 0]
    return float(np.median(measured)) / 1000 if measured.size else None


class LookHere:
    """Keeps how the last pictures were taken, and at most one desire to look where an operator clicked."""

    def __init__(self, graph: Graph, workspace: IntentionWorkspace, pictures: str) -> None:
        """``pictures``: the channel whose pictures are clicked; the images they are made of are known by its module."""
        self._graph = graph
        self._workspace = workspace
        self._pictures = pictures
        self._taken: deque[Taken] = deque(maxlen=_MOST_IMAGES)
        self._poses = PoseBuffer(span_s=OLDEST_S, tolerance_s=0.0)
        self._desire: str | None = None

    def open(self) -> Callable[[], None]:
        """Observe images and odometry; returns a function that ends it."""
        stack = ExitStack()
        for slot in self._graph.modules.values():
            if self._pictures not in slot.spec.outputs.values():
                continue
            for name in slot.spec.inputs.values():
                channel = self._graph.channels[name]
                if channel.message_type is Image:
                    stack.callback(channel.observe(self._take_image))
        if "odometry" in self._graph.channels:
            stack.callback(self._graph.channels["odometry"].observe(self._take_odometry))
        return stack.close

    def point(self, stamp: float, u: float, v: float) -> ClickedPoint | None:
        """The point in ``odom`` at ``u``, ``v`` of the picture taken at ``stamp``; None for one that is too old."""
        taken = next((each for each in self._taken if abs(each.stamp - stamp) < 1e-4), None)
        X_OB = self._poses.at(stamp)
        return None if taken is None or X_OB is None else clicked_point(taken, X_OB.to_pose3(), u, v)

    def look(self, operator: str, stamp: float, u: float, v: float) -> str:
        """Desire to look at ``u``, ``v`` of the picture taken at ``stamp``; returns why it is not, "" where it is."""
        if LOOK_AT not in self._workspace.classes:
            return "This robot has no head to turn."
        point = self.point(stamp, u, v)
        if point is None:
            return TOO_OLD
        params = {"x": round(point.x, 3), "y": round(point.y, 3), "z": round(point.z, 3), "frame": "odom"}
        with self._workspace.transaction():
            self.withdraw()
            source = Source("operator", operator)
            self._desire = self._workspace.add(
                LOOK_AT, intensity=INTENSITY, utility=UTILITY, params=params, source=source, ttl=LASTS_S
            ).id
        return ""

    def withdraw(self) -> None:
        """Look there no more."""
        desire, self._desire = self._desire, None
        if desire is not None:
            try:
                self._workspace.remove(desire)
            except UnknownDesire:
                return  # its time was over

    def clear(self) -> None:
        """The body has a new odometry: what was seen before is nowhere."""
        self._taken.clear()
        self._poses = PoseBuffer(span_s=OLDEST_S, tolerance_s=0.0)

    def _take_image(self, image: Image) -> None:
        height, width = image.color.shape[:2]
        # A copy, so that the image itself is not kept.
        depth = None if image.depth is None else image.depth[::_THINNED, ::_THINNED].copy()
        self._taken.append(Taken(image.stamp, image.camera, image.X_BC, width=width, height=height, depth=depth))

    def _take_odometry(self, odometry: Odometry) -> None:
        self._poses.add(odometry.stamp, odometry.X_OB)
