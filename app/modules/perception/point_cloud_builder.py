"""PointCloudBuilder: coloured point clouds of a depth camera (thesis 3.4).

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ PointCloudBuilder    in   images    Image with depth, 15 Hz / φ                          │
    │                      in   odometry  Odometry, 100 Hz, X_OB in odom; never filtered       │
    │                      out  clouds    PointCloud in base_link (m), with each image taken   │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

    p_B = X_BC · z · K⁻¹ (u, v, 1)ᵀ

over a regular grid of at most ``max_points`` pixels, a parameter of the desire Telepresence. Each cloud carries the
pose X_OB of its own instant: the builder waits for odometry of that instant and drops a cloud without it (the thesis's
clouds were drawn with a newer pose than their own, and smeared).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import Field

from app.messages import Image, Odometry, PointCloud, read_only
from app.modules.perception.point_cloud import colored_cloud
from app.modules.perception.pose_at import PoseAt
from app.modules.perception.telepresence import TELEPRESENCE
from app.runtime.module import Module, ModuleContext, Settings


class PointCloudBuilderSettings(Settings):
    max_points: int = Field(19_200, ge=1, description="used while no desire says another")


class PointCloudBuilder(Module):
    title = "Point cloud"
    desire_classes = (TELEPRESENCE,)
    Settings = PointCloudBuilderSettings
    settings: PointCloudBuilderSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._max_points = self.settings.max_points
        self._poses = PoseAt(self.clock, self.log, "clouds are dropped")
        self.images = self.input("images", Image)
        self.odometry = self.input("odometry", Odometry, capacity=100, always_open=True, rests=True)
        self.clouds = self.output("clouds", PointCloud)
        self.on(self.images, self._build)
        self.on(self.odometry, self._poses.add)

    def configure(self, parameters: Mapping[str, Any]) -> None:
        self._max_points = int(parameters.get("max_points", self.settings.max_points))

    async def _build(self, image: Image) -> None:
        points, colors = await self.compute(colored_cloud, image, self._max_points)
        X_OB = await self._poses.logged_at(image.stamp)
        if X_OB is not None:
            self.clouds.publish(PointCloud(image.stamp, read_only(points), read_only(colors), X_OB))
