"""What is drawn: floor, robot, laser, clouds, posters. Lives in one worker thread: viser is too slow for the loop.

The camera follows the robot without being moved: everything of the world hangs below a frame with the robot's inverse
pose, so the robot stays at the origin and orbit and zoom stay the viewer's. Node names are fixed; what moves often
belongs to one viewer (its client's scene), so that viser keeps nothing of it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from app.console.view.body import Body
from app.console.view.drawing import colors_along_x, moved, point_size, pose_arrays, scan_points, thinned
from app.geometry import Pose2
from app.messages import JointState, Landmarks, LaserScan, PointCloud

WORLD = "/odom"
_POSTER_M = (0.22, 0.22, 0.28)
_SCAN_SIZE_M = 0.045


@dataclass(slots=True)
class _ViewerNodes:
    """What one viewer is shown of its own."""

    client: viser.ClientHandle
    scan: viser.PointCloudHandle
    cloud: viser.PointCloudHandle


class Scene:
    """Draws on ``server``; ``points_of(viewer)`` tells how many points of a cloud a viewer bears."""

    def __init__(self, server: viser.ViserServer, model: Path, points_of: Callable[[str], int]) -> None:
        self._server = server
        self._points_of = points_of
        self._viewers: dict[str, _ViewerNodes] = {}
        self._pose: Pose2 | None = None
        self._posters: list[tuple[Any, Any]] = []
        scene = server.scene
        scene.set_up_direction("+z")
        scene.configure_default_lights(enabled=True, cast_shadow=False)
        server.initial_camera.position = (-3.2, 0.0, 2.6)
        server.initial_camera.look_at = (1.2, 0.0, 0.6)
        server.gui.configure_theme(dark_mode=True, show_logo=False, show_share_button=False, control_width="small")
        server.gui.main_panel.minimize()
        self._world = scene.add_frame(WORLD, show_axes=False)
        scene.add_grid(
            f"{WORLD}/floor",
            width=60.0,
            height=60.0,
            cell_size=0.5,
            section_size=2.5,
            cell_color=(52, 62, 76),
            section_color=(84, 98, 118),
            fade_distance=30.0,
            plane_color=(18, 23, 30),
            plane_opacity=0.85,
            shadow_opacity=0.0,
        )
        scene.add_frame(f"{WORLD}/origin", axes_length=0.4, axes_radius=0.012)
        self._body = Body(scene, model, "/base_link")

    # --- Viewers -----------------------------------------------------------------------------------------------------

    def viewer_came(self, viewer: str, client: viser.ClientHandle) -> None:
        """Give a new viewer its own nodes."""
        nothing = np.zeros((0, 3), np.float32)
        self._viewers[viewer] = _ViewerNodes(
            client,
            self._points(client, "scan", nothing, _SCAN_SIZE_M),
            self._points(client, "cloud", nothing, 0.02),
        )

    def _points(
        self, client: viser.ClientHandle, name: str, points: NDArray[np.float32], size: float
    ) -> viser.PointCloudHandle:
        return client.scene.add_point_cloud(
            f"{WORLD}/{name}",
            points,
            np.zeros((0, 3), np.uint8),
            point_size=size,
            point_shape="circle" if name == "scan" else "square",
            point_shading="flat",
            precision="float16",
        )

    def viewer_left(self, viewer: str) -> None:
        """Forget a viewer."""
        self._viewers.pop(viewer, None)

    # --- What changes ------------------------------------------------------------------------------------------------

    def robot(self, X_OB: Pose2) -> None:
        """The robot is at ``X_OB`` now: the world moves under it."""
        if not moved(self._pose, X_OB):
            return
        self._pose = X_OB
        wxyz, position = pose_arrays(X_OB.inverse())
        with self._server.atomic():
            self._world.wxyz = wxyz
            self._world.position = position

    def joints(self, message: JointState) -> None:
        """The body's joints as measured."""
        with self._server.atomic():
            self._body.move(dict(zip(message.names, message.positions, strict=True)))

    def scan(self, seen: tuple[LaserScan, Pose2]) -> None:
        """A scan, in the pose of its own instant."""
        message, X_OB = seen
        points = scan_points(message)
        for nodes in self._viewers.values():
            _draw(nodes.client, nodes.scan, points, colors_along_x(points), X_OB)

    def cloud(self, message: PointCloud) -> None:
        """A point cloud, in the pose of its own instant, thinned to what each viewer bears."""
        for viewer, nodes in self._viewers.items():
            chosen = thinned(len(message.points), self._points_of(viewer))
            nodes.cloud.point_size = point_size(len(chosen))
            _draw(nodes.client, nodes.cloud, message.points[chosen], message.colors[chosen], message.X_OB)

    def landmarks(self, message: Landmarks) -> None:
        """The posters found: a card with its text at each."""
        scene = self._server.scene
        for number, landmark in enumerate(message.landmarks):
            if number == len(self._posters):
                node = f"{WORLD}/landmark_{number}"
                card = scene.add_box(node, color=(250, 204, 80), dimensions=_POSTER_M, opacity=0.75, cast_shadow=False)
                label = scene.add_label(f"{node}/text", landmark.text, position=(0, 0, 0.3), anchor="bottom-center")
                self._posters.append((card, label))
            card, label = self._posters[number]
            card.position = landmark.p_OQ
            card.visible = True
            label.text = landmark.text
        for card, _ in self._posters[len(message.landmarks) :]:
            card.visible = False


def _draw(
    client: viser.ClientHandle,
    node: viser.PointCloudHandle,
    points: NDArray[Any],
    colors: NDArray[np.uint8],
    X_OB: Pose2,
) -> None:
    """Points, colours and pose in one step: never one instant's points in another's pose."""
    wxyz, position = pose_arrays(X_OB)
    with client.atomic():
        node.points = points.astype(np.float16)
        node.colors = colors
        node.wxyz = wxyz
        node.position = position
