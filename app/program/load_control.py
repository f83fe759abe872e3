"""The closed loop around attention: measures the modules and the computer, and gives attention what follows.

What decides is pure (:mod:`app.attention.closed_loop`, :mod:`app.attention.confidence`). Once or twice a second;
figures of the computer are read, and all is reckoned, in a thread.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Mapping
from functools import partial

from app.attention.calibration import RESOURCE
from app.attention.capacity_governor import Pressure
from app.attention.closed_loop import Adjustment, ClosedLoop, LoopLimits, Window
from app.attention.confidence import Confidences, factors, remarks
from app.attention.cost_estimation import Work
from app.attention.timeline import Timeline
from app.attention.translator import IntentionTranslator
from app.messages import Confidence, LoopReport, StrategyLoad
from app.program.config import ClosedLoopConfig
from app.runtime.clock import Clock
from app.runtime.graph import Graph
from app.runtime.pressure import PressureMeter
from app.runtime.watchdog import LoopWatchdog


class LoadControl:
    """Keeps what attention reckons with close to what is measured; :meth:`run` does the work."""

    def __init__(
        self,
        settings: ClosedLoopConfig,
        graph: Graph,
        translator: IntentionTranslator,
        timeline: Timeline,
        watchdog: LoopWatchdog,
        clock: Clock,
    ) -> None:
        self._settings = settings
        self._graph = graph
        self._translator = translator
        self._timeline = timeline
        self._watchdog = watchdog
        self._clock = clock
        self._loop = ClosedLoop(translator.table.strategies, LoopLimits(settings.most, settings.least_share))
        self._confidences = Confidences(settings.least_confidence)
        self._levels: dict[str, tuple[float, str]] = {}
        self._why = ""
        self._pressure = Pressure()

    async def run(self) -> None:
        """Measure and adjust until cancelled."""
        meter = await asyncio.to_thread(PressureMeter)
        before = self._counts()
        began, at_work = self._clock.now(), self._selected()
        late = self._lateness()
        while True:
            await self._clock.sleep(self._loop.window_s)
            counts, now, selected = self._counts(), self._clock.now(), self._selected()
            late_now = self._lateness()
            pressed = await asyncio.to_thread(meter.sample)
            window = Window(
                now,
                now - began,
                at_work=at_work & selected,
                unsettled=at_work ^ selected,
                work=self._work(before, counts, now - began),
                pressure=Pressure(
                    pressed.waiting,
                    pressed.room,
                    stalled=pressed.stalled,
                    runnable=pressed.runnable,
                    late_s=_mean(late, late_now),
                ),
                budget=self._translator.budgets.get(RESOURCE, math.inf),
            )
            self.apply(await asyncio.to_thread(partial(self._loop.take, window)))
            self._pressure = window.pressure
            self._confidences.expire(now)
            self.trust(self._confidences.levels())
            before, began, at_work, late = counts, now, selected, late_now

    def hear(self, module: str, message: Confidence) -> None:
        """A perception says how well it works."""
        if self._settings.confidence:
            self._confidences.take(module, self._clock.now(), message.value, message.reason)
            self.trust(self._confidences.levels())

    def reset(self) -> None:
        """Time has jumped: what perceptions said was of another time."""
        self._confidences.clear()
        self.trust(self._confidences.levels())

    def report(self) -> LoopReport:
        """What was measured last, and what attention makes of it."""
        costs, selected = self._loop.costs(), self._selected()
        pressure = self._pressure
        return LoopReport(
            budget=self._translator.budgets.get(RESOURCE, 0.0),
            share=self._loop.share if self._settings.pressure else 1.0,
            used=round(self._loop.measured_cpu, 2),
            waiting=round(pressure.waiting, 3),
            room=round(pressure.room, 1),
            stalled=round(pressure.stalled, 3),
            runnable=round(pressure.runnable, 2),
            late_ms=round(1e3 * pressure.late_s, 2),
            strategies=tuple(
                StrategyLoad(
                    s.name,
                    s.cls,
                    declared=known.declared,
                    measured=None if known.measured is None else round(known.measured, 2),
                    estimated=round(known.estimated, 2),
                    used=s.costs.get(RESOURCE, 0.0),
                )
                for s in self._translator.table.strategies
                if s.name in selected and (known := costs.get(s.name)) is not None
            ),
            why=self._why,
        )

    def apply(self, adjustment: Adjustment) -> None:
        """Put in force what follows from a window, as far as the settings let it."""
        translator, said = self._translator, adjustment.why
        if adjustment.costs and self._settings.costs:
            table = {s.name: s for s in translator.table.strategies}
            costs = {name: {**table[name].costs, RESOURCE: cost} for name, cost in adjustment.costs.items()}
            translator.set_costs(costs, said or "strategies that are not at work were measured before")
            if not self._selected().isdisjoint(costs):
                self._why = said
                text = f"CPU is reckoned otherwise: {said}"
                self._timeline.add("capacity", RESOURCE, text, {"costs": adjustment.costs})
        if adjustment.share is not None and self._settings.pressure and RESOURCE in translator.budgets:
            self._why = said
            translator.set_share(RESOURCE, adjustment.share, said)

    def trust(self, levels: Mapping[str, tuple[float, str]]) -> None:
        """Let strategies produce as much as the ``levels`` of perceptions leave them, with the reasons."""
        if levels == self._levels:
            return
        strategies = self._translator.table.strategies
        for name in sorted(levels.keys() | self._levels.keys()):
            level, reason = levels.get(name, (1.0, "it works as ever"))
            if self._levels.get(name, (1.0, ""))[0] != level:
                text = f"{name} counts for {100 * level:.0f} % of its utility: {reason}"
                self._timeline.add("capacity", name, text, {"confidence": level, "reason": reason})
        self._levels = dict(levels)
        self._translator.set_utilities(factors(strategies, levels), remarks(strategies, levels))

    def _selected(self) -> frozenset[str]:
        current = self._translator.current
        return frozenset() if current is None else frozenset(current.selection.strategies)

    def _counts(self) -> tuple[dict[str, int], dict[str, int]]:
        """CPU (ns) by module, and messages taken by filter of an input."""
        cpu = {name: slot.context.meter.cpu_ns for name, slot in self._graph.modules.items()}
        taken = {}
        for name in self._translator.controlled:
            module, _, port = name.partition(".")
            entry = self._graph.modules[module].context.inputs.get(port)
            if entry is not None and entry.connected:
                taken[name] = entry.subscription.taken
        return cpu, taken

    def _work(
        self, before: tuple[dict[str, int], dict[str, int]], now: tuple[dict[str, int], dict[str, int]], seconds: float
    ) -> Work:
        cpu = {name: 1e-7 * (ns - before[0].get(name, 0)) / seconds for name, ns in now[0].items()}
        taken = {}
        for name, count in now[1].items():
            rate_hz = self._rate_hz(name)
            if rate_hz is not None:
                taken[name] = (count - before[1].get(name, 0)) / (rate_hz * seconds)
        return Work(cpu, taken)

    def _rate_hz(self, name: str) -> float | None:
        module, _, port = name.partition(".")
        channel = self._graph.modules[module].context.inputs[port].channel
        return None if channel is None else self._graph.specs[channel.name].rate_hz

    def _lateness(self) -> tuple[int, float]:
        statistics = self._watchdog.statistics()
        return statistics.beats, statistics.total_lateness_s


def _mean(before: tuple[int, float], now: tuple[int, float]) -> float:
    beats = now[0] - before[0]
    return (now[1] - before[1]) / beats if beats > 0 else math.nan
