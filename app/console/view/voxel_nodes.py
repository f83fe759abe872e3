"""The nodes of the voxel map of one viewer: a cloud for each chunk, sent when it changed."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import viser

from app.base.geometry import Pose2
from app.console.view.voxels import CHUNK_M, VOXEL_M, Chunk, VoxelMap

#: So many chunks are shown, those nearest to the robot; and so many are sent at once.
MOST_CHUNKS, SENT_AT_ONCE = 96, 6
#: Points are drawn no larger than this (m), however few there may be.
_LARGEST_M = 0.11

#: What was sent of a chunk: its version and the share of its voxels.
Sent = tuple[int, float]


def share_of(voxels: int, points: int) -> float:
    """The share of ``voxels`` that a viewer of so many ``points`` is sent, in steps, so that it seldom changes."""
    if voxels <= points:
        return 1.0
    return 2.0 ** (math.floor(2 * math.log2(points / voxels)) / 2) if points > 0 else 0.0


def due(
    versions: Mapping[Chunk, int], sent: Mapping[Chunk, Sent], share: float, robot: Pose2
) -> tuple[list[Chunk], list[Chunk]]:
    """The chunks to send now, the nearest to the ``robot`` first, and those to hide."""

    def distance(chunk: Chunk) -> float:
        return math.hypot((chunk[0] + 0.5) * CHUNK_M - robot.x, (chunk[1] + 0.5) * CHUNK_M - robot.y)

    near = sorted(versions, key=distance)[:MOST_CHUNKS]
    shown = set(near)
    changed = [chunk for chunk in near if sent.get(chunk) != (versions[chunk], share)]
    return changed[:SENT_AT_ONCE], [chunk for chunk in sent if chunk not in shown]


class Surroundings:
    """The voxel map below the node ``world`` of a viewer's ``client``."""

    def __init__(self, client: viser.ClientHandle, world: str) -> None:
        self._scene = client.scene
        self._world = world
        self._nodes: list[viser.PointCloudHandle] = []
        self._places: dict[Chunk, int] = {}
        self._sent: dict[Chunk, Sent] = {}

    def draw(self, voxels: VoxelMap, points: int, robot: Pose2) -> int:
        """Bring a few chunks up to ``voxels`` with at most about ``points`` in all. Returns how many were new."""
        share = share_of(len(voxels), points)
        changed, gone = due(voxels.versions(), self._sent, share, robot)
        for chunk in gone:
            self._nodes[self._places.pop(chunk)].visible = False
            del self._sent[chunk]
        for chunk in changed:
            self._send(voxels, chunk, share)
            self._sent[chunk] = (voxels.versions()[chunk], share)
        return len(changed) + len(gone)

    def _send(self, voxels: VoxelMap, chunk: Chunk, share: float) -> None:
        shown = voxels.chunk(chunk)
        chosen = shown.ranks < share
        corner = np.array([chunk[0] * CHUNK_M, chunk[1] * CHUNK_M, 0.0])
        # From the chunk's corner on, numbers of two bytes are fine enough.
        points, colors = (shown.points[chosen] - corner).astype(np.float16), shown.colors[chosen]
        node = self._node(chunk)
        node.visible = len(points) > 0
        if len(points) > 0:
            node.point_size = min(VOXEL_M / math.sqrt(share), _LARGEST_M)
            node.points, node.colors = points, colors
            node.position = corner

    def _node(self, chunk: Chunk) -> viser.PointCloudHandle:
        if chunk not in self._places:
            free = set(range(len(self._nodes))) - set(self._places.values())
            self._places[chunk] = min(free, default=len(self._nodes))
            if not free:
                self._nodes.append(self._add(len(self._nodes)))
        return self._nodes[self._places[chunk]]

    def _add(self, number: int) -> viser.PointCloudHandle:
        return self._scene.add_point_cloud(
            f"{self._world}/voxels_{number}",
            np.zeros((1, 3), np.float32),
            np.zeros((1, 3), np.uint8),
            point_size=VOXEL_M,
            point_shape="square",
            point_shading="flat",
            precision="float16",
            visible=False,
        )
