"""Places of the map in use."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from msgspec import Meta

from app.messages import PlaceSource
from app.messages.base import doc


@dataclass(frozen=True, slots=True)
class PlaceReport:
    """A named pose on the map."""

    id: Annotated[str, Meta(description="Never changes.", examples=["robotics-lab"])]
    name: Annotated[str, Meta(description="For people; no two places share one.", examples=["Robotics lab"])]
    x: Annotated[float, doc("On the map (m).")]
    y: Annotated[float, doc("On the map (m).")]
    heading: Annotated[float, doc("On the map (rad).")]
    source: Annotated[
        PlaceSource,
        doc("`hand`: by its coordinates. `here`: where the robot stood. `poster`: in front of one, which it follows."),
    ]
    poster: Annotated[str, doc("Text of that poster; empty: none.")]
    landmark: Annotated[int, doc("Number of that poster's landmark on this map; 0: none.")]
    problem: Annotated[str, doc("Why the robot cannot stand there, or what is doubtful, in words; empty: nothing.")]
    etag: Annotated[str, doc("Its version, for `If-Match`. A pose that follows its poster is no new version.")]


@dataclass(frozen=True, slots=True)
class PlaceList:
    """Every place of the map in use, in the order of their making."""

    places: tuple[PlaceReport, ...]
