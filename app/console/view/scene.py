"""What is drawn: floor, map, way, robot, laser, clouds, posters, people. For one worker thread: viser is slow.

Each viewer has a scene of its own (viser keeps nothing of what it was sent, and each is drawn at its own pace). The
camera follows the robot without being moved: everything of the world hangs below a frame with the robot's inverse pose,
so the robot stays at the origin and orbit and zoom stay the viewer's. That world is odometry's, in which nothing jumps:
where the robot is on the map moves the map below it. Node names are fixed, nothing is removed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.console.view.body_nodes import Body
from app.console.view.drawing import colors_along_x, moved, point_size, pose_arrays, scan_points, thinned
from app.console.view.force_nodes import Forces
from app.console.view.ground import FloorLayers, Ground
from app.console.view.person_nodes import People
from app.console.view.scene_state import World
from app.console.view.viewer_rate import AT_LEAST, Pace
from app.messages import Landmark, Landmarks

WORLD, BASE = "/odom", "/base_link"
_POSTER_M = (0.22, 0.22, 0.28)
_SCAN_SIZE_M = 0.045


def set_stage(server: viser.ViserServer) -> None:
    """The part common to all viewers."""
    server.scene.set_up_direction("+z")
    server.scene.configure_default_lights(enabled=True, cast_shadow=False)
    # Lighting by a picture of a place costs a page without a GPU its first ten seconds; a plain sky does as well.
    server.scene.configure_environment_map(hdri=None)
    server.scene.add_light_hemisphere("/sky", sky_color=(235, 242, 255), ground_color=(90, 96, 108), intensity=1.6)
    server.initial_camera.position = (-3.4, 0.0, 2.3)
    server.initial_camera.look_at = (0.3, 0.0, 0.5)
    server.gui.configure_theme(dark_mode=True, show_logo=False, show_share_button=False, control_width="small")
    server.gui.main_panel.minimize()


class ViewerScene:
    """The scene of one viewer, drawn on its ``client``."""

    def __init__(self, client: viser.ClientHandle, body: Body, layers: FloorLayers) -> None:
        self._client = client
        self._drawn = World()
        self._posters: dict[str, list[tuple[viser.BoxHandle, viser.LabelHandle]]] = {"odom": [], "map": []}
        scene = client.scene
        with client.atomic():
            self._world = scene.add_frame(WORLD, show_axes=False)
            # One quad with a shader. Lines would be fat lines, hundreds of times slower where there is no GPU.
            scene.add_grid(
                f"{WORLD}/floor",
                width=60.0,
                height=60.0,
                cell_size=0.5,
                section_size=2.5,
                cell_color=(52, 62, 76),
                section_color=(84, 98, 118),
                fade_distance=30.0,
                shadow_opacity=0.0,
            )
            scene.add_frame(f"{WORLD}/origin", axes_length=0.4, axes_radius=0.012)
            self._body = body.add_to(scene, BASE)
            self._scan = self._points("scan", _SCAN_SIZE_M)
            self._cloud = self._points("cloud", point_size(0))
            self._ground = Ground(client, WORLD, layers)
        self._people = People(client, WORLD)
        self._forces = Forces(client, BASE)

    def _points(self, name: str, size: float) -> viser.PointCloudHandle:
        # viser's page takes no empty cloud: one point, unseen, until there are more.
        return self._client.scene.add_point_cloud(
            f"{WORLD}/{name}",
            np.zeros((1, 3), np.float32),
            np.zeros((1, 3), np.uint8),
            point_size=size,
            point_shape="circle" if name == "scan" else "square",
            point_shading="flat",
            precision="float16",
            visible=False,
        )

    def draw(self, world: World, now: float, pace: Pace) -> int:
        """Bring the scene up to ``world``, in one step, as ``pace`` allows; ``now`` (s) on any clock.

        Returns how many parts were new.
        """
        before, self._drawn = self._drawn, world
        new = 0
        with self._client.atomic():
            if world.joints is not None and world.joints is not before.joints:
                new += self._body.move(world.joints)
            if world.landmarks is not before.landmarks:
                self._draw_landmarks(world.landmarks)
                new += 1
            if world.scan is None:
                if before.scan is not None:
                    self._scan.visible = False
            elif world.scan is not before.scan:
                scan, X_OB = world.scan
                hits = scan_points(scan)
                _place(self._scan, hits, colors_along_x(hits), X_OB)
                new += 1
            if world.cloud is None:
                if before.cloud is not None:
                    self._cloud.visible = False
            elif world.cloud is not before.cloud:
                chosen = thinned(len(world.cloud.points), pace.points)
                self._cloud.point_size = point_size(len(chosen))
                _place(self._cloud, world.cloud.points[chosen], world.cloud.colors[chosen], world.cloud.X_OB)
                new += 1
            if world.perceived is not None and world.perceived is not before.perceived:
                new += self._people.draw(world.perceived)
            if world.forces is not before.forces:
                new += self._forces.draw(world.forces)
            new += self._ground.draw(world, now, pace)
            if world.robot is not None and moved(before.robot, world.robot):
                wxyz, position = pose_arrays(world.robot.inverse())
                self._world.wxyz, self._world.position = np.array(wxyz), np.array(position)
                new += 1
            elif before.robot is not None:
                # Many small moves make a large one.
                self._drawn = replace(world, robot=before.robot)
        return new

    def _draw_landmarks(self, known: Landmarks | None) -> None:
        """A card with its text at each poster found, below the map's node where it is on the map."""
        for frame, posters in self._posters.items():
            marks = known.landmarks if known is not None and known.frame == frame else ()
            self._draw_posters(f"{WORLD}/map" if frame == "map" else WORLD, posters, marks)

    def _draw_posters(
        self, parent: str, posters: list[tuple[viser.BoxHandle, viser.LabelHandle]], landmarks: Sequence[Landmark]
    ) -> None:
        scene = self._client.scene
        for number, landmark in enumerate(landmarks):
            if number == len(posters):
                node = f"{parent}/landmark_{number}"
                card = scene.add_box(node, color=(250, 204, 80), dimensions=_POSTER_M, opacity=0.75, cast_shadow=False)
                label = scene.add_label(f"{node}/text", landmark.text, position=(0, 0, 0.3), anchor="bottom-center")
                posters.append((card, label))
            card, label = posters[number]
            card.position = np.array(landmark.p_FQ)
            card.visible = True
            label.text = landmark.text
        for card, _ in posters[len(landmarks) :]:
            card.visible = False


