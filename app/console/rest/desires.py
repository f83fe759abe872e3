"""Desires and their classes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from fastapi import APIRouter, Header, Path, Query, Request
from fastapi.responses import Response

from app.attention.desires import SCALE, Desire, Source
from app.attention.reports import desire_class_report, desires_report
from app.attention.workspace import KEEP
from app.console.access.operators import operator_name
from app.console.drive.place_goals import with_place
from app.console.problems import Problem
from app.console.records.attention import DesireClassList
from app.console.rest.answers import Json, problems
from app.console.rest.idempotency import KEY_LIMITS, IdempotencyStore
from app.console.rest.models import DesireChange, NewDesire
from app.console.rest.outcome_waits import LONGEST_WAIT_S, OutcomeWaits
from app.console.rest.routing import router as api_router
from app.messages import DesireClassReport, DesireReport, Desires, Scale

if TYPE_CHECKING:
    from app.program.system import System

DesireId = Annotated[str, Path(min_length=1, description="Id of the desire.", examples=["d-3f0c81a2b4"])]

#: Of people and programs together. The robot's own motivations are not counted, nor kept from theirs.
MOST_DESIRES = 1000
OPERATOR_HEADER = "X-HBBA-Operator"
#: The header of operations on behalf of an operator, for the OpenAPI description.
OPERATOR_PARAMETER = {
    "parameters": [
        {
            "name": OPERATOR_HEADER,
            "in": "header",
            "schema": {"type": "string"},
            "description": "The operator's name, percent-encoded, of at most 40 characters; left out: "
            "a program does it.",
        }
    ]
}

#: The operations on a desire that was created, for the OpenAPI description.
DESIRE_LINKS = {
    operation: {"operationId": operation, "parameters": {"desire_id": "$response.body#/id"}}
    for operation in ("get_desire", "change_desire", "remove_desire")
}


def source_of(request: Request) -> Source:
    """Who asks: the operator that the page names, or a REST client."""
    name = request.headers.get(OPERATOR_HEADER)
    return Source("rest", "rest") if name is None else Source("operator", operator_name(name))


def refuse_too_many(system: System) -> None:
    """Raises Problem while there are as many desires from the console as are allowed."""
    asked = sum(desire.source.kind in ("operator", "rest") for desire in system.workspace.desires())
    if asked >= MOST_DESIRES:
        raise Problem(
            409,
            "too-many-desires",
            f"there are {asked} desires from the console; at most {MOST_DESIRES} are allowed. Remove some, or give "
            "them a ttl.",
        )


def desires_router(system: System) -> APIRouter:
    """Routes of ``/desires`` and ``/desire-classes``."""
    router = api_router("desires")
    workspace = system.workspace
    store = IdempotencyStore(system.pace.now)
    waits = OutcomeWaits(workspace)

    @router.get("/desires", response_model=Desires, summary="List all desires")
    async def list_desires() -> Response:
        """With what has become of each so far: intended, exploited, and since when (`progress`)."""
        exploitation = system.exploitation
        return Json(desires_report(workspace, system.clock.now(), exploitation.exploited(), exploitation.progress()))

    @router.post(
        "/desires",
        response_model=Desire,
        status_code=201,
        summary="Create a desire",
        openapi_extra=OPERATOR_PARAMETER,
        responses={
            201: {
                "headers": {
                    "Location": {"schema": {"type": "string"}, "description": "Where the desire is."},
                    "Idempotency-Replayed": {
                        "schema": {"type": "string"},
                        "description": "`true` where the answer to an earlier request is repeated.",
                    },
                },
                "links": DESIRE_LINKS,
            },
            **problems(400, 409, 422),
        },
    )
    async def create_desire(
        new: NewDesire,
        request: Request,
        idempotency_key: Annotated[
            str | None,
            Header(
                description="Any string of your own; a repeated request with the same key creates nothing new.",
                json_schema_extra=KEY_LIMITS,
            ),
        ] = None,
    ) -> Response:
        """Attention weighs it at once: the intention that follows is on the live stream and in `GET /intention`.

        A desire with a `ttl` expires by itself, so that a client that dies leaves nothing behind. Refused while there
        are 1000 desires from the console. `params` of GoTo may be a `place` of the map, by its id, instead of
        coordinates.
        """
        body = new.model_dump(by_alias=True)
        if known := store.find(idempotency_key, body):
            headers = {"Location": known.location, "Idempotency-Replayed": "true"}
            return Json(known.body, status_code=201, headers=headers)
        refuse_too_many(system)
        desire = workspace.add(
            new.cls,
            intensity=new.intensity,
            utility=new.utility,
            security=new.security,
            params=with_place(system, new.cls, new.params),
            source=source_of(request),
            ttl=new.ttl,
        )
        location = f"/api/v1/desires/{desire.id}"
        store.remember(idempotency_key, body, location, desire)
        return Json(desire, status_code=201, headers={"Location": location})

    @router.get(
        "/desires/{desire_id}",
        response_model=DesireReport,
        summary="One desire, and what became of it",
        responses=problems(404, 422),
    )
    async def get_desire(
        desire_id: DesireId,
        request: Request,
        wait: Annotated[
            float,
            Query(
                ge=0,
                le=LONGEST_WAIT_S,
                allow_inf_nan=False,
                description="Seconds to wait for its outcome; the answer comes as soon as there is one.",
                examples=[30],
            ),
        ] = 0,
    ) -> Response:
        """A desire that left is kept for ten minutes, of the last 2000. Where more than 24 requests wait, the one that
        has waited longest is answered at once."""
        return Json(await waits.report(desire_id, wait, request))

    @router.patch(
        "/desires/{desire_id}",
        response_model=Desire,
        summary="Change a desire in place",
        responses=problems(400, 404, 409, 422),
    )
    async def change_desire(desire_id: DesireId, change: DesireChange) -> Response:
        """Members left out stay. `params` replaces all parameters, and may name a `place` as for a new desire; `ttl`
        counts from now, null makes it stay."""
        given = change.model_fields_set
        for field in ("intensity", "utility", "security", "params"):
            if field in given and getattr(change, field) is None:
                raise Problem(
                    422,
                    "invalid-request",
                    f"{field} cannot be null; leave it out to keep it.",
                    errors=[(field, "cannot be null; leave it out to keep it")],
                )
        desire = workspace.change(
            desire_id,
            intensity=KEEP if change.intensity is None else change.intensity,
            utility=KEEP if change.utility is None else change.utility,
            security=KEEP if change.security is None else change.security,
            params=KEEP if change.params is None else with_place(system, workspace.get(desire_id).cls, change.params),
            ttl=change.ttl if "ttl" in given else KEEP,
        )
        return Json(desire)

    @router.delete("/desires/{desire_id}", status_code=204, summary="Remove a desire", responses=problems(404))
    async def remove_desire(desire_id: DesireId) -> Response:
        workspace.remove(desire_id)
        return Response(status_code=204)

    @router.get("/desire-classes", response_model=DesireClassList, summary="List all desire classes")
    async def list_desire_classes() -> Response:
        """Each class with the JSON Schema of its parameters: enough to build a form from."""
        classes = tuple(desire_class_report(each, system.table) for each in system.classes.values())
        return Json(DesireClassList(classes, Scale(SCALE, SCALE)))

    @router.get(
        "/desire-classes/{name}", response_model=DesireClassReport, summary="One desire class", responses=problems(404)
    )
    async def get_desire_class(name: Annotated[str, Path(min_length=1, examples=["FindQRCodes"])]) -> Response:
        if name not in system.classes:
            known = ", ".join(system.classes)
            raise Problem(404, "no-such-desire-class", f"No desire class is called {name}; there are: {known}.")
        return Json(desire_class_report(system.classes[name], system.table))

    return router
