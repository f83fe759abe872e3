"""QRCodeDetector: which QR codes the camera sees, and where they hang (thesis 4.2).

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ QRCodeDetector    in   images     Image with depth, 15 Hz / φ                            │
    │                   in   odometry   Odometry, 100 Hz, X_OB in odom; never filtered         │
    │                   out  codes      QRCodes, with each image taken, px and m in base_link  │
    │                   out  landmarks  Landmarks (m in odom), when one is added or moves      │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

Decodes (zxing-cpp), takes each code's centre from the depth inside its corners, maps it into ``base_link`` by the
camera's pose X_BC and into ``odom`` by X_OB, both of the image's own stamp, and merges repeated sightings of a text::

    p_OQ = X_OB X_BC p_CQ        p ← p + P / (P + R) · (p_OQ − p)        σ(r) = σ₀ + k r²

Landmarks that stay where they are, are told again once a second while they are seen, for their counts. ``upscale`` (a
second try on the enlarged image) is a parameter of the desire FindQRCodes.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from pydantic import Field

from app.geometry import Pose2
from app.messages import Image, Landmarks, Odometry, QRCode, QRCodes
from app.modules.perception.landmark_map import LandmarkMap, Point, SightingModel
from app.modules.perception.opencv import use_calling_thread
from app.modules.perception.pose_at import PoseAt
from app.modules.perception.qr_codes import detect
from app.runtime.module import Module, ModuleContext, Settings


class QRCodeDetectorSettings(Settings):
    """Settings of QRCodeDetector."""

    upscale: bool = Field(True, description="used while no desire says another")
    gate_m: float = Field(1.0, gt=0, description="the same text further away than this is another landmark")
    sigma_floor_m: float = Field(0.02, gt=0, description="σ₀ of a sighting, and the least σ of a landmark")
    sigma_per_m2: float = Field(0.01, ge=0, description="k: growth of a sighting's σ with the square of its range")
    moved_m: float = Field(0.01, ge=0, description="landmarks that moved less since last published are not news")
    refresh_s: float = Field(1.0, gt=0, description="... unless they were not published for this long")


class QRCodeDetector(Module):
    """Reads codes and remembers where they hang."""

    title = "QR code detector"
    Settings = QRCodeDetectorSettings
    settings: QRCodeDetectorSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._upscale = self.settings.upscale
        self._poses = PoseAt(self.clock)
        self._map = LandmarkMap()
        self._told: Landmarks | None = None
        self._poseless = False
        self.images = self.input("images", Image)
        self.odometry = self.input("odometry", Odometry, capacity=100, always_open=True)
        self.codes = self.output("codes", QRCodes)
        self.landmarks = self.output("landmarks", Landmarks)
        self.on(self.images, self._detect)
        self.on(self.odometry, self._remember)

    async def start(self) -> None:
        """Keep OpenCV's work where it is measured, and go on with the landmarks known before a restart."""
        use_calling_thread()
        channel = self.landmarks.channel
        self._told = None if channel is None else channel.latest
        model = SightingModel(self.settings.sigma_floor_m, self.settings.sigma_per_m2)
        self._map = LandmarkMap(model, self.settings.gate_m, () if self._told is None else self._told.landmarks)

    def configure(self, parameters: Mapping[str, Any]) -> None:
        """Take ``upscale`` from the intention."""
        self._upscale = bool(parameters.get("upscale", self.settings.upscale))

    async def _remember(self, odometry: Odometry) -> None:
        self._poses.add(odometry)

    async def _detect(self, image: Image) -> None:
        codes = await self.compute(detect, image, self._upscale)
        self.codes.publish(QRCodes(image.stamp, image.frame, codes))
        if not any(code.p_BQ for code in codes):
            return
        X_OB = await self._poses.at(image.stamp)
        if (X_OB is None) != self._poseless:
            self._poseless = X_OB is None
            if self._poseless:
                self.log.warning("codes seen are not placed: odometry does not reach the stamps of the images")
            else:
                self.log.info("odometry reaches the stamps of the images again")
        if X_OB is not None:
            self._place(image, X_OB, codes)

    def _place(self, image: Image, X_OB: Pose2, codes: tuple[QRCode, ...]) -> None:
        X_OB3 = X_OB.to_pose3()
        for code in codes:
            if code.p_BQ is not None:
                p_BQ = np.array(code.p_BQ)
                x, y, z = X_OB3.transform(p_BQ).tolist()
                range_m = float(np.linalg.norm(p_BQ - image.X_BC.translation))
                self._map.see(image.stamp, code.text, (x, y, z), range_m)
        known = Landmarks(image.stamp, self._map.landmarks)
        if self._is_news(known):
            self._told = known
            self.landmarks.publish(known)

    def _is_news(self, known: Landmarks) -> bool:
        told = self._told
        if told is None or len(told.landmarks) != len(known.landmarks):
            return True
        if known.stamp - told.stamp >= self.settings.refresh_s:
            return True
        places: list[tuple[Point, Point]] = [
            (a.p_OQ, b.p_OQ) for a, b in zip(told.landmarks, known.landmarks, strict=True)
        ]
        return any(math.dist(before, now) > self.settings.moved_m for before, now in places)
