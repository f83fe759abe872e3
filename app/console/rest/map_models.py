"""The shapes of what REST tells of maps and goals and is asked of them."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from app.base.library import NAME
from app.console.rest.models import Answer, DesireModel, Request, Stamp
from app.maps.zones import FURTHEST_M

#: What a map may be called, for the OpenAPI description; the library itself refuses others, in its own words.
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


class CurrentMap(Answer):
    """The map in use."""

    available: bool = Field(description="Whether this program makes maps; if not, nothing of this can be asked.")
    name: str = Field(description="Empty while it has none.")
    state: Literal["mapping", "tracking", "searching", "lost"] | None = Field(
        description="Of the robot's place on it, as on the live stream; null before it is known."
    )
    stamp: float | None = Field(description="When that was so (robot's clock).")


class MapModel(Answer):
    """A map that is kept."""

    name: str = Field(examples=["ground-floor"])
    in_use: bool
    saved: Stamp
    size_m: tuple[float, float] = Field(description="Width and height of its picture.")
    resolution_m: float = Field(description="Of one cell, and of one pixel.")
    known_m2: float = Field(description="How much floor and wall of it is known.")
    extendable: bool = Field(description="Whether it can go on growing when it is loaded.")
    zones: int = Field(description="How many it has.")
    problem: str | None = Field(description="Why it cannot be used, in words.")


class MapList(Answer):
    """Every map that is kept, by name, and the one in use."""

    folder: str
    current: CurrentMap
    maps: list[MapModel]


class LoadRequest(Request):
    """How to take a map into use."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"pose": {"x": 0, "y": 0, "theta": 0}}]})

    pose: PoseRequest | None = Field(
        None, description="Where the robot is about, within 1 m and 0.5 rad; null: it looks for itself."
    )
    extend: bool = Field(False, description="Whether the map goes on growing; else it stays as it is.")


class RenameRequest(Request):
    """What to change of a map."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"name": "ground-floor"}]})

    name: str = Field(description="What it is called from now on.", json_schema_extra={"pattern": NAME_PATTERN})


class ZoneModel(Request):
    """A part of the map where the robot is told how to drive."""

    name: str = Field(min_length=1, max_length=100, description="What people call it; no two share one.")
    kind: Literal["keep_out", "slow"] = Field(description="The robot keeps out of it, or drives slowly in it.")
    polygon: list[Annotated[list[Metres], Field(min_length=2, max_length=2)]] = Field(
        min_length=3, max_length=1000, description="Its corners, x and y on the map (m)."
    )
    speed: float = Field(
        0.5, gt=0, le=1, description="Share of the robot's greatest speed allowed in it; means nothing to `keep_out`."
    )


class ZonesModel(Request):
    """Every zone of the map."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"zones": [{"name": "stairs", "kind": "keep_out", "polygon": [[0, 0], [2, 0], [2, 1]], "speed": 1}]}
            ]
        }
    )

    zones: list[ZoneModel] = Field(max_length=MOST_ZONES)


class GoalRequest(Request):
    """Where to go."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"x": 2.5, "y": 1.0, "heading": 1.57}]})

    x: Metres = Field(description="On the map (m).")
    y: Metres = Field(description="On the map (m).")
    heading: Radians | None = Field(None, description="On the map (rad); null: any will do.")
    speed: float | None = Field(None, gt=0, le=1, description="Share of the robot's greatest speed; null: as usual.")


class PlaceModel(Answer):
    """A place on the map."""

    x: float | None
    y: float | None
    theta: float | None = Field(description="null: any heading.")


class GivenUpModel(Answer):
    """A goal that the robot has given up."""

    stamp: Stamp
    goal: PlaceModel
    reason: str = Field(description="Why, in words.")


class NavigationModel(Answer):
    """What the behavior that goes somewhere is about; as `navigation` on the live stream."""

    stamp: Stamp
    behavior: str = Field(description="Empty before any has spoken.")
    state: Literal["idle", "planning", "following", "recovering", "waiting", "arrived", "unreachable"]
    reason: str = Field(description="In words, and what would help.")
    goal: PlaceModel | None
    target: PlaceModel | None = Field(description="Where it really goes: the nearest reachable place.")
    remaining_m: float | None
    recoveries: int
    desire: str | None = Field(description="Id of the strongest desire to go somewhere.")
    path: list[tuple[float, float]] = Field(description="Points on the map (m), at most 200.")
    given_up: GivenUpModel | None = Field(
        description="The goal given up last, until there is another or DELETE /goal; null: none."
    )


class GoalModel(Answer):
    """What is desired, and what became of it."""

    desire: DesireModel | None = Field(description="The strongest desire of class GoTo; null: nobody has one.")
    navigation: NavigationModel | None = Field(description="null: nobody here goes anywhere.")
