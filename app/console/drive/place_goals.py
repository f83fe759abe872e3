"""Goals by the name of a place: its parameters of GoTo, and why the robot cannot go there."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from app.base.yaml_source import likeliest
from app.console import reports
from app.console.drive.goals import GO_TO
from app.console.problems import Problem
from app.maps.map_service import MapUnavailable
from app.maps.place_checks import inscribed_radius_m, obstruction
from app.maps.places import go_to_parameters, pose_of
from app.messages import Place, Zones

if TYPE_CHECKING:
    from app.program.system import System

#: So many known places are listed in a refusal.
_LISTED = 12


def place_called(system: System, id_: str, field: str) -> Place:
    """The place with the id ``id_`` on the map in use. Raises Problem 422 about ``field``, 409 without places."""
    try:
        places = system.places.server.places
    except MapUnavailable as refusal:
        raise Problem(409, "map-unavailable", f"{refusal}.") from None
    found = next((place for place in places if place.id == id_), None)
    if found is None:
        words = no_such_place(id_, [place.id for place in places])
        raise Problem(422, "no-such-place", f"{field}: {words}.", errors=[(field, words)])
    return found


def no_such_place(id_: str, known: list[str]) -> str:
    """The sentence for an id that no place has."""
    more = f" and {len(known) - _LISTED} more" if len(known) > _LISTED else ""
    there_are = f"{', '.join(known[:_LISTED]) or 'none'}{more}"
    return f"no place of the map in use has the id {id_!r}; {likeliest(id_, known)}there are: {there_are}"


def goal_at(system: System, id_: str, field: str) -> dict[str, Any]:
    """Parameters of GoTo for a place. Raises Problem 422 where there is none of this id, 409 where the robot cannot
    stand there by its map and zones."""
    place = place_called(system, id_, field)
    zones: Zones | None = reports.latest(system.graph, "zones")
    radius_m = inscribed_radius_m(system.link.description.footprint)
    grid = reports.latest(system.graph, "map")
    if why := obstruction(pose_of(place), grid, () if zones is None else zones.zones, radius_m):
        words = f"the robot cannot stand at {place.name}: {why}"
        raise Problem(409, "place-obstructed", f"{words[0].upper()}{words[1:]}.", errors=[(field, words)])
    return go_to_parameters(place)


def with_place(system: System, cls: str, params: Mapping[str, Any]) -> dict[str, Any]:
    """``params`` of a desire of ``cls``; where they name a ``place`` to go to, and no coordinates, with those of it.

    Raises Problem as :func:`goal_at`.
    """
    id_ = params.get("place")
    if cls != GO_TO or cls not in system.classes or not isinstance(id_, str) or "x" in params or "y" in params:
        return dict(params)
    return goal_at(system, id_, "params.place") | dict(params)
