"""QRCodeDetector: detection and positions of QR codes (thesis 4.2).

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ QRCodeDetector    in   images     Image with depth, 15 Hz / φ                            │
    │                   in   panorama   Image of a fisheye, no depth, 10 Hz / φ; may be absent │
    │                   in   scans      LaserScan, 40 Hz / φ, in X_BL; may be absent           │
    │                   in   odometry   Odometry, 100 Hz, X_OB in odom; never filtered         │
    │                   out  codes      QRCodes, with each image taken, px and m in base_link  │
    │                   out  landmarks  Landmarks (m in odom), when one is added or moves      │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

Decodes (zxing-cpp), takes each code's centre from the depth inside its corners, maps it into ``base_link`` by the
camera's pose X_BC and into ``odom`` by X_OB, both of the image's own stamp, and merges repeated sightings of a text::

    p_OQ = X_OB X_BC p_CQ        p ← p + P / (P + R) · (p_OQ − p)        σ(r) = σ₀ + k r²

A fisheye's images are read in undistorted patches. A code in an image without depth is placed where the ray through its
centre meets a wall of the scan within ``scan_age_s`` of the image; it has no position where that is ambiguous
(``laser_ray``), or where its size would exceed ``largest_code_m``.

Unmoved landmarks are published once a second while they are seen, for their counts. ``upscale`` (a
second try on the enlarged image, not for a fisheye's) is a parameter of the desire FindQRCodes.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from app.attention.desires import DesireClass
from app.base.geometry import FisheyeModel, Pose2
from app.messages import Image, Landmarks, LaserScan, Odometry, QRCode, QRCodes
from app.modules.perception.fisheye_patches import FisheyePatches
from app.modules.perception.landmark_map import LandmarkMap, Point, SightingModel
from app.modules.perception.laser_ray import scan_points, wall_on_ray
from app.modules.perception.opencv import use_calling_thread
from app.modules.perception.pose_at import PoseAt
from app.modules.perception.qr_codes import central_ray, corner_rays, detect, detect_panorama, edge_angle
from app.runtime.module import Module, ModuleContext, Settings

#: Number of kept scans: those of the time the slowest image takes.
_SCANS = 16


class QRCodeDetectorSettings(Settings):
    upscale: bool = Field(True, description="used while no desire says another")
    patches: int = Field(4, ge=1, le=32, description="most patches of one panoramic image that are looked into")
    gate_m: float = Field(1.0, gt=0, description="the same text further away than this is another landmark")
    sigma_floor_m: float = Field(0.02, gt=0, description="σ₀ of a sighting, and the least σ of a landmark")
    sigma_per_m2: float = Field(0.01, ge=0, description="k: growth of a sighting's σ with the square of its range")
    moved_m: float = Field(0.01, ge=0, description="landmarks that moved less since last published are not news")
    refresh_s: float = Field(1.0, gt=0, description="... unless they were not published for this long")
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
    auxiliary_inputs = frozenset({"scans"})
    Settings = QRCodeDetectorSettings
    settings: QRCodeDetectorSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._upscale = self.settings.upscale
        self._poses = PoseAt(self.clock, self.log, "codes seen are not placed")
        self._map = LandmarkMap()
        self._published: Landmarks | None = None
        self._patches: FisheyePatches | None = None
        self._scans: deque[LaserScan] = deque(maxlen=_SCANS)
        self.images = self.input("images", Image)
        self.panorama = self.input("panorama", Image)
        self.scans = self.input("scans", LaserScan, capacity=_SCANS)
        self.odometry = self.input("odometry", Odometry, capacity=100, always_open=True)
        self.codes = self.output("codes", QRCodes)
        self.landmarks = self.output("landmarks", Landmarks)
        self.on(self.images, self._detect)
        self.on(self.panorama, self._detect)
        self.on(self.scans, self._scans.append)
        self.on(self.odometry, self._poses.add)

    async def start(self) -> None:
        """Keep OpenCV's work in the module's thread, and continue with the landmarks from before a restart."""
        use_calling_thread()
        channel = self.landmarks.channel
        self._published = None if channel is None else channel.latest
        model = SightingModel(self.settings.sigma_floor_m, self.settings.sigma_per_m2)
        self._map = LandmarkMap(
            model, self.settings.gate_m, () if self._published is None else self._published.landmarks
        )

    def configure(self, parameters: Mapping[str, Any]) -> None:
        self._upscale = bool(parameters.get("upscale", self.settings.upscale))

    async def _detect(self, image: Image) -> None:
        codes = await self._read(image)
        measured = any(code.p_BQ for code in codes)
        by_laser = bool(codes) and image.depth is None and bool(self._scans)
        if not by_laser:
            self.codes.publish(_of(image, codes))
            if not measured:
                return
        X_OB = await self._poses.logged_at(image.stamp)
        if by_laser:
            await self._place_on_walls(image, X_OB, codes)
        elif X_OB is not None:
            self._place(image, X_OB, codes)

    async def _read(self, image: Image) -> tuple[QRCode, ...]:
        camera = image.camera
        if not isinstance(camera, FisheyeModel):
            return await self.compute(detect, image, self._upscale)
        if self._patches is None or self._patches.camera != camera:
            self._patches = FisheyePatches(camera)
        return await self.compute(detect_panorama, image, self._patches, self.settings.patches)

    def _place(self, image: Image, X_OB: Pose2, codes: tuple[QRCode, ...]) -> None:
        X_OB3 = X_OB.to_pose3()
        for code in codes:
            if code.p_BQ is not None:
                p_BQ = np.array(code.p_BQ)
                x, y, z = X_OB3.transform(p_BQ).tolist()
                range_m = float(np.linalg.norm(p_BQ - image.X_BC.translation))
                self._map.see(image.stamp, code.text, (x, y, z), range_m)
        self._publish_landmarks(image.stamp)

    async def _place_on_walls(self, image: Image, X_OB: Pose2 | None, codes: tuple[QRCode, ...]) -> None:
        walls = await self._walls(image.stamp)
        if X_OB is None or walls is None:
            self.codes.publish(_of(image, codes))
            return
        X_OC = X_OB.to_pose3() @ image.X_BC
        X_BO = X_OB.to_pose3().inverse()
        placed, found = [], []
        for code in codes:
            rays = corner_rays(code, image.camera)
            hit = wall_on_ray(*walls, X_OC.translation, X_OC.rotation @ central_ray(rays), self.settings.ray_sigma_rad)
            if hit is not None and 2 * hit.range_m * math.tan(edge_angle(rays) / 2) <= self.settings.largest_code_m:
                x, y, z = X_BO.transform(np.array(hit.point)).tolist()
                found.append((code.text, hit))
                placed.append(replace(code, p_BQ=(x, y, z)))
            else:
                placed.append(code)
        self.codes.publish(_of(image, tuple(placed)))
        for text, hit in found:
            self._map.take(image.stamp, text, hit.point, math.hypot(hit.sigma_m, self.settings.wall_sigma_m))
        if found:
            self._publish_landmarks(image.stamp)

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

    def _publish_landmarks(self, stamp: float) -> None:
        # The images of two cameras are processed in turn, and one may come later with an earlier stamp.
        stamp = stamp if self._published is None else max(stamp, self._published.stamp)
        known = Landmarks(stamp, self._map.landmarks)
        if self._is_news(known):
            self._published = known
            self.landmarks.publish(known)

    def _is_news(self, known: Landmarks) -> bool:
        published = self._published
        if published is None or len(published.landmarks) != len(known.landmarks):
            return True
        if known.stamp - published.stamp >= self.settings.refresh_s:
            return True
        places: list[tuple[Point, Point]] = [
            (a.p_FQ, b.p_FQ) for a, b in zip(published.landmarks, known.landmarks, strict=True)
        ]
        return any(math.dist(before, now) > self.settings.moved_m for before, now in places)


def _of(image: Image, codes: tuple[QRCode, ...]) -> QRCodes:
    height, width = image.color.shape[:2]
    return QRCodes(image.stamp, image.frame, width=width, height=height, X_BC=image.X_BC, codes=codes)
