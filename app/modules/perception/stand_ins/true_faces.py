"""TrueFaces: stands in for FaceDetector on a body without pictures.

    ┌─────────────────────────────────────────────────────────────────────────────────────────────┐
    │ TrueFaces   in   images    never comes: its filter says whether and how often faces are found │
    │             in   panorama  likewise                                                          │
    │             in   map       OccupancyGrid: walls hide faces; not wired: none do               │
    │             out  faces     Faces, as FaceDetector publishes them                             │
    └─────────────────────────────────────────────────────────────────────────────────────────────┘

It has FaceDetector's class of desires and strategies, so attention decides as it would. Faces are found while a
camera's filter is open, where that camera looks, as far as FaceDetector finds them, and of people who do not look
away. The truth is the body's streams ``ground_truth``, ``scene_truth`` and ``joints``.
"""

from __future__ import annotations

import math
from contextlib import ExitStack
from dataclasses import replace
from typing import Any

from pydantic import Field

from app.base.geometry import Pose2, Pose3
from app.base.kinematic_model import KinematicModel, load_model
from app.maps.grid_rays import GridRays
from app.messages import Faces, GroundTruth, Image, JointState, OccupancyGrid, SceneTruth, read_only
from app.modules.perception.face_detector import LOCATE_FACES
from app.modules.perception.stand_ins.visible_faces import Eye, TrackNumbers, visible
from app.modules.stream_module import attach, robot_link
from app.runtime.errors import ModuleFailed
from app.runtime.module import Input, Module, ModuleContext, Settings


class TrueFacesSettings(Settings):
    frame: str = Field("kinect_optical_frame", description="of the camera whose filter is `images`")
    panorama_frame: str = Field("panorama_optical_frame", description="of the one whose filter is `panorama`")
    reach_m: float = Field(4.0, gt=0, description="how far the one finds faces")
    panorama_reach_m: float = Field(2.5, gt=0, description="how far the other does")


class TrueFaces(Module):
    title = "True faces"
    desire_classes = (LOCATE_FACES,)
    Settings = TrueFacesSettings
    settings: TrueFacesSettings

    _model: KinematicModel

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.images = self.input("images", Image)
        self.panorama = self.input("panorama", Image)
        self.map = self.input("map", OccupancyGrid, wants="never")
        self.faces = self.output("faces", Faces)
        self.on(self.map, self._take_map)
        s = self.settings
        fov = math.radians(57), math.radians(43)
        self._eyes: tuple[tuple[Input[Any], Eye], ...] = (
            (self.images, Eye(s.frame, fov, s.reach_m, (640, 480), 15.0)),
            (self.panorama, Eye(s.panorama_frame, (math.pi, math.pi), s.panorama_reach_m, (1024, 768), 10.0)),
        )
        self._due: dict[str, float] = {}
        self._tracks = TrackNumbers()
        self._rays: GridRays | None = None
        self._joints: dict[str, float] = {}
        self._X_MB: Pose2 | None = None
        self._stack = ExitStack()

    async def start(self) -> None:
        """Look at the truth. Raises ModuleFailed for a body that does not say it, or has no such camera."""
        link = robot_link(self)
        self._model = await self.compute_background(load_model, link.description.model_path)
        for _, eye in self._eyes:
            if eye.frame not in self._model.links:
                raise ModuleFailed(f"{link.description.name} has no link {eye.frame!r} for a camera")
        if self.map.connected and self.map.channel is not None and self.map.channel.latest is not None:
            await self._take_map(self.map.channel.latest)
        self._stack.callback(attach(self, "joints", JointState, self._take_joints))
        self._stack.callback(attach(self, "ground_truth", GroundTruth, self._take_pose))
        self._stack.callback(attach(self, "scene_truth", SceneTruth, self._look))
        # Not withdrawn: another stand-in may go on with it, and it costs nothing.
        for stream in ("ground_truth", "scene_truth"):
            link.demand(stream, math.inf)

    async def stop(self) -> None:
        """Look no more."""
        self._stack.close()

    async def _take_map(self, grid: OccupancyGrid) -> None:
        self._rays = await self.compute(GridRays, grid)

    def _take_joints(self, joints: JointState) -> None:
        self._joints = dict(zip(joints.names, joints.positions, strict=True))

    def _take_pose(self, truth: GroundTruth) -> None:
        self._X_MB = truth.X_WB

    def _look(self, scene: SceneTruth) -> None:
        for port, eye in self._eyes:
            if port.connected and port.subscription.filter.is_open and scene.stamp >= self._due.get(eye.frame, 0.0):
                self._due[eye.frame] = scene.stamp + port.subscription.filter.divisor / eye.rate_hz - 1e-6
                self._publish(scene, eye)

    def _publish(self, scene: SceneTruth, eye: Eye) -> None:
        if self._X_MB is None:
            return
        X_BC = self._model.pose(eye.frame, self._joints)
        X_BC = Pose3(read_only(X_BC.rotation), read_only(X_BC.translation))
        faces = tuple(
            replace(face, track=self._tracks.of(person.name, scene.stamp))
            for person, face in visible(scene.people, self._X_MB, X_BC, eye, self._rays)
        )
        width, height = eye.size
        self.faces.publish(Faces(scene.stamp, eye.frame, width=width, height=height, X_BC=X_BC, faces=faces))
