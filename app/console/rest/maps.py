"""Maps: those that are kept, the one in use, the robot's place on it and its zones."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import numpy as np
from fastapi import APIRouter, Path
from fastapi.responses import Response
from pydantic import ValidationError

from app.base.broken_rule import broken_rule
from app.base.errors import ConfigError
from app.base.geometry import Pose2
from app.base.yaml_source import validation_message
from app.console import reports
from app.console.drive.goals import dismiss_given_up, withdraw_all
from app.console.page_forms import zone_reports
from app.console.problems import FieldFault, Problem
from app.console.records.maps import CurrentMap, KeptMap, MapList, ZoneList
from app.console.rest.answers import BYTES, Json, problems
from app.console.rest.map_models import NAME_PATTERN, LoadRequest, PoseRequest, RenameRequest, ZonesRequest
from app.console.rest.routing import router as api_router
from app.maps.library import MapFacts, MapNameTaken, UnknownMap
from app.maps.map_service import MapServer, MapUnavailable
from app.maps.zones import ZoneEntry, checked
from app.messages import Zone, Zones, read_only

if TYPE_CHECKING:
    from app.program.system import System

T = TypeVar("T")
Name = Annotated[
    str, Path(description="The map's name.", examples=["ground-floor"], json_schema_extra={"pattern": NAME_PATTERN})
]
PNG = "image/png"


def maps_router(system: System) -> APIRouter:
    """Routes of ``/maps`` and ``/map``."""
    router = api_router("maps")
    library = system.maps
    #: Which map is in use must not change between looking and doing.
    one = asyncio.Lock()

    def forget_goals() -> None:
        withdraw_all(system.workspace)
        dismiss_given_up(system)

    system.map.on_change(forget_goals)

    @router.get("/maps", response_model=MapList, summary="List all maps", responses=problems(409))
    async def list_maps() -> Response:
        """By name; and the one in use, which may have no name yet."""
        facts = await _on_disk(library.listing)
        in_use = current()
        maps = tuple(_kept(fact, in_use.name) for fact in facts)
        return Json(MapList(str(library.folder), in_use, maps))

    @router.get("/map", response_model=CurrentMap, summary="The map in use")
    async def get_map() -> Response:
        return Json(current())

    @router.put("/maps/{name}", response_model=KeptMap, summary="Keep the map in use", responses=problems(409, 422))
    async def save_map(name: Name) -> Response:
        """Under this name, which it has from then on; an older map of this name is replaced. Needs no body."""
        await _existing(name, none_is_fine=True)
        async with one, _server() as server:
            await server.save(name)
        return Json(_kept(await _on_disk(library.facts, name), name))

    @router.post(
        "/maps/{name}/load",
        response_model=CurrentMap,
        summary="Take a map into use",
        responses=problems(400, 404, 409, 422),
    )
    async def load_map(name: Name, load: LoadRequest | None = None) -> Response:
        """In place of the one in use, which is lost if it was not saved. Needs no body: the robot then looks for itself
        on the map, and the map stays as it is. Every goal is withdrawn: it was a place on the other map."""
        load = load or LoadRequest()
        await _existing(name)
        async with one, _server() as server:
            await server.load(name, None if load.pose is None else _pose(load.pose), load.extend)
        return Json(current())

    @router.patch(
        "/maps/{name}", response_model=KeptMap, summary="Rename a map", responses=problems(400, 404, 409, 422)
    )
    async def rename_map(name: Name, change: RenameRequest) -> Response:
        """A name that another map has is refused. The map in use is saved under its new name as it is now."""
        to = change.name
        async with one:
            await _existing(name)
            if to != name and await _existing(to, field="name", none_is_fine=True):
                raise _taken(f"there is a map called {to} already; delete it first, or choose another name")
            if to != name and current().name == name:
                async with _server() as server:
                    await server.save(to)
                await _on_disk(library.delete, name)
            else:
                await _on_disk(library.rename, name, to)
        return Json(_kept(await _on_disk(library.facts, to), current().name))

    @router.delete("/maps/{name}", status_code=204, summary="Delete a map", responses=problems(404, 409, 422))
    async def delete_map(name: Name) -> Response:
        """For good, with its zones. The map in use is refused."""
        async with one:
            await _existing(name)
            if current().name == name:
                raise Problem(
                    409,
                    "map-in-use",
                    f"The map {name} is in use: load another or begin an empty one before deleting it.",
                )
            await _on_disk(library.delete, name)
        return Response(status_code=204)

    @router.get(
        "/maps/{name}/picture",
        response_class=Response,
        summary="A map's picture",
        responses={
            200: {"content": {PNG: {"schema": BYTES}}, "description": "PNG: free white, occupied black, unknown grey."},
            **problems(404, 409, 422),
        },
    )
    async def get_map_picture(name: Name) -> Response:
        """One pixel a cell; its top row has the greatest y."""
        await _existing(name)
        return Response(await _on_disk(library.picture, name), media_type=PNG)

    @router.post("/map/begin", response_model=CurrentMap, summary="Begin an empty map", responses=problems(409))
    async def begin_map() -> Response:
        """Without a name, the robot at its origin. The one in use is lost if it was not saved, and a goal on it
        withdrawn. Needs no body."""
        async with one, _server() as server:
            await server.begin()
        return Json(current())

    @router.put(
        "/map/pose",
        response_model=CurrentMap,
        summary="Set the robot's pose on the map",
        responses=problems(400, 409, 422),
    )
    async def place_robot(pose: PoseRequest) -> Response:
        """On the map in use, within 1 m and 0.5 rad; from there its pose is refined by what the laser sees."""
        async with _server() as server:
            await server.place(_pose(pose))
        return Json(current())

    @router.post("/map/search", response_model=CurrentMap, summary="Start global localization", responses=problems(409))
    async def search_robot() -> Response:
        """It is somewhere on the map in use, and finds out where. Needs no body."""
        async with _server() as server:
            await server.search()
        return Json(current())

    @router.get("/map/zones", response_model=ZoneList, summary="Zones of the map in use")
    async def get_zones() -> Response:
        zones: Zones | None = reports.latest(system.graph, "zones")
        return Json(zone_reports(() if zones is None else zones.zones))

    @router.put(
        "/map/zones",
        response_model=ZoneList,
        summary="Draw the zones of the map in use",
        responses=problems(400, 409, 422),
    )
    async def set_zones(zones: ZonesRequest) -> Response:
        """All of them: what is not named is gone. They are kept with the map at once if it has a name."""
        marked = _zones(zones)
        async with _server() as server:
            await server.mark(marked)
        return Json(zone_reports(marked))

    def current() -> CurrentMap:
        if not system.map.available:
            return CurrentMap(False, "", None, None)
        localization = reports.latest(system.graph, "localization")
        state, stamp = (None, None) if localization is None else (localization.state, localization.stamp)
        return CurrentMap(True, system.map.server.name, state, stamp)

    @asynccontextmanager
    async def _server() -> AsyncIterator[MapServer]:
        """The module that keeps the map; its refusals, and the disk's, become problems."""
        try:
            yield system.map.server
        except (UnknownMap, MapNameTaken, MapUnavailable, ConfigError, OSError) as refusal:
            raise _problem(refusal) from None

    async def _existing(name: str, *, field: str = "path.name", none_is_fine: bool = False) -> bool:
        """Whether there is a map of this name; refused if not, unless ``none_is_fine``, and for a name that cannot
        be."""
        try:
            await asyncio.to_thread(library.existing, name)
        except UnknownMap as refusal:
            if none_is_fine:
                return False
            raise _problem(refusal) from None
        except ValueError as refusal:
            raise Problem(422, "invalid-name", f"{refusal}.", errors=[(field, str(refusal))]) from None
        return True

    return router


