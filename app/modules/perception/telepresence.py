"""The desire class Telepresence, which the camera's picture, the panorama and the point cloud serve."""

from __future__ import annotations

from pydantic import BaseModel, Field

from app.attention.desires import DesireClass


class TelepresenceParameters(BaseModel, extra="forbid", title="See through the robot's eyes"):
    max_points: int = Field(
        19_200, ge=1_000, le=76_800, title="Points", description="Most points of one coloured point cloud."
    )
    jpeg_quality: int = Field(
        80, ge=30, le=95, title="Picture quality", description="JPEG quality of the camera picture, 30 to 95."
    )


TELEPRESENCE = DesireClass(
    name="Telepresence",
    title="See through the robot's eyes",
    description="Send people the camera's picture and its coloured point cloud (m, in base_link).",
    parameters=TelepresenceParameters,
)
