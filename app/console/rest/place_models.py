"""Requests about places, checked as they come in."""

from __future__ import annotations

from typing import Annotated

from pydantic import ConfigDict, Field

from app.console.rest.map_models import Metres, Radians
from app.console.rest.models import Request, never_null
from app.maps.places import LONGEST_NAME, LONGEST_POSTER, PLACE_ID

PlaceName = Annotated[
    str,
    Field(min_length=1, max_length=LONGEST_NAME, description="For people; no two places of a map share one."),
]


class PlacePose(Request):
    """A pose on the map."""

    x: Metres
    y: Metres
    heading: Radians


class PosterChoice(Request):
    """A poster (a QR code) that was found on the map."""

    text: str = Field(min_length=1, max_length=LONGEST_POSTER, description="What it says.")
    near: Annotated[list[Metres], Field(min_length=2, max_length=2)] | None = Field(
        None, description="x and y (m) on the map: of several with this text the nearest to there; null: the first."
    )


class PlaceContent(Request):
    """A place but for its id: exactly one of ``pose``, ``here`` and ``poster`` is given."""

    name: PlaceName | None = Field(None, description="For people; null: the poster's text, or a name with a number.")
    pose: PlacePose | None = Field(None, description="By its coordinates.")
    here: bool = Field(False, description="Where the robot is now, with the heading that it has.")
    poster: PosterChoice | None = Field(
        None, description="In front of a poster, looking at it; it moves with the poster as the map is corrected."
    )


class NewPlace(PlaceContent):
    """A place to create."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"name": "Dock", "pose": {"x": 0.5, "y": 0, "heading": 0}}]}
    )

    id: str | None = Field(
        None, pattern=f"^{PLACE_ID}$", description="Never changes; null: made of the name.", examples=["dock"]
    )


class PlaceReplacement(PlaceContent):
    """A place in whole."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"name": "Window", "here": True}]})


class PlaceChange(Request):
    """A change of a place; members left out stay."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"name": "Robotics laboratory"}]})

    name: PlaceName | None = Field(None, json_schema_extra=never_null)
    pose: PlacePose | None = Field(
        None, description="By hand: it follows no poster from then on.", json_schema_extra=never_null
    )