def _place(node: viser.PointCloudHandle, points: NDArray[Any], colors: NDArray[np.uint8], X_OB: Pose2) -> None:
    """Points, colours and pose together: never one instant's points in another's pose."""
    node.visible = len(points) > 0
    if len(points) > 0:
        wxyz, position = pose_arrays(X_OB)
        node.points, node.colors = points.astype(np.float16), colors
        node.wxyz, node.position = np.array(wxyz), np.array(position)


class Scene:
    """The scenes of all viewers; each is drawn when its time has come."""

    def __init__(self, server: viser.ViserServer, body: Body) -> None:
        set_stage(server)
        self._body = body
        self._layers = FloorLayers()
        self._viewers: dict[str, ViewerScene] = {}
        self._due: dict[str, float] = {}

    def viewer_came(self, viewer: str, client: viser.ClientHandle) -> None:
        self._viewers[viewer] = ViewerScene(client, self._body, self._layers)
        self._due[viewer] = 0.0

    def viewer_left(self, viewer: str) -> None:
        self._viewers.pop(viewer, None)
        self._due.pop(viewer, None)

    def draw(self, world: World, now: float, paces: Mapping[str, Pace]) -> int:
        """Draw for each viewer whose time has come; ``paces`` says what each bears.

        Returns how many parts were drawn.
        """
        drawn = 0
        for viewer, scene in self._viewers.items():
            pace = paces.get(viewer, AT_LEAST)
            if now >= self._due[viewer]:
                self._due[viewer] = now + pace.period_s
                drawn += scene.draw(world, now, pace)
        return drawn
