"""The Intention Translator: from the strongest desires to filters Φ' and parameters P' (thesis 4.2.5).

It solves beside the event loop whenever the desires, a capacity or a cost change; the newest desire set wins. An
intention is applied in one step of the loop: parameters first, then filters, opening before closing, and only what
changed.
"""

from __future__ import annotations

import asyncio
import logging
import math
from collections.abc import Awaitable, Callable, Collection, Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

from app.attention.chronicle import note_desires, note_filters, note_intention
from app.attention.desires import GRAIN
from app.attention.intention import Intention, divisors_of, parameters_of
from app.attention.ports import Clock, FilterBank, ParameterSink, Solver
from app.attention.problem import Problem, Reason, Selection, Weights, assess, produced
from app.attention.reasons import explain
from app.attention.solver import CachedSolver, SolverFailed, solve
from app.attention.strategies import MOST, StrategyTable
from app.attention.timeline import Timeline
from app.attention.workspace import IntentionWorkspace, WorkspaceChange

_log = logging.getLogger(__name__)

EXPLAIN_S: Final = 0.05
"""Real seconds that reasons may take."""

_PATIENCE: Final = 3
"""So many results in a row may come too late before one that still holds under the newest desires is applied."""

_RETRY_S: Final = 1.0
_RETRY_MOST_S: Final = 30.0
"""A solver that failed is asked again after so long, then after twice as long, and so on."""


@dataclass(frozen=True, slots=True)
class Hysteresis:
    """When a selection that takes something from a desire may replace one that still holds.

    It must gain more than ``gain`` in Ω, or have been the better one for ``dwell_s`` seconds. 0 leaves out that way;
    both 0: every switch is made at once.
    """

    gain: float = 0.0
    dwell_s: float = 0.0


@dataclass(frozen=True, slots=True)
class TranslatorStatistics:
    """Since the start: ``solved`` problems, of these ``recalled`` from memory; results ``discarded`` because newer
    desires came; solver ``failures``; switches ``held`` back by hysteresis; intentions ``applied``."""

    solved: int
    recalled: int
    discarded: int
    failures: int
    held: int
    applied: int


