"""Requests about maps and goals, checked as it comes in."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from app.base.named_library import NAME
from app.console.rest.models import Request
from app.maps.zones import FURTHEST_M

#: The names that a map may have, for the OpenAPI description; the library itself refuses others, in its own words.
NAME_PATTERN = f"^{NAME.pattern}$"
#: More would not fit into a body.
MOST_ZONES = 500

Metres = Annotated[float, Field(ge=-FURTHEST_M, le=FURTHEST_M)]
Radians = Annotated[float, Field(ge=-1000, le=1000, description="Heading on the map, left positive.")]


class PoseRequest(Request):
    """A pose on the map."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"x": 1.5, "y": -0.5, "theta": 1.57}]})

    x: Metres
    y: Metres
    theta: Radians


class LoadRequest(Request):
    """How to take a map into use."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"pose": {"x": 0, "y": 0, "theta": 0}}]})

    pose: PoseRequest | None = Field(
        None, description="Rough pose of the robot, within 1 m and 0.5 rad; null: global localization searches for it."
    )
    extend: bool = Field(False, description="Whether mapping continues in this map; else it is only localized in.")


class RenameRequest(Request):
    """A change of a map."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"name": "ground-floor"}]})

    name: str = Field(description="The new name.", json_schema_extra={"pattern": NAME_PATTERN})


class ZoneRequest(Request):
    """A part of the map with a rule for driving in it."""

    name: str = Field(min_length=1, max_length=100, description="Unique name for people.")
    kind: Literal["keep_out", "slow"] = Field(description="The robot keeps out of it, or drives slowly in it.")
    polygon: list[Annotated[list[Metres], Field(min_length=2, max_length=2)]] = Field(
        min_length=3, max_length=1000, description="Its corners, x and y on the map (m)."
    )
    speed: float = Field(
        0.5, gt=0, le=1, description="Share of the robot's greatest speed allowed in it; means nothing to `keep_out`."
    )


class ZonesRequest(Request):
    """Every zone of the map."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"zones": [{"name": "stairs", "kind": "keep_out", "polygon": [[0, 0], [2, 0], [2, 1]], "speed": 1}]}
            ]
        }
    )

    zones: list[ZoneRequest] = Field(max_length=MOST_ZONES)


class GoalRequest(Request):
    """A goal for the robot: ``x`` and ``y``, or ``place``."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"x": 2.5, "y": 1.0, "heading": 1.57}, {"place": "robotics-lab"}]}
    )

    x: Metres | None = Field(None, description="On the map (m).")
    y: Metres | None = Field(None, description="On the map (m).")
    place: str | None = Field(
        None, max_length=100, description="Id of a place of the map, instead of `x`, `y` and `heading`."
    )
    heading: Radians | None = Field(None, description="On the map (rad); null: any heading.")
    speed: float | None = Field(None, gt=0, le=1, description="Share of the robot's greatest speed; null: as usual.")
