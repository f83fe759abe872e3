"""What attention chose and from what: the intention, strategies, resources, and the timeline."""

from __future__ import annotations

import asyncio
from collections.abc import Collection
from functools import partial
from typing import TYPE_CHECKING, Annotated, Final, get_args

from fastapi import APIRouter, Path, Query, Request
from fastapi.responses import Response

from app.attention.emotions import EMOTIONS
from app.attention.explaining import EXPLAIN_S
from app.attention.prepared import InvalidProblem
from app.attention.reports import intention_report, resource_report, strategy_report
from app.attention.solver import SolverFailed
from app.attention.what_if import Supposition, UnknownNames, intention_if
from app.console import reports
from app.console.problems import Problem
from app.console.records.attention import EventList, ResourceList, StrategyList
from app.console.rest.answers import Json, packed, problems
from app.console.rest.desires import OPERATOR_PARAMETER, source_of
from app.console.rest.models import ResourceChange, WhatIf
from app.console.rest.routing import router as api_router
from app.messages import (
    Asked,
    EmotionLevel,
    EmotionState,
    EventKind,
    IntentionReport,
    ResourceReport,
    RulesReport,
)

if TYPE_CHECKING:
    from app.program.system import System

MOST_EVENTS = 1000
#: Real time (s) that the search for what would be chosen may take.
_WHAT_IF_S: Final = 0.25
KINDS = get_args(EventKind)
_KIND = rf"\s*({'|'.join(KINDS)})?\s*"
#: A list of kinds, separated by commas; an item may be empty.
KINDS_PATTERN = f"^{_KIND}(,{_KIND})*$"


