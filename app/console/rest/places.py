"""Places of the map in use: listed, made by coordinates, where the robot is or in front of a poster, and changed."""

from __future__ import annotations

import asyncio
import math
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated

from fastapi import APIRouter, Path
from fastapi.responses import Response

from app.base.geometry import Pose2
from app.base.yaml_source import likeliest
from app.console import reports
from app.console.drive.place_goals import no_such_place
from app.console.page_forms import place_report, place_version
from app.console.problems import Problem
from app.console.records.places import PlaceList, PlaceReport
from app.console.rest.answers import Json, problems
from app.console.rest.entity_tags import IfMatch, check_match, tagged, with_etag
from app.console.rest.place_models import NewPlace, PlaceChange, PlaceContent, PlaceReplacement, PosterChoice
from app.console.rest.routing import router as api_router
from app.maps.map_service import MapUnavailable
from app.maps.place_service import Change, PlaceServer
from app.maps.places import MOST_PLACES, PLACE_ID, new_id, new_name, with_pose
from app.maps.poster_places import in_front_of, poster_named
from app.messages import Localization, Place

if TYPE_CHECKING:
    from app.program.system import System

PlaceId = Annotated[
    str,
    Path(description="The place's id.", examples=["robotics-lab"], json_schema_extra={"pattern": f"^{PLACE_ID}$"}),
]
#: While SLAM rests, odometry is trusted so far (m) from the last pose on the map; a younger one (s) is always.
TRUSTED_M, FRESH_S = 1.0, 5.0
#: So many texts of posters, and characters of each, are listed in a refusal.
_LISTED, _SHOWN = 12, 60
_LOCATION = {"Location": {"schema": {"type": "string"}, "description": "Where the place is."}}


def places_router(system: System) -> APIRouter:
    """Routes of ``/places``."""
    router = api_router("maps")
    #: What is looked up for an edit must not change before it is done.
    one = asyncio.Lock()

    @router.get("/places", response_model=PlaceList, summary="List all places of the map in use")
    async def list_places() -> Response:
        """In the order of their making; each with its `etag`."""
        places = system.places.server.places if system.places.available else ()
        return Json(PlaceList(tuple(map(place_report, places))))

    @router.post(
        "/places",
        response_model=PlaceReport,
        status_code=201,
        summary="Create a place",
        responses=with_etag({201: {"headers": _LOCATION}, **problems(400, 409, 422)}, 201),
    )
    async def create_place(new: NewPlace) -> Response:
        """By its coordinates (`pose`), where the robot is (`here`), or in front of a `poster`: 1.2 m from it along its
        normal, looking at it. It is kept with the map at once if that has a name. One where the robot cannot stand is
        taken, and says so in its `problem`."""
        async with one:
            server = _server()
            place = _made(server, new, new.id)
            return _answer(place.id, await _edited(server, lambda places: (*places, place)), status=201)

    @router.get(
        "/places/{place_id}", response_model=PlaceReport, summary="One place", responses=with_etag(problems(404))
    )
    async def get_place(place_id: PlaceId) -> Response:
        places = system.places.server.places if system.places.available else ()
        _found(places, place_id)
        return _answer(place_id, places)

    @router.put(
        "/places/{place_id}",
        response_model=PlaceReport,
        summary="Replace a place, or create it under this id",
        responses={
            **with_etag(problems(400, 409, 412, 422)),
            **with_etag({201: {"description": "It was created.", "headers": _LOCATION}}, 201),
        },
    )
    async def replace_place(place_id: PlaceId, new: PlaceReplacement, if_match: IfMatch = None) -> Response:
        """Without a name it keeps the one that it has. With `If-Match`, nothing is created."""
        async with one:
            server = _server()
            before = next((place for place in server.places if place.id == place_id), None)
            if before is None and if_match is not None:
                raise Problem(412, "changed-meanwhile", f"There is no place {place_id} any more: nothing was done.")
            if before is not None:
                check_match(if_match, place_version(before))
            place = _made(server, new, place_id, before)

            def change(places: tuple[Place, ...]) -> tuple[Place, ...]:
                if before is None:
                    return (*places, place)
                return tuple(place if each.id == place_id else each for each in places)

            return _answer(place_id, await _edited(server, change), status=201 if before is None else 200)

    @router.patch(
        "/places/{place_id}",
        response_model=PlaceReport,
        summary="Rename or move a place",
        responses=with_etag(problems(400, 404, 409, 412, 422)),
    )
    async def change_place(place_id: PlaceId, change: PlaceChange, if_match: IfMatch = None) -> Response:
        """Members left out stay, and its id does. A place that is moved by hand follows no poster from then on."""
        nulls = [name for name in change.model_fields_set if getattr(change, name) is None]
        if nulls:
            errors = [(name, "cannot be null; leave it out to keep it") for name in nulls]
            raise Problem(422, "invalid-request", "; ".join(map(": ".join, errors)), errors=errors)
        async with one:
            server = _server()
            place = _found(server.places, place_id)
            check_match(if_match, place_version(place))
            if change.name is not None:
                place = replace(place, name=_free_name(change.name, server.places, place_id))
            if change.pose is not None:
                place = with_pose(place, Pose2(change.pose.x, change.pose.y, change.pose.heading))
            after = await _edited(
                server, lambda places: tuple(place if each.id == place_id else each for each in places)
            )
            return _answer(place_id, after)

    @router.delete(
        "/places/{place_id}", status_code=204, summary="Delete a place", responses=problems(404, 409, 412, 422)
    )
    async def delete_place(place_id: PlaceId, if_match: IfMatch = None) -> Response:
        """Goals that were given by it stay: they are its pose."""
        async with one:
            server = _server()
            check_match(if_match, place_version(_found(server.places, place_id)))
            await _edited(server, lambda places: tuple(each for each in places if each.id != place_id))
        return Response(status_code=204)

    def _server() -> PlaceServer:
        try:
            return system.places.server
        except MapUnavailable as refusal:
            raise _unavailable(refusal) from None

    def _made(server: PlaceServer, new: PlaceContent, id_: str | None, before: Place | None = None) -> Place:
        """The place that ``new`` describes. Raises Problem."""
        places = server.places
        ids = {place.id for place in places}
        given = [name for name in ("pose", "here", "poster") if getattr(new, name)]
        if len(given) != 1:
            words = "exactly one of pose, here and poster is needed"
            raise Problem(
                422,
                "invalid-request",
                f"{words[0].upper()}{words[1:]}.",
                errors=[(n, words) for n in given or ["pose"]],
            )
        if before is None and id_ in ids:
            words = f"there is a place with the id {id_!r} already"
            raise Problem(409, "place-exists", f"{words}.", errors=[("id", words)])
        if before is None and len(places) >= MOST_PLACES:
            raise Problem(409, "too-many-places", f"There are {MOST_PLACES} places, the most that a map has.")
        if new.name is not None:
            name = _free_name(new.name, places, id_)
        elif before is not None:
            name = before.name
        else:
            name = new_name("Place" if new.poster is None else new.poster.text, [place.name for place in places])
        place = Place(id_ or new_id(name, ids), name, 0.0, 0.0, 0.0)
        if new.poster is not None:
            return _before_poster(server, place, new.poster)
        if new.pose is not None:
            return with_pose(place, Pose2(new.pose.x, new.pose.y, new.pose.heading))
        return replace(with_pose(place, robot_on_map(system)), source="here")

    return router


