"""The keyframes as others see them: the message Keyframes, from which landmarks follow the map."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.messages import Keyframes, Localization, read_only
from app.modules.perception.slam.types import Keyframe
from app.runtime.ports import Output

#: A pruned keyframe, the one that it was joined to, and its pose there.
Removed = tuple[int, int, Pose2]


@dataclass(frozen=True, slots=True, eq=False)
class KeyframeView:
    """``ids``, ``poses`` and ``travelled_m`` as in :class:`Keyframes`."""

    ids: NDArray[np.int64]
    poses: NDArray[np.float64]
    travelled_m: NDArray[np.float64]


def keyframe_view(keyframes: Mapping[int, Keyframe], poses: Mapping[int, Pose2]) -> KeyframeView:
    """The arrays of ``keyframes`` at ``poses`` on the map."""
    ids = sorted(keyframes)
    return KeyframeView(
        read_only(np.array(ids, np.int64)),
        read_only(np.array([(poses[id].x, poses[id].y, poses[id].theta) for id in ids], np.float64).reshape(-1, 3)),
        read_only(np.array([keyframes[id].travelled_m for id in ids], np.float64)),
    )


NO_KEYFRAMES = keyframe_view({}, {})


class KeyframePublisher:
    """Publishes the keyframes with each localization on ``output``: those taken last, with what was pruned since."""

    def __init__(self, output: Output[Keyframes]) -> None:
        self._output = output
        self._version = 0
        self._view = NO_KEYFRAMES
        self._keyframe = -1
        self._removed: list[Removed] = []

    def resume(self) -> None:
        """Count on from what was published before a restart."""
        latest = None if self._output.channel is None else self._output.channel.latest
        self._version = 0 if latest is None else latest.version

    def begin(self, view: KeyframeView) -> None:
        """Another map is in use, with these keyframes; the robot is at none of them yet."""
        self._view, self._keyframe, self._removed = view, -1, []

    def take(self, view: KeyframeView, keyframe: int, removed: Sequence[Removed]) -> None:
        """The robot is attached to ``keyframe``; ``removed`` were pruned since the last call."""
        self._view, self._keyframe = view, keyframe if len(view.ids) else -1
        self._removed += removed

    def publish(self, place: Localization) -> None:
        """Publish them with the robot at ``place``."""
        removed, self._removed = self._removed, []
        self._version += 1
        self._output.publish(
            Keyframes(
                place.stamp,
                self._version,
                place.state,
                X_MO=place.X_MO,
                X_MB=place.X_MB,
                covariance=place.covariance,
                keyframe=self._keyframe,
                ids=self._view.ids,
                poses=self._view.poses,
                travelled_m=self._view.travelled_m,
                removed=read_only(np.array([id for id, _, _ in removed], np.int64)),
                into=read_only(np.array([into for _, into, _ in removed], np.int64)),
                X_IR=read_only(np.array([(X.x, X.y, X.theta) for _, _, X in removed], np.float64).reshape(-1, 3)),
            )
        )
