"""A module for tests alone: writes where the robot truly is into a file, for a test in another process."""

from __future__ import annotations

import math
import os
from pathlib import Path

from pydantic import Field

from app.base.geometry import Pose2
from app.messages import GroundTruth
from app.modules.stream_module import attach, robot_link
from app.runtime.module import Module, ModuleContext, Settings

STREAM = "ground_truth"
#: One of so many is written.
EVERY = 5


class WitnessSettings(Settings):
    """Settings of Witness."""

    file: str = Field(description="where x, y (m) and heading (rad) in the world go")


class Witness(Module):
    """Sees the truth, and publishes nothing."""

    title = "Witness"
    Settings = WitnessSettings
    settings: WitnessSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._seen = 0

    async def start(self) -> None:
        """Look at the world itself."""
        attach(self, STREAM, GroundTruth, self._see)
        robot_link(self).demand(STREAM, math.inf)

    def _see(self, truth: GroundTruth) -> None:
        self._seen += 1
        if self._seen % EVERY:
            return
        file = Path(self.settings.file)
        fresh = file.with_suffix(".new")
        fresh.write_text(f"{truth.X_WB.x} {truth.X_WB.y} {truth.X_WB.theta}")
        os.replace(fresh, file)


def true_pose(file: Path) -> Pose2:
    """``X_WB``, as written last."""
    return Pose2(*map(float, file.read_text().split()))
