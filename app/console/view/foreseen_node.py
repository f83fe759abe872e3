"""The pickets around where the robot will be, for one viewer."""

from __future__ import annotations

import numpy as np
import viser

from app.base.geometry import Pose2
from app.console.view.drawing import moved, pose_arrays
from app.console.view.foreseen import COLOR, foreseen, pickets
from app.console.view.scene_state import World
from app.link import BaseLimits

#: Over what lies on the floor (m).
_Z = 0.02
_OPACITY = 0.95


class Foreseen:
    """Drawn on ``client`` below its node ``root``, ``odom``. ``limits`` None: the body is not predicted."""

    def __init__(self, client: viser.ClientHandle, root: str, footprint: np.ndarray, limits: BaseLimits | None) -> None:
        self._scene = client.scene
        self._name = f"{root}/foreseen"
        self._footprint = footprint
        self._limits = limits
        self._node: viser.MeshHandle | None = None
        self._X_OP: Pose2 | None = None

    def draw(self, world: World, round_trip_s: float | None) -> int:
        """Bring it up to ``world`` for a viewer whose round trip was measured; returns how many parts were new."""
        before, self._X_OP = self._X_OP, self._pose(world, round_trip_s)
        if self._X_OP is None:
            if before is not None and self._node is not None:
                self._node.visible = False
                return 1
            return 0
        if before is not None and not moved(before, self._X_OP):
            self._X_OP = before
            return 0
        wxyz, (x, y, _) = pose_arrays(self._X_OP)
        if self._node is None:
            vertices, faces = pickets(self._footprint)
            self._node = self._scene.add_mesh_simple(
                self._name,
                vertices,
                faces,
                color=COLOR,
                opacity=_OPACITY,
                side="double",
                wxyz=wxyz,
                position=(x, y, _Z),
                cast_shadow=False,
                receive_shadow=False,
            )
            return 1
        self._node.wxyz, self._node.position = np.array(wxyz), np.array((x, y, _Z))
        if before is None:
            self._node.visible = True
        return 1

    def _pose(self, world: World, round_trip_s: float | None) -> Pose2 | None:
        if self._limits is None or world.motions is None or round_trip_s is None or len(self._footprint) < 3:
            return None
        return foreseen(world.motions, round_trip_s, self._limits)
