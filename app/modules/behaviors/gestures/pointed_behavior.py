"""Behaviors of the arms whose desires are about a point in the room.

┌─────────────────────────────────────────────────────────────────────────────────────────┐
│ beside those of ArmBehavior                                                             │
│            in   odometry         Odometry, X_OB in odom; never filtered                 │
│            in   localization     Localization, X_MO: for points on the map              │
└─────────────────────────────────────────────────────────────────────────────────────────┘
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from app.base.geometry import Pose2
from app.messages import Localization, Odometry
from app.modules.behaviors.gaze.look_at import LOCALIZED, PointOfInterest
from app.modules.behaviors.gestures.arm_behavior import ArmBehavior
from app.modules.behaviors.gestures.gesture import GestureView
from app.runtime.module import ModuleContext


class PointedBehavior(ArmBehavior):
    """A behavior of the arms that sees the point of its desire in ``base_link``."""

    auxiliary_inputs = frozenset({"localization"})

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.odometry = self.input("odometry", Odometry, always_open=True, rests=True)
        self.localization = self.input("localization", Localization, rests=True)
        self.on(self.odometry, self._take_odometry)
        self.on(self.localization, self._take_localization)
        self._point: PointOfInterest | None = None
        self._X_OB: Pose2 | None = None
        self._X_MO: Pose2 | None = None

    def take_point(self, params: Mapping[str, Any]) -> None:
        """Take the point from a desire's parameters ``x``, ``y``, ``z`` (m) and ``frame``."""
        p_FP = np.array([params["x"], params["y"], params["z"]], dtype=np.float64)
        self._point = PointOfInterest(p_FP, params["frame"])

    def view(self) -> GestureView:
        """What the gesture sees now, the point among it."""
        p_BP = None if self._point is None else self._point.in_base(self._X_OB, self._X_MO)
        return replace(super().view(), p_BP=p_BP)

    async def _take_odometry(self, odometry: Odometry) -> None:
        self._X_OB = odometry.X_OB

    async def _take_localization(self, localization: Localization) -> None:
        self._X_MO = localization.X_MO if localization.state in LOCALIZED else None
