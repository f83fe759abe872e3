"""A tree of frames over time, out of ``tf`` messages: where one frame was in another at a stamp."""

from __future__ import annotations

from bisect import bisect_right, insort
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from app.base.geometry import Pose3

#: x, y, z, w.
Quaternion = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class StampedTransform:
    """Pose of a child frame in its parent at ``stamp`` (s)."""

    stamp: float
    translation: tuple[float, float, float]
    quaternion: Quaternion

    def pose(self) -> Pose3:
        """The transform as a pose. Raises ValueError for a quaternion of length 0."""
        return Pose3(Rotation.from_quat(self.quaternion).as_matrix(), np.array(self.translation, dtype=np.float64))

    def between(self, other: StampedTransform, stamp: float) -> StampedTransform:
        """Interpolated at ``stamp`` between this and a later one, the shorter way."""
        f = (stamp - self.stamp) / (other.stamp - self.stamp)
        x, y, z = (a + f * (b - a) for a, b in zip(self.translation, other.translation, strict=True))
        both = Rotation.from_quat((self.quaternion, other.quaternion))
        qx, qy, qz, qw = Slerp((self.stamp, other.stamp), both)(stamp).as_quat().tolist()
        return StampedTransform(stamp, (x, y, z), (qx, qy, qz, qw))


@dataclass(slots=True)
class _Edge:
    parent: str
    static: bool
    past: list[StampedTransform] = field(default_factory=list)


class Transforms:
    """The tree of transforms; moving frames are kept over the last ``span_s``.

    A stamp up to ``tolerance_s`` outside the known time of a moving frame takes its nearest pose; further out there is
    none.
    """

    def __init__(self, span_s: float = 10.0, tolerance_s: float = 0.5) -> None:
        self._span_s = span_s
        self._tolerance_s = tolerance_s
        self._edges: dict[str, _Edge] = {}

    def add(self, parent: str, child: str, placed: StampedTransform, *, static: bool) -> None:
        """Add a published transform; a static frame stays static."""
        edge = self._edges.get(child)
        if edge is None or edge.parent != parent or (static and not edge.static):
            edge = self._edges[child] = _Edge(parent, static)
        if edge.static:
            edge.past = [placed]
            return
        past = edge.past
        if not past or placed.stamp > past[-1].stamp:
            past.append(placed)
        else:
            at = bisect_right(past, placed.stamp, key=_stamp)
            if at and past[at - 1].stamp == placed.stamp:
                return  # said again by a publisher that repeats itself
            insort(past, placed, key=_stamp)
        if past[0].stamp < past[-1].stamp - 2 * self._span_s:
            del past[: bisect_right(past, past[-1].stamp - self._span_s, key=_stamp)]

    def standing(self) -> Transforms:
        """A new tree with the static transforms alone."""
        other = Transforms(self._span_s, self._tolerance_s)
        for child, edge in self._edges.items():
            if edge.static:
                other.add(edge.parent, child, edge.past[0], static=True)
        return other

    def path(self, frame: str, ancestor: str) -> tuple[str, ...]:
        """``frame`` and the frames above it below ``ancestor``; empty where that is none."""
        above = list(self._up(frame))
        return tuple(above[: above.index(ancestor)]) if ancestor in above else ()

    def frames(self) -> frozenset[str]:
        """Every frame met."""
        return frozenset(self._edges) | {edge.parent for edge in self._edges.values()}

    def edges(self) -> tuple[tuple[str, str, bool], ...]:
        """Parent, child, and whether it stands still, of every transform."""
        return tuple((edge.parent, child, edge.static) for child, edge in self._edges.items())

    def connected(self, frame: str, other: str) -> bool:
        """Whether the tree says, at any time, where one is in the other."""
        return frame == other or bool({*self._up(frame)} & {*self._up(other)} & self.frames())

    def lookup(self, frame: str, other: str, stamp: float) -> Pose3 | None:
        """``X_FO``: the pose of ``other`` in ``frame`` at ``stamp``; None where the tree does not say."""
        if frame == other:
            return Pose3.identity()
        above = list(self._up(frame))
        common = next((name for name in self._up(other) if name in above), None)
        if common is None:
            return None
        X_AF = self._climb(frame, common, stamp)
        X_AO = self._climb(other, common, stamp)
        return None if X_AF is None or X_AO is None else X_AF.inverse() @ X_AO

    def _up(self, frame: str) -> Iterator[str]:
        seen = set()
        while frame not in seen:
            seen.add(frame)
            yield frame
            edge = self._edges.get(frame)
            if edge is None:
                return
            frame = edge.parent

    def _climb(self, frame: str, ancestor: str, stamp: float) -> Pose3 | None:
        """``X_AF``: the pose of ``frame`` in an ``ancestor`` of it."""
        pose = Pose3.identity()
        while frame != ancestor:
            edge = self._edges[frame]
            placed = edge.past[0] if edge.static else self._at(edge.past, stamp)
            if placed is None:
                return None
            pose = placed.pose() @ pose
            frame = edge.parent
        return pose

    def _at(self, past: list[StampedTransform], stamp: float) -> StampedTransform | None:
        after = bisect_right(past, stamp, key=_stamp)
        if 0 < after < len(past):
            return past[after - 1].between(past[after], stamp)
        nearest = past[0] if after == 0 else past[-1]
        return nearest if abs(nearest.stamp - stamp) <= self._tolerance_s else None


def _stamp(placed: StampedTransform) -> float:
    return placed.stamp
