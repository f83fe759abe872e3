"""QRCodeDetector: detection and positions of QR codes (thesis 4.2).

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ QRCodeDetector    in   images     Image with depth, 15 Hz / φ                            │
    │                   in   panorama   Image of a fisheye, no depth, 10 Hz / φ; may be absent │
    │                   in   scans      LaserScan, 40 Hz / φ, in X_BL; may be absent           │
    │                   in   odometry   Odometry, 100 Hz, X_OB in odom; never filtered         │
    │                   in   keyframes  Keyframes of the map, as they come; may be absent      │
    │                   out  codes      QRCodes, with each image taken, px and m in base_link  │
    │                   out  landmarks  Landmarks (m in map or odom), when one is added,       │
    │                                   moves or is gone                                       │
    │                   out  displaced  DisplacedLandmarks (m in map), with the landmarks      │
    │                   out  poses      LandmarkPose: X_MO by a landmark, while it is lost     │
    │                   out  confidence Confidence, by how bright the images are               │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

Decodes (zxing-cpp), takes each code's centre and normal from the depth inside its corners, and maps both into
``base_link`` by the camera's pose X_BC and onto the map by the robot's, all of the image's own stamp. Sightings are
kept with the keyframe that the robot was attached to, and move with it (``landmarks/``)::

    p_KQ = X_MK^-1 X_MO X_OB X_BC p_CQ        sigma(r) = sigma_0 + k r^2

Without a map they are in ``odom``. Landmarks are kept with the map and loaded with it.

A fisheye's images are read in undistorted patches. A code in an image without depth is placed where the ray through its
centre meets a wall of the scan within ``scan_age_s`` of the image; it has no position where that is ambiguous
(``laser_ray``), or where its size would exceed ``largest_code_m``.

Unmoved landmarks are published once a second while they are seen, for their counts. ``upscale`` (a
second try on the enlarged image, not for a fisheye's) is a parameter of the desire FindQRCodes.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from app.attention.desires import DesireClass
from app.base.geometry import FisheyeModel, Pose2
from app.maps.library import MapLibrary
from app.maps.map_service import MapService
from app.messages import (
    Confidence,
    DisplacedLandmarks,
    Image,
    Keyframes,
    LandmarkPose,
    Landmarks,
    LaserScan,
    Odometry,
    QRCode,
    QRCodes,
)
from app.modules.perception.fisheye_patches import FisheyePatches
from app.modules.perception.landmarks.keeper import Found, KeeperSettings, LandmarkKeeper
from app.modules.perception.landmarks.landmark_file import StoredLandmarks
from app.modules.perception.landmarks.landmark_store import LandmarkStore
from app.modules.perception.landmarks.types import LandmarkSettings, Seen
from app.modules.perception.laser_ray import WallPoint, scan_points, wall_on_ray
from app.modules.perception.opencv import use_calling_thread
from app.modules.perception.pose_at import PoseAt
from app.modules.perception.qr_codes import central_ray, corner_rays, detect, detect_panorama, edge_angle
from app.modules.perception.working_conditions import LightReporter
from app.runtime.errors import ModuleFailed
from app.runtime.module import Module, ModuleContext, Settings

#: Number of kept scans: those of the time the slowest image takes.
_SCANS = 16
#: Kept over restarts, so that landmarks stay with their keyframes.
_STATE = "landmarks"
#: Least horizontal part of a normal that has a direction.
_LEVEL = 0.5
#: A robot that moved less (m, rad) in the time (s) before an image stands: its picture is not blurred.
_STILL_M, _STILL_RAD, _STILL_S = 0.03, 0.02, 0.2


class QRCodeDetectorSettings(Settings):
    upscale: bool = Field(True, description="used while no desire says another")
    patches: int = Field(4, ge=1, le=32, description="most patches of one panoramic image that are looked into")
    gate_m: float = Field(1.0, gt=0, description="in odom, the same text further away is another landmark")
    sigma_floor_m: float = Field(0.02, gt=0, description="σ₀ of a sighting, and the least σ of a landmark")
    sigma_per_m2: float = Field(0.01, ge=0, description="k: growth of a sighting's σ with the square of its range")
    moved_m: float = Field(0.01, ge=0, description="landmarks that moved less since last published are not news")
    refresh_s: float = Field(1.0, gt=0, description="... unless they were not published for this long")
    gone_looks: int = Field(10, ge=1, description="looks in a row, from near, without a landmark until it is gone")
    gone_s: float = Field(10.0, ge=0, description="... and the time (s) that they take at least")
    scan_age_s: float = Field(0.1, gt=0, description="a scan further in time from the image places no code of it")
    ray_sigma_rad: float = Field(0.01, ge=0, description="σ of a code's direction, pose and stamps included")
    wall_sigma_m: float = Field(0.03, ge=0, description="σ of a code's wall against what the laser sees of it")
    largest_code_m: float = Field(
        0.4, gt=0, description="edge of the largest code there is: one seen larger at its wall is not on it"
    )


class FindQRCodesParameters(BaseModel, extra="forbid", title="Find QR codes"):
    upscale: bool = Field(
        True,
        title="Second try enlarged",
        description="Look again in the Kinect's image enlarged two times when nothing was found: reads codes from "
        "further away, for about twice the computing time.",
    )


FIND_QR_CODES = DesireClass(
    name="FindQRCodes",
    title="Find QR codes",
    description="Read the QR codes in both cameras' views and remember where they hang (m, in odom).",
    parameters=FindQRCodesParameters,
)


class QRCodeDetector(Module):
    title = "QR code detector"
    desire_classes = (FIND_QR_CODES,)
    auxiliary_inputs = frozenset({"scans", "keyframes"})
    Settings = QRCodeDetectorSettings
    settings: QRCodeDetectorSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._upscale = self.settings.upscale
        self._poses = PoseAt(self.clock, self.log, "codes seen are not placed")
        self._keeper = self._new_keeper()
        self._X_OB: Pose2 | None = None
        self._leave_map: list[Callable[[], None]] = []
        self._patches: FisheyePatches | None = None
        self._scans: deque[LaserScan] = deque(maxlen=_SCANS)
        self.images = self.input("images", Image)
        self.panorama = self.input("panorama", Image)
        self.scans = self.input("scans", LaserScan, capacity=_SCANS)
        self.odometry = self.input("odometry", Odometry, capacity=100, always_open=True, rests=True)
        self.codes = self.output("codes", QRCodes)
        self.keyframes = self.input("keyframes", Keyframes, capacity=16, wants="never")
        self.landmarks = self.output("landmarks", Landmarks)
        self.displaced = self.output("displaced", DisplacedLandmarks)
        self.poses = self.output("poses", LandmarkPose)
        self.confidence = self.output("confidence", Confidence)
        self._light = LightReporter(self.confidence)
        self.on(self.images, self._detect)
        self.on(self.panorama, self._detect)
        self.on(self.scans, self._scans.append)
        self.on(self.odometry, self._take_odometry)
        self.on(self.keyframes, self._follow)

    async def start(self) -> None:
        """Keep OpenCV's work in the module's thread, continue with the landmarks from before a restart, and keep them
        with the map."""
        use_calling_thread()
        self._keeper = self._new_keeper()
        channel = self.landmarks.channel
        published = None if channel is None else channel.latest
        if published is not None:
            self._keeper.resume(published, self.persistent.pop(_STATE, None))
        if self.keyframes.channel is not None and self.keyframes.channel.latest is not None:
            self._keeper.follow(self.keyframes.channel.latest)
        if self.keyframes.connected:
            await self._keep_with_map(resumed=published is not None and bool(published.landmarks))

    async def stop(self) -> None:
        """Leave the map control."""
        for leave in self._leave_map:
            leave()

    def _new_keeper(self) -> LandmarkKeeper:
        settings = self.settings
        landmarks = LandmarkSettings(shared_m=settings.sigma_floor_m, gate_m=settings.gate_m)
        return LandmarkKeeper(
            KeeperSettings(
                landmarks, settings.moved_m, settings.refresh_s, gone_looks=settings.gone_looks, gone_s=settings.gone_s
            ),
            self.log,
        )

    async def _keep_with_map(self, *, resumed: bool) -> None:
        try:
            control, library = self.service(MapService), self.service(MapLibrary)
        except ModuleFailed:
            return  # without a map library, landmarks last as long as the module
        self._leave_map.append(control.on_change(self._change_map))
        store = LandmarkStore(
            self._keeper.snapshot, self._load, library=library, behind=self.compute_background, log=self.log,
            resumed=resumed,
        )  # fmt: skip
        self._leave_map.append(await control.add(store))

    def configure(self, parameters: Mapping[str, Any]) -> None:
        self._upscale = bool(parameters.get("upscale", self.settings.upscale))

    async def _detect(self, image: Image) -> None:
        self._light.look(image)
        codes = await self._read(image)
        measured = any(code.p_BQ for code in codes)
        by_laser = bool(codes) and image.depth is None and bool(self._scans)
        if not by_laser:
            self.codes.publish(_of(image, codes))
            if not measured and not (image.depth is not None and self._keeper.map.known):
                return
        X_OB = await self._poses.logged_at(image.stamp)
        if by_laser:
            await self._place_on_walls(image, X_OB, codes)
        elif X_OB is not None:
            await self._place(image, X_OB, codes)

    async def _read(self, image: Image) -> tuple[QRCode, ...]:
        camera = image.camera
        if not isinstance(camera, FisheyeModel):
            return await self.compute(detect, image, self._upscale)
        if self._patches is None or self._patches.camera != camera:
            self._patches = FisheyePatches(camera)
        return await self.compute(detect_panorama, image, self._patches, self.settings.patches)

    async def _take_odometry(self, odometry: Odometry) -> None:
        self._poses.add(odometry)
        if self._X_OB is not None:
            step = self._X_OB.inverse() @ odometry.X_OB
            self._keeper.map.drive(math.hypot(step.x, step.y))
        self._X_OB = odometry.X_OB

    # --- The map -----------------------------------------------------------------------------------------------------

    async def _follow(self, keyframes: Keyframes) -> None:
        if self._keeper.follow(keyframes):
            self._publish_landmarks(keyframes.stamp, seen=False)

    def _change_map(self) -> None:
        channel = self.keyframes.channel
        latest = None if channel is None else channel.latest
        self._keeper.change_map(0 if latest is None else latest.version)
        if latest is not None:
            self._keeper.follow(latest)
        self._publish_landmarks(self.clock.now(), seen=False)

    def _load(self, stored: StoredLandmarks) -> None:
        self._keeper.load(stored)
        self._publish_landmarks(self.clock.now(), seen=False)

    # --- Sightings ---------------------------------------------------------------------------------------------------

    def _found(self, image: Image, codes: tuple[QRCode, ...]) -> list[Found]:
        """Codes placed by depth."""
        found = []
        for code in codes:
            if code.p_BQ is not None:
                p_BQ = np.array(code.p_BQ)
                range_m = float(np.linalg.norm(p_BQ - image.X_BC.translation))
                sigma_m = self.settings.sigma_floor_m + self.settings.sigma_per_m2 * range_m**2
                found.append((code.text, Seen(p_BQ, sigma_m, *_heading(code))))
        return found

    async def _place(self, image: Image, X_OB: Pose2, codes: tuple[QRCode, ...]) -> None:
        """Codes placed by depth, and landmarks that are not seen."""
        shown = self._take(image, X_OB, found := self._found(image, codes))
        if image.depth is not None and await self._stands(image.stamp, X_OB):
            self._keeper.look(image, X_OB, shown, {code.text for code in codes if code.p_BQ is None})
        self._publish_landmarks(image.stamp, seen=bool(found))

    def _take(self, image: Image, X_OB: Pose2, found: list[Found]) -> frozenset[int]:
        """Take what was found: for a pose of a robot that is lost, else for the landmarks, whose ids are returned."""
        for pose in self._keeper.poses(image.stamp, found, X_OB):
            self.poses.publish(pose)
        return self._keeper.see(image.stamp, found, X_OB)

    async def _stands(self, stamp: float, X_OB: Pose2) -> bool:
        before = await self._poses.at(stamp - _STILL_S)
        if before is None:
            return False
        step = before.inverse() @ X_OB
        return math.hypot(step.x, step.y) < _STILL_M and abs(step.theta) < _STILL_RAD

    async def _place_on_walls(self, image: Image, X_OB: Pose2 | None, codes: tuple[QRCode, ...]) -> None:
        walls = await self._walls(image.stamp)
        if X_OB is None or walls is None:
            self.codes.publish(_of(image, codes))
            return
        X_OC = X_OB.to_pose3() @ image.X_BC
        placed: list[QRCode] = []
        found: list[Found] = []
        for code in codes:
            rays = corner_rays(code, image.camera)
            hit = wall_on_ray(*walls, X_OC.translation, X_OC.rotation @ central_ray(rays), self.settings.ray_sigma_rad)
            if hit is not None and 2 * hit.range_m * math.tan(edge_angle(rays) / 2) <= self.settings.largest_code_m:
                code = _on_wall(code, hit, X_OB)
                sigma_m = math.hypot(hit.sigma_m, self.settings.wall_sigma_m)
                found.append((code.text, Seen(np.array(code.p_BQ), sigma_m, *_heading(code))))
            placed.append(code)
        self.codes.publish(_of(image, tuple(placed)))
        if found:
            self._take(image, X_OB, found)
            self._publish_landmarks(image.stamp, seen=True)

    async def _walls(self, stamp: float) -> tuple[NDArray[np.float64], tuple[float, float], float] | None:
        """The scan nearest to ``stamp``: its points in odom, the laser's position, the angle between its rays."""
        scan = min(self._scans, key=lambda s: abs(s.stamp + 0.5 * s.duration_s - stamp))
        if abs(scan.stamp + 0.5 * scan.duration_s - stamp) > self.settings.scan_age_s:
            return None
        end = await self._poses.at(scan.stamp + scan.duration_s)
        begin = await self._poses.at(scan.stamp)
        if begin is None or end is None:
            return None
        x, y, _ = begin.to_pose3().transform(scan.X_BL.translation).tolist()
        return scan_points(scan, begin, end), (x, y), scan.angle_increment

    def _publish_landmarks(self, stamp: float, *, seen: bool) -> None:
        known = self._keeper.news(stamp, seen=seen)
        if known is not None:
            self.persistent[_STATE] = self._keeper.map.state
            self.landmarks.publish(known)
            self.displaced.publish(self._keeper.displaced(known.stamp))


def _heading(code: QRCode) -> tuple[float | None, float | None]:
    """Direction in ``base_link`` of the normal, and its sigma (rad); of one that points up or down, none."""
    if code.n_BQ is None or code.normal_sigma is None:
        return None, None
    x, y, _ = code.n_BQ
    level = math.hypot(x, y)
    return (math.atan2(y, x), code.normal_sigma / level) if level > _LEVEL else (None, None)


def _on_wall(code: QRCode, hit: WallPoint, X_OB: Pose2) -> QRCode:
    """``code`` at ``hit``, which is in odom."""
    x, y, z = X_OB.to_pose3().inverse().transform(np.array(hit.point)).tolist()
    heading = hit.heading - X_OB.theta
    normal = (math.cos(heading), math.sin(heading), 0.0)
    return replace(code, p_BQ=(x, y, z), n_BQ=normal, normal_sigma=hit.heading_sigma)


def _of(image: Image, codes: tuple[QRCode, ...]) -> QRCodes:
    height, width = image.color.shape[:2]
    return QRCodes(image.stamp, image.frame, width=width, height=height, X_BC=image.X_BC, codes=codes)