class IntentionTranslator:
    """Keeps filters and parameters what the desires make them; :meth:`run` does the work.

    ``safe`` names the strategies that hold until the solver's first answer. ``offload`` runs a function
    beside the event loop. Raises ValueError if the table or ``safe`` name what does not exist.
    """

    def __init__(
        self,
        workspace: IntentionWorkspace,
        table: StrategyTable,
        filters: FilterBank,
        parameters: ParameterSink,
        timeline: Timeline,
        clock: Clock,
        *,
        safe: Collection[str] = (),
        solver: Solver | None = None,
        time_limit_s: float = 0.5,
        explain_limit_s: float = EXPLAIN_S,
        weights: Weights | None = None,
        hysteresis: Hysteresis | None = None,
        offload: Callable[..., Awaitable[Any]] = asyncio.to_thread,
    ) -> None:
        self.table = table
        self.controlled = table.filters
        unknown = sorted(self.controlled - set(filters.names()))
        if unknown:
            raise ValueError(f"strategies set filters that do not exist: {', '.join(unknown)}")
        known = {strategy.name for strategy in table.strategies}
        if not known.issuperset(safe):
            raise ValueError(f"safe strategies that do not exist: {', '.join(sorted(set(safe) - known))}")
        self._workspace = workspace
        self._filters = filters
        self._parameters = parameters
        self._timeline = timeline
        self._clock = clock
        self._safe = tuple(safe)
        self._solver: Solver = solver or CachedSolver(time_limit_s=time_limit_s)
        self._explain_limit_s = explain_limit_s
        self._weights = weights or Weights()
        self._hysteresis = hysteresis or Hysteresis()
        self._offload = offload
        self._strategies = table.strategies
        self._capacities = table.capacities()
        self._observers: list[Callable[[Intention], None]] = []
        self._current: Intention | None = None
        self._version = 1
        self._answered = 0
        self._explained = 0
        self._changed = asyncio.Event()
        self._progress = asyncio.Event()
        self._timer = asyncio.Event()
        self._late = 0
        self._hold_until: float | None = None
        self._retry_at: float | None = None
        self._retry_s = _RETRY_S
        self._failing = False
        self._counts = dict.fromkeys(("solved", "recalled", "discarded", "failures", "held", "applied"), 0)
        self._changed.set()
        self._end_watch = workspace.observe(self._workspace_changed)

    # --- For others --------------------------------------------------------------------------------------------------

    @property
    def current(self) -> Intention | None:
        """The intention in force; None until there is one."""
        return self._current

    @property
    def capacities(self) -> Mapping[str, float]:
        """The budgets now."""
        return dict(self._capacities)

    def observe(self, callback: Callable[[Intention], None]) -> Callable[[], None]:
        """Call ``callback`` with every intention applied, and again once its reasons are complete; returns what ends
        it."""
        self._observers.append(callback)

        def end() -> None:
            if callback in self._observers:
                self._observers.remove(callback)

        return end

    def problem(self) -> Problem:
        """The selection problem as it stands now."""
        previous = frozenset(self._current.selection.strategies) if self._current else frozenset()
        desires = self._workspace.strongest()
        return Problem(desires, self._strategies, dict(self._capacities), previous, self._weights)

    def set_capacity(self, resource: str, value: float, reason: str) -> None:
        """Change a budget and solve again. ``reason`` goes to the timeline. Raises ValueError."""
        if resource not in self._capacities:
            raise ValueError(f"no resource {resource!r}; there are: {', '.join(self._capacities)}")
        if not 0 <= value <= MOST:
            raise ValueError(f"the capacity of {resource} must be from 0 to {MOST:,.0f}, not {value!r}")
        before, after = self._capacities[resource], math.floor(value * GRAIN + 1e-6) / GRAIN
        if after == before:
            return
        self._capacities[resource] = after
        text = f"{resource} may now use {after:g} instead of {before:g}: {reason}"
        self._timeline.add("capacity", resource, text, {"before": before, "after": after, "reason": reason})
        self._touch()

    @property
    def is_settled(self) -> bool:
        """Whether the current desires and budgets are answered: applied, held back or failed."""
        return self._answered == self._version

    async def settled(self) -> None:
        """Wait until the current desires and budgets are answered: applied, held back or failed."""
        while self._answered != self._version:
            await self._progress.wait()

    async def explained(self) -> None:
        """Wait until the reasons of the current intention are complete."""
        while self._explained != self._version:
            await self._progress.wait()

    def refresh(self) -> None:
        """Set every controlled filter again to what the current intention says, for modules that lost theirs."""
        if self._current is not None:
            self._filters.apply(dict(self._current.divisors))

    def statistics(self) -> TranslatorStatistics:
        return TranslatorStatistics(**self._counts)

    # --- The work ----------------------------------------------------------------------------------------------------

    async def run(self) -> None:
        """Translate until cancelled. The safe strategies hold until the solver's first answer."""
        if self._current is None and self._safe:
            problem = self.problem()
            safe = assess(problem, self._safe) or Selection(self._safe, (), 0.0, math.inf, {}, False)
            self._apply(problem, safe)
        try:
            async with asyncio.TaskGroup() as group:
                group.create_task(self._keep_time(), name="desires expire")
                group.create_task(self._translate(), name="intention translator")
        finally:
            self._end_watch()

    async def _translate(self) -> None:
        while True:
            await self._changed.wait()
            self._changed.clear()
            version, problem = self._version, self.problem()
            selection = await self._solved(problem)
            if selection is not None and version == self._version:
                selection = await self._held(problem, selection)
            if version != self._version and not self._acceptable(selection):
                self._counts["discarded"] += 1
                continue
            self._late = 0
            if selection is not None:
                self._apply(problem, selection)
            self._tell_progress(answered=version)
            if self._current is not None and version == self._version:
                await self._explain(problem, self._current.selection, version)

    async def _solved(self, problem: Problem) -> Selection | None:
        """The solver's answer; None after a failure, which is reported, leaves the last intention in force, and has
        the solver asked again after a while."""
        self._counts["solved"] += 1
        self._retry_at = None
        try:
            known = self._solver.recall(problem)
            if known is not None:
                self._counts["recalled"] += 1
                return known
            selection: Selection | None = await self._offload(self._solver.solve, problem)
        except Exception as failure:  # noqa: BLE001 - whatever it is, attention goes on with the last intention
            self._failed(f"{type(failure).__name__}: {failure}")
            return None
        if selection is None:
            self._failed("it gave no answer")
            return None
        self._retry_s = _RETRY_S
        if self._failing:
            self._failing = False
            self._timeline.add("solver", "solver", "the solver answers again")
        return selection

    def _failed(self, why: str) -> None:
        self._counts["failures"] += 1
        # A moment to switch that has come would have it asked at every turn of the loop: it comes anew.
        self._hold_until = None
        self._retry_at = self._clock.now() + self._retry_s
        self._retry_s = min(2 * self._retry_s, _RETRY_MOST_S)
        self._timer.set()
        text = f"the solver failed ({why}); the last intention stays"
        if not self._failing:
            _log.error("%s", text)
        self._failing = True
        self._timeline.add("solver", "solver", text, {"error": why})

    def _acceptable(self, selection: Selection | None) -> bool:
        """Whether a late result may be used: only after several were discarded, and if it breaks no newer
        constraint."""
        self._late += 1
        if selection is None or self._late <= _PATIENCE:
            return False
        return assess(self.problem(), selection.strategies, relaxed=selection.relaxed) is not None

    async def _held(self, problem: Problem, best: Selection) -> Selection:
        """``best``, or the selection in force where hysteresis holds it back."""
        limits = self._hysteresis
        current = self._current
        before = current.selection.strategies if current is not None else ()
        if not (limits.gain or limits.dwell_s) or set(best.strategies) == set(before):
            self._hold_until = None
            return best
        # Solved among what is on already, the answer is all of it only if it still holds and nothing of it is useless.
        among = replace(problem, strategies=tuple(s for s in problem.strategies if s.name in before))
        try:
            stay: Selection = await self._offload(solve, among)
        except SolverFailed:
            # Whether what is on still serves is not known in time: nothing to hold on to.
            self._hold_until = None
            return best
        loses = any(produced(problem, best.strategies, cls) < produced(problem, before, cls) for cls in stay.fulfilled)
        if set(stay.strategies) != set(before) or stay.relaxed != best.relaxed or not loses:
            self._hold_until = None
            return best
        now = self._clock.now()
        if self._hold_until is None:
            self._hold_until = now + limits.dwell_s
        gained = limits.gain and best.omega - stay.omega > limits.gain
        lasted = limits.dwell_s and now >= self._hold_until
        if gained or lasted:
            self._hold_until = None
            return best
        self._counts["held"] += 1
        self._timer.set()
        return replace(stay, proven=False, bound=best.bound)

    def _apply(self, problem: Problem, selection: Selection) -> None:
        """Put an intention in force: one step of the loop, nothing in between can run."""
        before = self._current
        chosen = tuple(s for s in problem.strategies if s.name in selection.strategies)
        desires = self._workspace.strongest()
        intention = Intention(
            stamp=self._clock.now(),
            selection=selection,
            strategies=chosen,
            divisors=divisors_of(chosen, self.controlled),
            parameters=parameters_of(chosen, desires),
            reasons=explain(problem, selection, time_limit_s=0.0, resources=self.table.resources),
            desires=problem.desires,
            capacities=problem.capacities,
        )
        self._configure(before.parameters if before is not None else {}, intention.parameters)
        old = before.divisors if before is not None else {}
        changed = {name: phi for name, phi in intention.divisors.items() if old.get(name) != phi}
        if changed:
            self._filters.apply(changed)
        self._current = intention
        self._counts["applied"] += 1
        note_intention(self._timeline, before, intention)
        note_filters(self._timeline, old, changed)
        self._tell(intention)

    def _configure(self, before: Mapping[str, Mapping[str, Any]], after: Mapping[str, Mapping[str, Any]]) -> None:
        for module in sorted({*before, *after}):
            parameters = after.get(module, {})
            if parameters == before.get(module, {}):
                continue
            try:
                self._parameters.configure(module, parameters)
            except Exception as failure:  # noqa: BLE001 - one module's refusal must not stop the others' attention
                text = f"{module} refused its parameters: {type(failure).__name__}: {failure}"
                _log.error("%s", text)
                self._timeline.add("module", module, text, {"parameters": dict(parameters)})

    async def _explain(self, problem: Problem, selection: Selection, version: int) -> None:
        """Complete the reasons beside the loop; newer desires make them pointless."""
        if self._explain_limit_s > 0:
            reasons = await self._reasoned(problem, selection, version)
            if version != self._version or self._current is None:
                return
            if reasons is not None and reasons != self._current.reasons:
                self._current = replace(self._current, reasons=reasons)
                self._tell(self._current)
        self._explained = version
        self._tell_progress()

    async def _reasoned(self, problem: Problem, selection: Selection, version: int) -> dict[str, Reason] | None:
        """The reasons with what would help; None, and told once, if they cannot be found."""
        try:
            reasons: dict[str, Reason] = await self._offload(self._reasons, problem, selection, version)
        except Exception as failure:  # noqa: BLE001 - an intention stands without its reasons
            _log.exception("no reasons for the intention: %s", failure)
            return None
        return reasons

    def _reasons(self, problem: Problem, selection: Selection, version: int) -> dict[str, Reason]:
        return explain(
            problem,
            selection,
            time_limit_s=self._explain_limit_s,
            resources=self.table.resources,
            give_up=lambda: version != self._version,
        )

    async def _keep_time(self) -> None:
        """Let desires expire, look again at a switch held back once it has lasted, ask anew a solver that failed."""
        while True:
            self._timer.clear()
            wakes = [self._workspace.next_expiry, self._retry_at]
            if self._hysteresis.dwell_s:
                wakes.append(self._hold_until)
            due = min((stamp for stamp in wakes if stamp is not None), default=None)
            if due is None:
                await self._timer.wait()
                continue
            sleep = asyncio.create_task(self._clock.sleep_until(due))
            woken = asyncio.create_task(self._timer.wait())
            try:
                await asyncio.wait({sleep, woken}, return_when=asyncio.FIRST_COMPLETED)
            finally:
                sleep.cancel()
                woken.cancel()
            if not self._timer.is_set():
                self._workspace.expire()
                now = self._clock.now()
                if any(stamp is not None and now >= stamp for stamp in (self._hold_until, self._retry_at)):
                    # Its moment has come, and stays in the past until the answer is there: asking again at every turn
                    # of the loop would only make each answer outdated.
                    answered = self._progress
                    self._touch()
                    await answered.wait()

    # --- Inside ------------------------------------------------------------------------------------------------------

    def _touch(self) -> None:
        self._version += 1
        self._changed.set()

    def _tell(self, intention: Intention) -> None:
        for observer in tuple(self._observers):
            try:
                observer(intention)
            except Exception:  # noqa: BLE001 - whatever an observer got wrong
                # Attention must not end with a reader: that one is dropped, loudly.
                self._observers.remove(observer)
                _log.exception("an observer of the intention failed and is no longer told: %r", observer)

    def _tell_progress(self, *, answered: int | None = None) -> None:
        if answered is not None:
            self._answered = answered
        self._progress.set()
        self._progress = asyncio.Event()

    def _workspace_changed(self, change: WorkspaceChange) -> None:
        self._timer.set()
        if note_desires(self._timeline, change):
            self._touch()
