"""What is drawn: floor, map, way, robot, laser, clouds, posters, people. For one worker thread: viser is slow.

Each viewer has a scene of its own (viser keeps nothing of what it was sent, and each is drawn at its own pace). The
camera follows the robot without being moved: all is drawn in a stage, which lies on the robot, or where else the
viewpoint wants it; all of the world hangs below a frame with the stage's inverse pose, so orbit and zoom stay the
viewer's. That world is odometry's, in which nothing jumps: where the robot is on the map moves the map below it.
Node names are fixed, and next to nothing is removed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from app.base.geometry import Pose2, azimuth_elevation
from app.console.view.body_nodes import Body
from app.console.view.budget import divided
from app.console.view.drawing import colors_along_x, moved, point_size, pose_arrays, scan_points, thinned
from app.console.view.force_nodes import Forces
from app.console.view.foreseen_node import Foreseen
from app.console.view.ground import FloorLayers, Ground
from app.console.view.outlook import outlook
from app.console.view.person_nodes import People
from app.console.view.picking import POSTER_M, Pick, Pickable, picked
from app.console.view.scene_state import World
from app.console.view.screen_nodes import Screen, Screens
from app.console.view.soft_limit import SoftLimitFan
from app.console.view.viewer_camera import CameraState, ViewerCamera
from app.console.view.viewer_rate import AT_LEAST, Pace
from app.console.view.viewpoints import FIRST, Anchors, shot
from app.console.view.voxel_nodes import Surroundings
from app.console.view.voxels import VoxelMap
from app.link import BaseLimits
from app.messages import Landmark, Landmarks, PointCloud

WORLD, BASE = "/odom", "/base_link"
_SCAN_SIZE_M = 0.045
#: Over the floor and what lies on it (m).
_OUTLOOK_Z = 0.05
#: Clouds are kept no more often than this (s), and thinned to so many points; older voxels fade as seldom.
_KEEP_S, _KEPT_POINTS = 0.35, 12_000
_FADE_S = 1.0
#: What is higher (m) would hide from above what is below it.
_CEILING_M = 1.9


class Shared:
    """What is made once for all viewers. For one thread."""

    def __init__(self, body: Body, footprint: Sequence[tuple[float, float]], limits: BaseLimits | None = None) -> None:
        self._body = body
        self.limits = limits
        self.footprint = np.array(footprint, np.float64).reshape(-1, 2)
        self.layers = FloorLayers()
        self.screens = Screens()
        self.voxels = VoxelMap()
        self._kept = -math.inf
        self._faded = -math.inf

    def keep(self, world: World) -> None:
        """Take what is seen now into the voxel map, and let it fade."""
        cloud = world.cloud
        if cloud is not None and not 0 <= cloud.stamp - self._kept < _KEEP_S:
            self._kept = cloud.stamp
            X_OB = cloud.X_OB.to_pose3()
            X_BC = self._body.eye(world.joints or {})
            eye = X_OB.translation if X_BC is None else (X_OB @ X_BC).translation
            chosen = thinned(len(cloud.points), _KEPT_POINTS)
            points = X_OB.transform(cloud.points[chosen]).astype(np.float32)
            low = points[:, 2] < _CEILING_M
            self.voxels.add(points[low], cloud.colors[chosen][low], eye, cloud.stamp)
        if not 0 <= world.now - self._faded < _FADE_S:
            self._faded = world.now
            self.voxels.fade(world.now)


def set_stage(server: viser.ViserServer) -> None:
    """The part common to all viewers."""
    server.scene.set_up_direction("+z")
    server.scene.configure_default_lights(enabled=True, cast_shadow=False)
    # Lighting by a picture of a place costs a page without a GPU its first ten seconds; a plain sky does as well.
    server.scene.configure_environment_map(hdri=None)
    server.scene.add_light_hemisphere("/sky", sky_color=(235, 242, 255), ground_color=(90, 96, 108), intensity=1.6)
    first = shot(FIRST, Anchors())
    server.initial_camera.position, server.initial_camera.look_at = first.eye, first.target
    server.initial_camera.fov = first.fov
    server.gui.configure_theme(dark_mode=True, show_logo=False, show_share_button=False, control_width="small")
    server.gui.main_panel.minimize()


class ViewerScene:
    """The scene of one viewer, drawn on its ``client``."""

    def __init__(self, client: viser.ClientHandle, body: Body, shared: Shared) -> None:
        self._client = client
        self._shared = shared
        self._drawn = World()
        self._cloud_drawn: PointCloud | None = None
        self._inside = False
        self._outlook: viser.MeshHandle | None = None
        self._model = body
        #: Poses in the stage of odometry and of the base, as sent.
        self._X_SO, self._X_SB = Pose2(), Pose2()
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
            self._base = scene.add_frame(BASE, show_axes=False)
            self._body = body.add_to(scene, BASE)
            self._scan = self._points("scan", _SCAN_SIZE_M)
            self._cloud = self._points("cloud", point_size(0))
            self._ground = Ground(client, WORLD, shared.layers)
            self._screen = Screen(client, WORLD, shared.screens)
            self._surroundings = Surroundings(client, WORLD)
        self.camera = ViewerCamera(client)
        self._people = People(client, WORLD)
        self._forces = Forces(client, BASE)
        self._soft_limit = SoftLimitFan(client, BASE)
        self._foreseen = Foreseen(client, WORLD, shared.footprint, shared.limits)

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
            through = self.camera.viewpoint == "first_person"
            # The camera's picture shows it as well, and its points would lie before the picture.
            cloud = None if through else world.cloud
            newest, remembered = divided(pace.points, 0 if cloud is None else len(cloud.points))
            new += self._draw_cloud(cloud, newest)
            new += self._surroundings.draw(self._shared.voxels, remembered, world.robot or Pose2())
            new += self._draw_outlook(world)
            new += self._foreseen.draw(world, pace.lag_s)
            if world.perceived is not None and world.perceived is not before.perceived:
                new += self._people.draw(world.perceived)
            if world.forces is not before.forces:
                new += self._forces.draw(world.forces)
            new += self._ground.draw(world, now, pace)
            new += self._screen.draw(world.picture, shown=through)
            new += self._steer(world, now, pace)
            new += self._soft_limit.draw(pace.choice.soft_limit, self.camera.state.gaze)
        return new

    @property
    def stamp(self) -> float | None:
        """Of the robot as it is drawn (s, the robot's clock); None: it is not yet."""
        return self._drawn.stamp

    def steer(self, world: World, now: float, pace: Pace) -> None:
        """Move the camera and the stage alone."""
        with self._client.atomic():
            self._steer(world, now, pace)

    def _steer(self, world: World, now: float, pace: Pace) -> int:
        X_OB = world.robot or Pose2()
        X_OS = self.camera.step(pace.choice, self._anchors(world, X_OB), now)
        X_SO, X_SB = X_OS.inverse(), X_OS.inverse() @ X_OB
        new = 0
        if moved(self._X_SO, X_SO):
            self._X_SO = X_SO
            _move(self._world, X_SO)
            new += 1
        if moved(self._X_SB, X_SB):
            self._X_SB = X_SB
            _move(self._base, X_SB)
            new += 1
        if self.camera.inside != self._inside:
            self._inside = self.camera.inside
            self._base.visible = not self._inside
            new += 1
        return new

    def _anchors(self, world: World, X_OB: Pose2) -> Anchors:
        extent = self._ground.extent
        X_BC = self._model.eye(world.joints or {})
        if X_BC is None:
            return Anchors(X_OB, map=extent)
        azimuth, elevation = azimuth_elevation(X_BC.rotation[:, 2])
        x, y, z = (float(value) for value in X_BC.translation)
        return Anchors(X_OB, (x, y, z), (float(azimuth), float(elevation)), map=extent)

    def pick(self, u: float, v: float) -> Pick:
        """What is drawn at shares (0 to 1) of its picture's width from the left and height from the top: on the map, as
        it is drawn, once that is known."""
        known, X_OM = self._drawn.landmarks or Landmarks(0.0, ()), self._ground.pose
        X_OP = Pose2() if known.frame == "odom" else X_OM
        world = Pickable(
            () if X_OP is None else known.landmarks,
            X_OP or Pose2(),
            walls=self._ground.walls,
            X_OM=X_OM or Pose2(),
            voxels=self._shared.voxels.middles(),
        )
        found = picked(self.camera.ray(u, v), world)
        return found if X_OM is None else found.on_map(X_OM)

    def _draw_outlook(self, world: World) -> int:
        if world.applied is None or world.scan is None or world.robot is None:
            seen = None
        else:
            scan, X_OB = world.scan
            # Where they are now, by the base as it is now.
            points = (world.robot.inverse() @ X_OB).transform(scan_points(scan)[:, :2].astype(np.float64))
            seen = outlook(self._shared.footprint, world.applied, points)
        if seen is None:
            if self._outlook is not None and self._outlook.visible:
                self._outlook.visible = False
                return 1
            return 0
        if self._outlook is None:
            self._outlook = self._client.scene.add_mesh_simple(
                f"{BASE}/outlook",
                seen.vertices,
                seen.faces,
                color=seen.color,
                side="double",
                position=(0.0, 0.0, _OUTLOOK_Z),
                cast_shadow=False,
                receive_shadow=False,
            )
            return 1
        self._outlook.vertices, self._outlook.faces = seen.vertices, seen.faces
        if tuple(self._outlook.color) != seen.color:
            self._outlook.color = seen.color
        if not self._outlook.visible:
            self._outlook.visible = True
        return 1

    def _draw_cloud(self, cloud: PointCloud | None, points: int) -> int:
        before, self._cloud_drawn = self._cloud_drawn, cloud
        if cloud is before:
            return 0
        if cloud is None:
            self._cloud.visible = False
            return 1
        chosen = thinned(len(cloud.points), points)
        self._cloud.point_size = point_size(len(chosen))
        _place(self._cloud, cloud.points[chosen], cloud.colors[chosen], cloud.X_OB)
        return 1

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
                card = scene.add_box(node, color=(250, 204, 80), dimensions=POSTER_M, opacity=0.75, cast_shadow=False)
                label = scene.add_label(f"{node}/text", landmark.text, position=(0, 0, 0.3), anchor="bottom-center")
                posters.append((card, label))
            card, label = posters[number]
            card.position = np.array(landmark.p_FQ)
            card.visible = True
            label.text = landmark.text
        for card, _ in posters[len(landmarks) :]:
            card.visible = False


def _move(node: viser.FrameHandle, pose: Pose2) -> None:
    wxyz, position = pose_arrays(pose)
    node.wxyz, node.position = np.array(wxyz), np.array(position)


def _place(node: viser.PointCloudHandle, points: NDArray[Any], colors: NDArray[np.uint8], X_OB: Pose2) -> None:
    """Points, colours and pose together: never one instant's points in another's pose."""
    node.visible = len(points) > 0
    if len(points) > 0:
        wxyz, position = pose_arrays(X_OB)
        node.points, node.colors = points.astype(np.float16), colors
        node.wxyz, node.position = np.array(wxyz), np.array(position)


class Scene:
    """The scenes of all viewers; each is drawn when its time has come."""

    def __init__(
        self,
        server: viser.ViserServer,
        body: Body,
        footprint: Sequence[tuple[float, float]] = (),
        limits: BaseLimits | None = None,
    ) -> None:
        """``footprint``: corners (m) in ``base_link``; ``limits`` of its base, by which its motion is predicted."""
        set_stage(server)
        self._body = body
        self._shared = Shared(body, footprint, limits)
        self._viewers: dict[str, ViewerScene] = {}
        self._due: dict[str, float] = {}

    def viewer_came(self, viewer: str, client: viser.ClientHandle) -> None:
        self._viewers[viewer] = ViewerScene(client, self._body, self._shared)
        self._due[viewer] = 0.0

    def viewer_left(self, viewer: str) -> None:
        self._viewers.pop(viewer, None)
        self._due.pop(viewer, None)

    def draw(self, world: World, now: float, paces: Mapping[str, Pace]) -> int:
        """Draw for each viewer whose time has come; ``paces`` says what each bears.

        Returns how many parts were drawn.
        """
        drawn = 0
        if self._viewers:
            self._shared.keep(world)
        for viewer, scene in self._viewers.items():
            pace = paces.get(viewer, AT_LEAST)
            if now >= self._due[viewer]:
                self._due[viewer] = now + pace.period_s
                drawn += scene.draw(world, now, pace)
            elif scene.camera.moving(pace.choice):
                scene.steer(world, now, pace)
        return drawn

    def pick(self, viewer: str, u: float, v: float) -> Pick | None:
        """What the viewer is shown at a point of its picture (:meth:`ViewerScene.pick`); None: there is no such one."""
        scene = self._viewers.get(viewer)
        return None if scene is None else scene.pick(u, v)

    def stamps(self) -> dict[str, float | None]:
        """Of the robot as each viewer is sent it (:attr:`ViewerScene.stamp`)."""
        return {viewer: scene.stamp for viewer, scene in self._viewers.items()}

    def states(self) -> dict[str, CameraState]:
        """What each viewer sees from."""
        return {viewer: scene.camera.state for viewer, scene in self._viewers.items()}