async def _on_disk(function: Callable[..., T], *args: Any) -> T:
    """``function(*args)`` of the library, in a thread. Raises Problem."""
    try:
        return await asyncio.to_thread(function, *args)
    except (MapUnavailable, ConfigError, OSError) as refusal:
        raise _problem(refusal) from None


def _problem(refusal: Exception) -> Problem:
    match refusal:
        case UnknownMap():
            return Problem(404, "no-such-map", f"{refusal}.")
        case MapNameTaken():
            return _taken(str(refusal))
        case OSError():
            where = f"{refusal.filename}: " if refusal.filename else ""
            return Problem(409, "disk-refuses", f"The disk refuses: {where}{refusal.strerror or refusal}.")
        case ConfigError():
            return Problem(409, "unreadable-map", f"The map's files are damaged: {refusal}")
    return Problem(409, "map-unavailable", f"{refusal}.")


def _taken(words: str) -> Problem:
    return Problem(409, "map-exists", f"{words}.", errors=[("name", words)])


def _pose(pose: PoseRequest) -> Pose2:
    return Pose2(pose.x, pose.y, pose.theta)


def _zones(zones: ZonesRequest) -> tuple[Zone, ...]:
    """The messages. Raises Problem for a zone without area and for a name that two have."""
    names = [zone.name for zone in zones.zones]
    for number, name in enumerate(names):
        if name in names[:number]:
            message = f"another zone is called {name!r} too; each needs a name of its own"
            raise _invalid_zones([FieldFault(f"zones.{number}.name", message)])
    messages = tuple(
        Zone(zone.name, zone.kind, read_only(np.array(zone.polygon, np.float64)), zone.speed) for zone in zones.zones
    )
    for number, zone in enumerate(messages):
        try:
            checked([zone])
        except ValidationError as refusal:
            raise _invalid_zones(
                [
                    FieldFault(f"zones.{number}.{e['loc'][0]}", validation_message(ZoneEntry, e), broken_rule(e))
                    for e in refusal.errors()
                ]
            ) from None
    return messages


def _invalid_zones(errors: list[FieldFault]) -> Problem:
    listed = "; ".join(f"{fault.field}: {fault.message}" for fault in errors)
    return Problem(422, "invalid-request", listed, errors=errors)


def _kept(facts: MapFacts, in_use: str) -> KeptMap:
    width, height = facts.size_m
    return KeptMap(
        name=facts.name,
        in_use=facts.name == in_use,
        saved=round(facts.saved, 3),
        size_m=(round(width, 3), round(height, 3)),
        resolution_m=facts.resolution_m,
        known_m2=round(facts.known_m2, 2),
        extendable=facts.graph,
        zones=facts.zones,
        problem=facts.problem or None,
    )
