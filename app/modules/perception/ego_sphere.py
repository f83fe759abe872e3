"""EgoSphere: what stands out around the head, before anything is recognized.

    ┌──────────────────────────────────────────────────────────────────────────────────────────────┐
    │ EgoSphere   in   images     Image of the head's camera, 15 Hz / φ                            │
    │             in   panorama   Image of the fisheye, 10 Hz / φ                                  │
    │             in   faces      Faces, any rate; only where something else has them looked for   │
    │             in   sources    SoundSources, likewise                                           │
    │             in   noises     LoudNoise, as they come                                          │
    │             in   fixations  Fixation: what was looked at, and is less salient for a while    │
    │             in   odometry   Odometry, 100 Hz, X_OB in odom; never filtered                   │
    │             out  regions    SalientRegions, 5 Hz                                             │
    │             out  saliency   SaliencyMap, with it                                             │
    └──────────────────────────────────────────────────────────────────────────────────────────────┘

Pictures give motion, colour and contrast (``saliency/feature_maps.py``), percepts give faces and sounds; all fade on
one sphere in odom's axes (``saliency/ego_sphere.py``). Its middle is the eye with all joints at zero. Gains are
parameters of the desires WatchSurroundings and LookAtSalient; strategies of other desires raise what these are after.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from pydantic import Field

from app.attention.desires import DesireClass
from app.base.errors import ConfigError
from app.base.geometry import Pose2, azimuth_elevation, unit_vector
from app.base.kinematic_model import load_model
from app.messages import (
    Faces,
    Fixation,
    Image,
    LoudNoise,
    Odometry,
    SaliencyMap,
    SalientRegion,
    SalientRegions,
    SoundSource,
    SoundSources,
    read_only,
)
from app.modules.perception.opencv import use_calling_thread
from app.modules.perception.pose_at import PoseAt
from app.modules.perception.saliency.ego_sphere import EgoSphere as Sphere
from app.modules.perception.saliency.ego_sphere import Peak, SphereRules
from app.modules.perception.saliency.feature_maps import FeatureMaps, MotionRules, PictureFeatures
from app.modules.perception.saliency.sphere_grid import SphereGrid
from app.modules.saliency_gains import FEATURES, SaliencyGains, gains_of
from app.modules.stream_module import robot_link
from app.runtime.errors import ModuleFailed
from app.runtime.module import Module, ModuleContext, Settings

#: Saliency (of all gains 1) that the map shows as its most.
FULL = 1.0
#: Levels (dB of full scale) of sounds that hardly count, and that count fully.
_LEVELS_DB = (-65.0, -30.0)
#: So long (s) after a loud noise sounds count twice.
_STARTLED_S = 1.0


class EgoSphereSettings(Settings):
    """Settings of EgoSphere."""

    eye: str = Field(min_length=1, description="link of the model in the middle of the sphere: the head's camera")
    cell_deg: float = Field(3.0, ge=1, le=15, description="size of a direction; 360 is a multiple of it")
    top_deg: float = Field(48.0, gt=0, le=80, description="how far up and down the sphere reaches")
    range_m: float = Field(2.5, gt=0, le=50, description="distance of what another camera than the eye sees")
    decay_s: float = Field(1.0, gt=0, le=60, description="time constant in which what was perceived fades")
    recovery_s: float = Field(6.0, gt=0, le=600, description="... in which what was looked at is salient again")
    apart_deg: float = Field(20.0, gt=0, le=90, description="least angle between two regions")
    least: float = Field(0.08, gt=0, le=1, description="least saliency of a region")
    face_deg: float = Field(5.0, gt=0, le=30, description="how wide a face is taken to be")
    sound_deg: float = Field(7.0, gt=0, le=30, description="... and a sound")
    turning_degps: float = Field(20.0, gt=0, le=180, description="pictures of a camera that turns faster do not count")
    moved_m: float = Field(0.03, gt=0, le=1, description="after a way as long, two pictures show no motion")
    period_s: float = Field(0.2, gt=0, le=5, description="time between two messages")


WATCH_SURROUNDINGS = DesireClass(
    name="WatchSurroundings",
    title="Watch surroundings",
    description="Find what stands out all around: what moves, is coloured, sounds, or has a face.",
    parameters=SaliencyGains,
)


class EgoSphere(Module):
    """Finds what stands out."""

    title = "Ego-sphere"
    desire_classes = (WATCH_SURROUNDINGS,)
    auxiliary_inputs = frozenset({"faces", "sources", "noises", "fixations"})
    Settings = EgoSphereSettings
    settings: EgoSphereSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        s = self.settings
        self._grid = SphereGrid(math.radians(s.cell_deg), math.radians(s.top_deg))
        self._sphere = self._empty()
        #: Whether the sphere was emptied since it was last watched.
        self._blank = True
        self._gains = gains_of({}, SaliencyGains())
        self._cameras: dict[str, PictureFeatures] = {}
        self._p_BH = np.zeros(3)
        self._noise = -math.inf
        self._newest: Odometry | None = None
        self._poses = PoseAt(self.clock, self.log, "nothing stands out")
        self.images = self.input("images", Image)
        self.panorama = self.input("panorama", Image)
        self.faces = self.input("faces", Faces, capacity=8, wants="if_wanted")
        self.sources = self.input("sources", SoundSources, capacity=8, wants="if_wanted")
        self.noises = self.input("noises", LoudNoise, capacity=8, wants="if_wanted")
        self.fixations = self.input("fixations", Fixation, capacity=8, wants="never")
        self.odometry = self.input("odometry", Odometry, capacity=100, always_open=True, rests=True)
        self.regions = self.output("regions", SalientRegions)
        self.saliency = self.output("saliency", SaliencyMap)
        self.on(self.images, self._see)
        self.on(self.panorama, self._see)
        self.on(self.faces, self._take_faces)
        self.on(self.sources, self._take_sources)
        self.on(self.noises, self._take_noise)
        self.on(self.fixations, self._take_fixation)
        self.on(self.odometry, self._take_odometry)
        self.every(s.period_s, self._beat)

    async def start(self) -> None:
        """Read the body's model. Raises ModuleFailed for a body without the eye."""
        use_calling_thread()
        body = robot_link(self).description
        try:
            model = await self.compute(load_model, body.model_path)
            self._p_BH = model.pose(self.settings.eye).translation
        except ConfigError as failure:
            raise ModuleFailed(str(failure)) from None
        except KeyError as unknown:
            raise ModuleFailed(f"{self.name} has no middle {self.settings.eye!r}: {unknown.args[0]}") from None

    def configure(self, parameters: Mapping[str, Any]) -> None:
        self._gains = gains_of(parameters, SaliencyGains())

    # --- in ---

    async def _see(self, image: Image) -> None:
        X_OB = await self._poses.logged_at(image.stamp)
        if X_OB is None:
            return
        found = await self.compute(self._features, image, X_OB)
        if found is None:
            return
        self._sphere.fade(image.stamp)
        for feature, values in found.maps.items():
            self._sphere.add(feature, values)

    def _features(self, image: Image, X_OB: Pose2) -> FeatureMaps | None:
        if image.frame not in self._cameras:
            s = self.settings
            rules = MotionRules(math.radians(s.turning_degps), s.moved_m)
            self._cameras[image.frame] = PictureFeatures(self._grid, s.range_m, rules)
        X_OB3 = X_OB.to_pose3()
        p_OH = np.asarray(X_OB3.transform(self._p_BH), np.float64)
        return self._cameras[image.frame].take(image.stamp, image.color, image.camera, X_OB3 @ image.X_BC, p_OH)

    async def _take_faces(self, faces: Faces) -> None:
        X_OB = await self._poses.at(faces.stamp) if faces.faces and self._watched else None
        if X_OB is None:
            return
        self._sphere.fade(faces.stamp)
        for face in faces.faces:
            v_O = X_OB.to_pose3().rotation @ (np.array(face.p_BF) - self._p_BH)
            self._sphere.add_percept("faces", v_O, face.score, math.radians(self.settings.face_deg))

    async def _take_sources(self, sources: SoundSources) -> None:
        X_OB = await self._poses.at(sources.stamp) if sources.sources and self._watched else None
        if X_OB is None:
            return
        self._sphere.fade(sources.stamp)
        startled = 0.0 <= sources.stamp - self._noise <= _STARTLED_S
        for source in sources.sources:
            if source.active:
                v_B = np.array(sources.p_BA) + self._range_of(source) * np.array(source.direction) - self._p_BH
                strength = loudness(source.level_db) * (2.0 if startled else 1.0)
                v_O = X_OB.to_pose3().rotation @ v_B
                self._sphere.add_percept("sounds", v_O, min(1.0, strength), math.radians(self.settings.sound_deg))

    def _range_of(self, source: SoundSource) -> float:
        return source.range_m if math.isfinite(source.range_m) else self.settings.range_m

    def _take_odometry(self, odometry: Odometry) -> None:
        self._poses.add(odometry)
        self._newest = odometry

    def _take_noise(self, noise: LoudNoise) -> None:
        self._noise = noise.stamp

    @property
    def _watched(self) -> bool:
        return self.regions.wanted or self.saliency.wanted

    async def _take_fixation(self, fixation: Fixation) -> None:
        X_OB = await self._poses.at(fixation.stamp)
        if X_OB is not None:
            self._sphere.fade(fixation.stamp)
            self._sphere.inhibit(unit_vector(fixation.azimuth + X_OB.theta, fixation.elevation))

    # --- out ---

    async def _beat(self) -> None:
        if not self._watched:
            if not self._blank:
                # What was seen before it was desired again is over.
                self._sphere, self._blank = self._empty(), True
            return
        self._blank = False
        if self._newest is None:
            return
        # Of odometry's own instant: of that there is a pose.
        stamp, X_OB = self._newest.stamp, self._newest.X_OB
        self._sphere.fade(stamp)
        if self.regions.wanted:
            peaks = self._sphere.peaks(self._gains)
            x, y, z = self._p_BH.tolist()
            regions = tuple(_region(peak, X_OB.theta) for peak in peaks)
            self.regions.publish(SalientRegions(stamp, (x, y, z), regions))
        if self.saliency.wanted:
            values = self._grid.turned(self._sphere.saliency(self._gains), X_OB.theta)
            cells = np.clip(values * (255 / FULL), 0, 255).astype(np.uint8)
            self.saliency.publish(SaliencyMap(stamp, self._grid.step_rad, FULL, read_only(cells)))

    def _empty(self) -> Sphere:
        s = self.settings
        rules = SphereRules(
            decay_s=s.decay_s, recovery_s=s.recovery_s, apart_rad=math.radians(s.apart_deg), least=s.least
        )
        return Sphere(self._grid, rules)


def loudness(level_db: float) -> float:
    """How much a sound of a level (dB of full scale) counts, 0 to 1; one at the threshold of being heard a tenth."""
    low, high = _LEVELS_DB
    return min(1.0, max(0.1, (level_db - low) / (high - low)))


def _region(peak: Peak, heading: float) -> SalientRegion:
    v_B = unit_vector(peak.azimuth - heading, peak.elevation)
    azimuth, elevation = azimuth_elevation(np.asarray(v_B))
    shares = {name: round(float(peak.shares.get(name, 0.0)), 4) for name in FEATURES}
    return SalientRegion(round(azimuth, 4), round(elevation, 4), round(peak.saliency, 4), **shares)
