"""Places: named poses on a map, in ``places.yaml`` beside it and in requests."""

from __future__ import annotations

import json
import math
import re
import unicodedata
from collections.abc import Collection, Iterable
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from app.base.geometry import Pose2, wrap_angle
from app.base.whole_file import write_whole
from app.base.yaml_source import load_yaml
from app.maps.zones import FURTHEST_M
from app.messages import Place

#: A map has at most so many places,
MOST_PLACES = 500
#: and a name or an id so many characters. A QR code holds at most 4296.
LONGEST_NAME, LONGEST_ID, LONGEST_POSTER = 60, 40, 4300
PLACE_ID = rf"[a-z0-9-]{{1,{LONGEST_ID}}}"

Metres = Annotated[float, Field(ge=-FURTHEST_M, le=FURTHEST_M, allow_inf_nan=False)]
_NAMELESS = "place"


class PlaceEntry(BaseModel):
    """One place; see :class:`app.messages.Place`."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    id: str = Field(pattern=f"^{PLACE_ID}$", description="1 to 40 of a-z, 0-9 and '-'; never changes")
    name: str = Field(min_length=1, max_length=LONGEST_NAME, description="what people call it")
    x: Metres = Field(description="m on the map")
    y: Metres = Field(description="m on the map")
    heading: float = Field(ge=-1000, le=1000, allow_inf_nan=False, description="rad on the map")
    source: Literal["hand", "here", "poster"] = "hand"
    poster: str = Field("", max_length=LONGEST_POSTER, description="text of the poster that it is in front of")
    landmark: int = Field(0, ge=0, le=2**31, description="number of that poster on this map; 0: none")

    @field_validator("name")
    @classmethod
    def _is_readable(cls, name: str) -> str:
        if name != name.strip() or not name.isprintable():
            raise ValueError("should be printable, without spaces before or after it")
        return name

    @model_validator(mode="after")
    def _has_its_poster(self) -> PlaceEntry:
        if (self.source == "poster") != (self.poster != ""):
            raise ValueError("a place has a poster's text if and only if its source is poster")
        return self

    def place(self) -> Place:
        """The message."""
        # An angle that is in range already keeps its last bit, so that a file read and written stays as it is.
        heading = self.heading if -math.pi <= self.heading < math.pi else wrap_angle(self.heading)
        return Place(**self.model_dump() | {"heading": heading})

    @staticmethod
    def of(place: Place) -> PlaceEntry:
        """The entry of ``place``. Raises pydantic's ValidationError for one that may not be."""
        return PlaceEntry.model_validate({name: getattr(place, name) for name in PlaceEntry.model_fields})


class PlaceFile(BaseModel):
    """All places of a map."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    places: tuple[PlaceEntry, ...] = Field((), max_length=MOST_PLACES)

    @model_validator(mode="after")
    def _differ(self) -> PlaceFile:
        if (twice := _first_twice(place.id for place in self.places)) is not None:
            raise ValueError(f"two places have the id {twice!r}; each needs an id of its own")
        if (twice := _first_twice(place.name for place in self.places)) is not None:
            raise ValueError(f"two places are called {twice!r}; each needs a name of its own")
        return self


def checked(places: Iterable[Place]) -> tuple[Place, ...]:
    """``places`` without their problems, if they are valid. Raises ValueError, which names the mistake."""
    return tuple(entry.place() for entry in PlaceFile(places=tuple(PlaceEntry.of(each) for each in places)).places)


def read_places(path: Path) -> tuple[Place, ...]:
    """The places in the file ``path``; none where there is no file. Raises ConfigError with file and line."""
    if not path.exists():
        return ()
    return tuple(entry.place() for entry in load_yaml(path).validate(PlaceFile).places)


def places_text(places: Iterable[Place]) -> str:
    """The content of ``places.yaml``: one place a block, in the order given."""
    lines = ["# Places of this map: x and y in m, heading in rad; an id never changes, a name may."]
    entries = [PlaceEntry.of(place) for place in places]
    lines.append("places:" if entries else "places: []")
    for entry in entries:
        for number, (field, value) in enumerate(entry.model_dump(exclude_defaults=True).items()):
            lines.append(f"  {' ' if number else '-'} {field}: {json.dumps(value)}")
    return "\n".join(lines) + "\n"


def write_places(path: Path, places: Iterable[Place]) -> None:
    """Write ``places.yaml`` to ``path``, wholly or not at all. Raises OSError."""
    write_whole(path, places_text(places).encode())


def new_id(name: str, taken: Collection[str]) -> str:
    """An id made of ``name`` that is not in ``taken``: ``Robotics lab`` becomes ``robotics-lab``, or, where that is
    taken, ``robotics-lab-2``."""
    ascii_only = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode().lower()
    plain = re.sub(r"[^a-z0-9]+", "-", ascii_only).strip("-")[:LONGEST_ID].rstrip("-") or _NAMELESS
    found, number = plain, 1
    while found in taken:
        number += 1
        end = f"-{number}"
        found = f"{plain[: LONGEST_ID - len(end)].rstrip('-')}{end}"
    return found


def new_name(wanted: str, taken: Collection[str]) -> str:
    """``wanted``, made printable and short enough for a name, with a number where it is in ``taken``."""
    plain = " ".join("".join(c if c.isprintable() else " " for c in wanted).split()) or _NAMELESS
    found, number = plain[:LONGEST_NAME].rstrip(), 1
    while found in taken:
        number += 1
        end = f" {number}"
        found = f"{plain[: LONGEST_NAME - len(end)].rstrip()}{end}"
    return found


def with_pose(place: Place, pose: Pose2) -> Place:
    """``place`` at ``pose``, which a person gave: it follows no poster from then on."""
    x, y, heading = round(pose.x, 4), round(pose.y, 4), round(wrap_angle(pose.theta), 5)
    return replace(place, x=x, y=y, heading=heading, source="hand", poster="", landmark=0)


def pose_of(place: Place) -> Pose2:
    """``X_MP``: its pose on the map."""
    return Pose2(place.x, place.y, place.heading)


def go_to_parameters(place: Place) -> dict[str, Any]:
    """Parameters of a desire of class GoTo for ``place``, as it is now; to be added to: tolerances, speed."""
    return {"x": place.x, "y": place.y, "heading": place.heading, "place": place.id, "name": place.name}


def _first_twice(values: Iterable[str]) -> str | None:
    seen: set[str] = set()
    for value in values:
        if value in seen:
            return value
        seen.add(value)
    return None
