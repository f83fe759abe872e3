"""The fan of Mode 2's soft limit on the floor, for one viewer: the head follows the view within it, the base beyond it.

In the colours of the fan on the page's map (``web/src/map/colors.ts``).
"""

from __future__ import annotations

import math

import numpy as np
import viser
from numpy.typing import NDArray

from app.console.view.floor import ribbon

#: How far it reaches (m), as on the map.
FAN_M = 1.6
COLOR = (255, 211, 77)
#: Of its surface, while the head looks within the limit and past it.
WITHIN, PAST = 0.12, 0.38
#: Over the map, below the outlines of the next two seconds (m).
_Z = 0.04
_STEP_RAD = math.radians(3.0)


def arc(angle: float) -> NDArray[np.float64]:
    """The points (N, 2), m in ``base_link``, from ``angle`` (rad, 0 to pi) right to ``angle`` left."""
    at = np.linspace(-angle, angle, max(3, math.ceil(2 * angle / _STEP_RAD) + 1))
    return FAN_M * np.column_stack([np.cos(at), np.sin(at)])


def surface(angle: float) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
    """The fan's surface: vertices (V, 3), m in ``base_link``, and faces (F, 3)."""
    around = arc(angle)
    vertices = np.zeros((1 + len(around), 3), np.float32)
    vertices[1:, :2] = around
    first = np.arange(1, len(around))
    return vertices, np.stack([np.zeros_like(first), first, first + 1], axis=1).astype(np.uint32)


def edge(angle: float) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
    """Its outline as a ribbon: vertices (V, 3), m in ``base_link``, and faces (F, 3)."""
    middle = np.zeros((1, 2))
    return ribbon(np.concatenate([middle, arc(angle), middle]))


class SoftLimitFan:
    """Drawn on ``client`` below its node ``root``, ``base_link``."""

    def __init__(self, client: viser.ClientHandle, root: str) -> None:
        self._scene = client.scene
        self._name = f"{root}/soft_limit"
        self._nodes: tuple[viser.MeshHandle, viser.MeshHandle] | None = None
        self._angle: float | None = None
        self._past = False

    def draw(self, angle: float | None, gaze: float) -> int:
        """Show a limit of ``angle`` (rad; None: none) for a head turned by ``gaze`` (rad); returns how many parts were
        new."""
        before, self._angle = self._angle, angle
        past = angle is not None and abs(gaze) > angle
        changed = before != angle or past != self._past
        self._past = past
        if not changed:
            return 0
        if angle is None:
            for node in self._nodes or ():
                node.visible = False
            return 1
        if self._nodes is None:
            self._nodes = self._add("surface", surface(angle)), self._add("edge", edge(angle))
        elif before != angle:
            for node, (vertices, faces) in zip(self._nodes, (surface(angle), edge(angle)), strict=True):
                node.vertices, node.faces, node.visible = vertices, faces, True
        self._nodes[0].opacity = PAST if past else WITHIN
        return 1

    def _add(self, part: str, mesh: tuple[NDArray[np.float32], NDArray[np.uint32]]) -> viser.MeshHandle:
        return self._scene.add_mesh_simple(
            f"{self._name}/{part}",
            *mesh,
            color=COLOR,
            opacity=WITHIN if part == "surface" else None,
            side="double",
            position=(0.0, 0.0, _Z),
            cast_shadow=False,
            receive_shadow=False,
        )