def attention_router(system: System) -> APIRouter:
    """Routes of ``/intention``, ``/strategies``, ``/rules``, ``/emotions``, ``/resources`` and ``/timeline``."""
    router = api_router("attention")

    def resource(name: str) -> ResourceReport:
        translator = system.translator
        known = system.table.resources[name]
        return resource_report(known, translator.capacities[name], translator.budgets[name], translator.current)

    @router.get(
        "/intention",
        response_model=IntentionReport,
        summary="The intention and its reasons",
        responses=problems(409),
    )
    async def get_intention() -> Response:
        """The strategies at work, the filters they set, Ω, what they use of each resource, and for each desired class
        the reason why it gets what it gets."""
        current = reports.latest(system.graph, "intention")
        if current is None:
            raise Problem(409, "no-intention-yet", "Attention has not chosen anything yet; ask again in a moment.")
        return Json(current)

    asking = asyncio.Lock()

    @router.post(
        "/intention/what-if",
        response_model=IntentionReport,
        summary="What would be chosen",
        responses=problems(400, 409, 422),
    )
    async def ask_what_if(supposed: WhatIf) -> Response:
        """The intention under other desires, costs and budgets, with its reasons. The robot goes on as it is. One is
        answered at a time; `stamp` is when it was asked."""
        unknown = [f"desires.{cls}" for cls in supposed.desires if cls not in system.workspace.classes]
        if unknown:
            raise _unknown(unknown)
        supposition = Supposition(
            {
                cls: None if each is None else Asked(each.intensity, each.utility, each.security)
                for cls, each in supposed.desires.items()
            },
            supposed.costs,
            supposed.capacities,
        )
        async with asking:
            translator = system.translator
            work = partial(
                intention_if,
                translator.problem(),
                supposition,
                system.clock.now(),
                controlled=translator.controlled,
                resources=system.table.resources,
                time_limit_s=_WHAT_IF_S,
                explain_limit_s=EXPLAIN_S,
            )
            try:
                intention = await asyncio.to_thread(work)
            except UnknownNames as failure:
                raise _unknown(failure.names) from None
            except (InvalidProblem, SolverFailed) as failure:
                raise Problem(409, "not-solved", f"No answer was found: {failure}.") from None
        return Json(intention_report(intention, system.table.resources))

    @router.get("/strategies", response_model=StrategyList, summary="List all strategies")
    async def list_strategies() -> Response:
        current = system.translator.current
        selected = frozenset(() if current is None else current.selection.strategies)
        now = {s.name: s for s in system.translator.table.strategies}
        reports = (strategy_report(now[s.name], s, selected=s.name in selected) for s in system.table.strategies)
        return Json(StrategyList(tuple(reports)))

    @router.get("/rules", response_model=RulesReport, summary="Rules, and when each applied last")
    async def list_rules() -> Response:
        """The rules by which something is desired without code, in force now. Where a file was changed and has a
        mistake, `problem` says which, and the rules are still those before. No rules: the program has none."""
        return Json(reports.latest(system.graph, "rules") or RulesReport(system.clock.now(), ()))

    @router.get("/emotions", response_model=EmotionState, summary="What the robot feels, and why")
    async def get_emotions() -> Response:
        """Joy, anger, sadness and fear, each with the desire classes that it comes from, and the desires whose
        intensity is raised. A program without emotions feels nothing."""
        nothing = EmotionState(system.clock.now(), tuple(EmotionLevel(e, 0.0, ()) for e in EMOTIONS), modulates=False)
        return Json(reports.latest(system.graph, "emotions") or nothing)

    @router.get("/resources", response_model=ResourceList, summary="Resources: budgets and use")
    async def list_resources() -> Response:
        return Json(ResourceList(tuple(resource(name) for name in system.table.resources)))

    @router.patch(
        "/resources/{name}",
        response_model=ResourceReport,
        summary="Change a budget",
        openapi_extra=OPERATOR_PARAMETER,
        responses=problems(400, 404, 422),
    )
    async def change_resource(
        name: Annotated[str, Path(min_length=1, examples=["cpu"])], change: ResourceChange, request: Request
    ) -> Response:
        """Attention selects again within the new budget at once; it lasts until changed again or the program ends."""
        if name not in system.table.resources:
            known = ", ".join(system.table.resources) or "none"
            raise Problem(404, "no-such-resource", f"No resource is called {name}; there are: {known}.")
        system.translator.set_capacity(name, change.capacity, f"asked for by {source_of(request).name}")
        return Json(resource(name))

    @router.get("/timeline", response_model=EventList, summary="Events of the timeline", responses=problems(422))
    async def get_timeline(
        since: Annotated[
            float | None, Query(allow_inf_nan=False, description="Robot's clock (s); events from then on.")
        ] = None,
        until: Annotated[
            float | None, Query(allow_inf_nan=False, description="Robot's clock (s); events before then.")
        ] = None,
        kinds: Annotated[
            str | None,
            Query(
                description=f"Comma-separated: {', '.join(KINDS)}.",
                examples=["desire,intention"],
                json_schema_extra={"pattern": KINDS_PATTERN},
            ),
        ] = None,
        after_id: Annotated[int, Query(ge=0, description="Only events with a greater id.")] = 0,
        limit: Annotated[int, Query(ge=1, le=MOST_EVENTS, description="At most so many, the newest.")] = 200,
        *,
        request: Request,
    ) -> Response:
        """Oldest first. To follow it, ask again with `after_id` of the last one had."""
        chosen = None if kinds is None else {kind.strip() for kind in kinds.split(",") if kind.strip()}
        if unknown := sorted((chosen or set()) - set(KINDS)):
            message = f"no such kind: {', '.join(unknown)}; there are: {', '.join(KINDS)}"
            raise Problem(422, "invalid-request", f"kinds: {message}", errors=[("query.kinds", message)])
        events = system.timeline.query(since, until, chosen, limit, after_id=after_id)
        return await asyncio.to_thread(lambda: packed(Json(EventList(tuple(events))), request))

    return router


def _unknown(names: Collection[str]) -> Problem:
    errors = [(f"body.{name}", "there is no such thing") for name in names]
    return Problem(422, "invalid-request", f"There is no such thing: {', '.join(names)}.", errors=errors)
