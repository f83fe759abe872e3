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

from app.attention.budgets import Budgets
from app.attention.cached_solver import CachedSolver
from app.attention.enforcement import enforce
from app.attention.explaining import EXPLAIN_S, Explainer
from app.attention.hysteresis import HysteresisState, SelectionHysteresis
from app.attention.intention import Intention, divisors_of, parameters_of
from app.attention.interfaces import FilterTarget, ParameterSink, Solver
from app.attention.prepared import prepare
from app.attention.problem import Selection, SelectionProblem, Weights, assess
from app.attention.retry import Retry
from app.attention.solver import SolverFailed
from app.attention.strategies import StrategyTable
from app.attention.timeline import Timeline
from app.attention.timeline_writer import note_desires, note_filters, note_intention
from app.attention.workspace import IntentionWorkspace, WorkspaceChange
from app.base.observers import Observers
from app.messages import Reason
from app.runtime.clock import Clock

_log = logging.getLogger(__name__)

_PATIENCE: Final = 3
"""Number of results in a row that may come too late before one that still holds under the newest desires is applied."""


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
        filters: FilterTarget,
        parameters: ParameterSink,
        timeline: Timeline,
        clock: Clock,
        *,
        safe: Collection[str] = (),
        solver: Solver | None = None,
        time_limit_s: float = 0.5,
        explain_limit_s: float = EXPLAIN_S,
        weights: Weights | None = None,
        hysteresis: SelectionHysteresis | None = None,
        offload: Callable[..., Awaitable[Any]] = asyncio.to_thread,
    ) -> None:
        self.table = self._declared = table
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
        self._explainer = Explainer(table.resources, explain_limit_s, offload)
        self._weights = weights or Weights()
        self._hold = HysteresisState(hysteresis or SelectionHysteresis())
        self._retry = Retry(timeline)
        self._offload = offload
        self._prepared = prepare(table.strategies)
        self._budgets = Budgets(table.capacities(), timeline)
        #: By class, what is to be said with its reason.
        self._remarks: dict[str, str] = {}
        self._observers: Observers[[Intention]] = Observers("the intention")
        self._current: Intention | None = None
        self._version = 1
        self._answered = 0
        self._explained = 0
        self._changed = asyncio.Event()
        self._progress = asyncio.Event()
        self._timer = asyncio.Event()
        self._late = 0
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
        """What attention may give now: the budgets, less what pressure on the computer takes of them."""
        return self._budgets.left()

    @property
    def budgets(self) -> Mapping[str, float]:
        """The budgets as they were set last."""
        return self._budgets.whole()

    def observe(self, callback: Callable[[Intention], None]) -> Callable[[], None]:
        """Call ``callback`` with every intention applied, and again once its reasons are complete; returns a function
        that ends this."""
        return self._observers.add(callback)

    def problem(self) -> SelectionProblem:
        """The current selection problem."""
        previous = frozenset(self._current.selection.strategies) if self._current else frozenset()
        desires = self._workspace.strongest()
        return SelectionProblem(
            desires,
            self.table.strategies,
            self.capacities,
            previous,
            self._weights,
            prepared=self._prepared,
        )

    def set_capacity(self, resource: str, value: float, reason: str) -> None:
        """Change a budget and solve again. ``reason`` goes to the timeline. Raises ValueError."""
        if self._budgets.set(resource, value, reason):
            self._touch()

    def set_share(self, resource: str, share: float, reason: str) -> None:
        """Leave attention ``share`` (0 to 1) of a budget, which stays set, and solve again. ``reason`` goes to the
        timeline. Raises ValueError."""
        if self._budgets.share(resource, share, reason):
            self._touch()

    def set_costs(self, costs: Mapping[str, Mapping[str, float]], reason: str) -> None:
        """Change what strategies cost, by name and resource, and solve again. Raises ValueError for a strategy or a
        resource that there is not."""
        self._take_table(self.table.with_costs(costs))
        _log.info("other costs of %d strategies: %s", len(costs), reason)

    def set_utilities(self, factors: Mapping[str, float], remarks: Mapping[str, str]) -> None:
        """Let strategies, by name, produce so much (over 0, at most 1) of their declared utility, all others all of it,
        and solve again. ``remarks`` by class go with its reason. Raises ValueError for a strategy that there is not, or
        another factor."""
        self._take_table(self.table.with_utilities({s.name: s.utility for s in self._declared.strategies}, factors))
        self._remarks = dict(remarks)

    def _take_table(self, table: StrategyTable) -> None:
        # What cannot be reckoned with changes nothing.
        self._prepared = prepare(table.strategies)
        self.table = table
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
        """Set every controlled filter again to the current intention's φ, for modules whose filters were reset."""
        if self._current is not None:
            self._filters.apply(dict(self._current.divisors))

    def statistics(self) -> TranslatorStatistics:
        return TranslatorStatistics(**self._counts)

    # --- The work ----------------------------------------------------------------------------------------------------

    async def run(self) -> None:
        """Translate until cancelled. The safe strategies hold until the solver's first answer."""
        if self._current is None and self._safe:
            problem = self.problem()
            safe = assess(problem, self._safe) or Selection(
                self._safe, (), omega=0.0, bound=math.inf, use={}, proven=False
            )
            self._apply(problem, safe)
        try:
            async with asyncio.TaskGroup() as group:
                group.create_task(self._prepare_solver(), name="prepare the solver")
                group.create_task(self._keep_time(), name="desires expire")
                group.create_task(self._translate(), name="intention translator")
        finally:
            self._end_watch()

    async def _translate(self) -> None:
        while True:
            await self._changed.wait()
            self._changed.clear()
            version, problem = self._version, self.problem()
            selection = await self._answered_by_solver(problem, version)
            if version != self._version and not self._acceptable(selection):
                self._counts["discarded"] += 1
                continue
            self._late = 0
            if selection is not None:
                self._apply(problem, selection)
            self._note_progress(answered=version)
            if self._current is not None and version == self._version:
                await self._explain(problem, self._current.selection, version)

    async def _prepare_solver(self) -> None:
        try:
            await self._offload(self._solver.prepare, self.problem())
        except ImportError as failure:
            # Most problems need none of it; one that does fails for itself, and that is reported then.
            _log.warning("part of the solver cannot be loaded: %s", failure)

    async def _answered_by_solver(self, problem: SelectionProblem, version: int) -> Selection | None:
        """The new selection; None after a failure: the last intention stays in force, and the solver is called again
        after a while."""
        self._counts["solved"] += 1
        self._retry.begin()
        try:
            selection = await self._solved(problem)
            if selection is None:
                raise SolverFailed("it gave no answer")
            if version == self._version:
                selection = await self._held(problem, selection)
        except Exception as failure:  # noqa: BLE001 - the solver is handed in, with native code below: what
            # it raises is noted on the timeline and in the log, and it is asked again; the robot goes on meanwhile.
            self._failed(f"{type(failure).__name__}: {failure}")
            return None
        self._retry.succeeded()
        return selection

    async def _solved(self, problem: SelectionProblem) -> Selection | None:
        known = self._solver.recall(problem)
        if known is not None:
            self._counts["recalled"] += 1
            return known
        selection: Selection | None = await self._offload(self._solver.solve, problem)
        return selection

    def _failed(self, why: str) -> None:
        self._counts["failures"] += 1
        # A switch that is due would make the loop call it at every turn; it becomes due again later.
        self._hold.release()
        self._retry.failed(why, self._clock.now())
        self._timer.set()

    def _acceptable(self, selection: Selection | None) -> bool:
        """Whether a late result may be used: only after several were discarded, and if it breaks no newer
        constraint."""
        self._late += 1
        if selection is None or self._late <= _PATIENCE:
            return False
        return assess(self.problem(), selection.strategies, relaxed=selection.relaxed) is not None

    async def _held(self, problem: SelectionProblem, best: Selection) -> Selection:
        """``best``, or the selection in force where hysteresis holds it back."""
        before = self._current.selection.strategies if self._current is not None else ()
        if not self._hold.concerns(best, before):
            self._hold.release()
            return best
        try:
            stay: Selection = await self._offload(self._solver.among, problem, before)
        except SolverFailed:
            # Only this: whether what is on still serves is not known in time, so there is nothing to hold on to, and
            # ``best`` is a good answer. Any other failure is the solver's, as it would be of ``best``.
            self._hold.release()
            return best
        if not self._hold.holds(problem, best, stay, before, self._clock.now()):
            return best
        self._counts["held"] += 1
        self._timer.set()
        return replace(stay, proven=False, bound=best.bound)

    def _apply(self, problem: SelectionProblem, selection: Selection) -> None:
        """Put an intention in force: one step of the loop, nothing in between can run."""
        before = self._current
        names = frozenset(selection.strategies)
        chosen = tuple(s for s in problem.strategies if s.name in names)
        desires = self._workspace.strongest()
        intention = Intention(
            stamp=self._clock.now(),
            selection=selection,
            strategies=chosen,
            divisors=divisors_of(chosen, self.controlled),
            parameters=parameters_of(chosen, desires),
            reasons=self._remarked(selection.reasons),
            desires=problem.desires,
            capacities=problem.capacities,
            previous=problem.previous,
            weights=problem.weights,
            changed=self._declared.changed(problem.strategies),
        )
        changed = enforce(
            before, intention, filters=self._filters, parameters=self._parameters, timeline=self._timeline
        )
        self._current = intention
        self._counts["applied"] += 1
        note_intention(self._timeline, before, intention)
        note_filters(self._timeline, {} if before is None else before.divisors, changed)
        self._observers.notify(intention)

    def _remarked(self, reasons: Mapping[str, Reason]) -> dict[str, Reason]:
        return {cls: replace(reason, remark=self._remarks.get(cls, "")) for cls, reason in reasons.items()}

    async def _explain(self, problem: SelectionProblem, selection: Selection, version: int) -> None:
        """Complete the reasons beside the loop; newer desires make them pointless."""
        reasons = await self._explainer.reasons(problem, selection, lambda: version != self._version)
        if version != self._version or self._current is None:
            return
        reasons = None if reasons is None else self._remarked(reasons)
        if reasons is not None and reasons != self._current.reasons:
            self._current = replace(self._current, reasons=reasons)
            self._observers.notify(self._current)
        self._explained = version
        self._note_progress()

    async def _keep_time(self) -> None:
        """Remove expired desires, reconsider a switch that hysteresis held back, and call a solver that failed
        again."""
        while True:
            self._timer.clear()
            wakes = [self._workspace.next_expiry, self._retry.at]
            if self._hold.limits.dwell_s:
                wakes.append(self._hold.until)
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
                if any(stamp is not None and now >= stamp for stamp in (self._hold.until, self._retry.at)):
                    # Its moment has come, and stays in the past until the answer is there: asking again at every turn
                    # of the loop would only make each answer outdated.
                    answered = self._progress
                    self._touch()
                    await answered.wait()

    # --- Inside ------------------------------------------------------------------------------------------------------

    def _touch(self) -> None:
        self._version += 1
        self._changed.set()

    def _note_progress(self, *, answered: int | None = None) -> None:
        if answered is not None:
            self._answered = answered
        self._progress.set()
        self._progress = asyncio.Event()

    def _workspace_changed(self, change: WorkspaceChange) -> None:
        self._timer.set()
        if note_desires(self._timeline, change):
            self._touch()
