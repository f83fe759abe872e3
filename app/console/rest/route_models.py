"""Requests about routes, checked as they come in."""

from __future__ import annotations

from pydantic import ConfigDict, Field

from app.console.rest.map_models import Metres, Radians
from app.console.rest.models import Request
from app.maps.places import PLACE_ID
from app.tours.model import MOST_STOPS

#: The stops of the longest tour, with a beginning and an end.
MOST_POINTS = MOST_STOPS + 2


class RoutePoint(Request):
    """A point of a route: a ``place``, or ``x`` and ``y``."""

    place: str | None = Field(None, pattern=f"^{PLACE_ID}$", description="Id of a place of the map in use.")
    x: Metres | None = Field(None, description="On the map (m).")
    y: Metres | None = Field(None, description="On the map (m).")
    heading: Radians | None = Field(None, description="On the map (rad); null: any heading.")


class RouteRequest(Request):
    """Points to drive to, one after another."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"points": [{"x": 0, "y": 0}, {"place": "robotics-lab"}], "speed": 0.8}]}
    )

    points: list[RoutePoint] = Field(min_length=2, max_length=MOST_POINTS)
    speed: float = Field(1.0, gt=0, le=1, description="Share of the robot's greatest speed.")
