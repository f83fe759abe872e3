"""The desire classes that Docking serves."""

from __future__ import annotations

from typing import Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from app.attention.desires import DesireClass
from app.maps.zones import FURTHEST_M


class DockParameters(BaseModel):
    """Parameters of a desire of class Dock: the dock's pose on the map, all of it or none of it."""

    model_config = ConfigDict(extra="forbid", title="Dock", allow_inf_nan=False)

    x: float | None = Field(
        None, ge=-FURTHEST_M, le=FURTHEST_M, title="x", description="Where its plates meet, in metres on the map."
    )
    y: float | None = Field(
        None, ge=-FURTHEST_M, le=FURTHEST_M, title="y", description="Where its plates meet, in metres on the map."
    )
    heading: float | None = Field(
        None, ge=-7, le=7, title="Heading", description="Where the dock opens to, in rad on the map."
    )

    @model_validator(mode="after")
    def _all_or_none(self) -> Self:
        given = [value is not None for value in (self.x, self.y, self.heading)]
        if any(given) and not all(given):
            raise ValueError("a dock's pose is x, y and heading: give all three, or none for the robot's own dock")
        return self


DOCK = DesireClass(
    name="Dock",
    title="Charge at the dock",
    description="Drive to the dock and into it, and stay there while the battery charges.",
    parameters=DockParameters,
)
UNDOCK = DesireClass(
    name="Undock",
    title="Leave the dock",
    description="Drive straight back out of the dock; the desire ends with it.",
    achievement=True,
)