def robot_on_map(system: System) -> Pose2:
    """``X_MB`` now: by localization, and by odometry since. Raises Problem while it is not known."""
    localization: Localization | None = reports.latest(system.graph, "localization")
    if localization is None:
        raise Problem(409, "pose-unknown", "Where the robot is on the map is not known: start SLAM.")
    if localization.state not in ("mapping", "tracking"):
        raise Problem(
            409, "pose-unknown", f"The robot does not know where it is on the map: it is {localization.state}."
        )
    odometry = reports.latest(system.graph, "odometry")
    if odometry is None or odometry.stamp < localization.stamp:
        return localization.X_MB
    X_MB = localization.X_MO @ odometry.X_OB
    driven_m = math.hypot(X_MB.x - localization.X_MB.x, X_MB.y - localization.X_MB.y)
    if system.clock.now() - localization.stamp > FRESH_S and driven_m > TRUSTED_M:
        raise Problem(
            409,
            "pose-unknown",
            f"The robot has driven {driven_m:.1f} m since SLAM last said where it is on the map: start SLAM.",
        )
    return X_MB


def _before_poster(server: PlaceServer, place: Place, wanted: PosterChoice) -> Place:
    near = None if wanted.near is None else (wanted.near[0], wanted.near[1])
    poster = poster_named(server.posters, wanted.text, near)
    if poster is None:
        texts = list(dict.fromkeys(poster.text for poster in server.posters))
        shown = ", ".join(repr(text[:_SHOWN]) for text in texts[:_LISTED]) or "none"
        more = f" and {len(texts) - _LISTED} more" if len(texts) > _LISTED else ""
        hint = likeliest(wanted.text[:_SHOWN], [text[:_SHOWN] for text in texts])
        words = f"no poster on the map says {wanted.text[:_SHOWN]!r}; {hint}there are: {shown}{more}"
        raise Problem(409, "no-such-poster", f"{words[0].upper()}{words[1:]}.", errors=[("poster.text", words)])
    try:
        return in_front_of(place, poster)
    except ValueError as lack:
        raise Problem(409, "poster-heading-unknown", f"{lack}.", errors=[("poster.text", str(lack))]) from None


def _free_name(name: str, places: tuple[Place, ...], id_: str | None) -> str:
    other = next((place for place in places if place.name == name and place.id != id_), None)
    if other is None:
        return name
    words = f"another place ({other.id}) is called {name!r}; each needs a name of its own"
    raise Problem(409, "place-exists", f"name: {words}.", errors=[("name", words)])


def _found(places: tuple[Place, ...], id_: str) -> Place:
    found = next((place for place in places if place.id == id_), None)
    if found is None:
        words = no_such_place(id_, [place.id for place in places])
        raise Problem(404, "no-such-place", f"{words[0].upper()}{words[1:]}.")
    return found


async def _edited(server: PlaceServer, change: Change) -> tuple[Place, ...]:
    try:
        return await server.edit(change)
    except MapUnavailable as refusal:
        raise _unavailable(refusal) from None
    except ValueError as refusal:
        field, _, words = str(refusal).rpartition(": ")
        raise Problem(422, "invalid-request", f"{refusal}.", errors=[(field or "body", words)]) from None


def _answer(id_: str, places: tuple[Place, ...], *, status: int = 200) -> Json:
    place = _found(places, id_)
    headers = {"Location": f"/api/v1/places/{id_}"} if status == 201 else {}
    return tagged(place_report(place), version=place_version(place), status=status, headers=headers)


def _unavailable(refusal: MapUnavailable) -> Problem:
    return Problem(409, "map-unavailable", f"{refusal}.")
