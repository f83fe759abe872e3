"""The lanes: per desire class, how much it is desired and how many of its messages attention lets through."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable, Mapping

from app.attention.desires import Desire
from app.attention.strategies import CLOSED, Strategy
from app.attention.translator import IntentionTranslator
from app.attention.workspace import IntentionWorkspace
from app.messages import LaneRow, Lanes, LaneState, Reason
from app.runtime.channel import Channel
from app.runtime.clock import Clock
from app.runtime.graph import Graph

#: Relative rates are measured over this long.
WINDOW_S = 1.0
#: Between two samples while the channel is wanted, and while it is not: a page that comes later shows the past, too.
PERIOD_S = 0.1
UNWANTED_PERIOD_S = 0.5


class RatioWindow:
    """Messages let through over messages offered, in the last second, from two counters that only grow."""

    def __init__(self) -> None:
        self._samples: deque[tuple[float, int, int]] = deque()

    def add(self, now: float, offered: int, passed: int) -> None:
        """Note both counters at ``now`` (seconds)."""
        if self._samples and self._samples[-1][0] >= now:
            # Paused time: the same stamp again.
            self._samples.pop()
        self._samples.append((now, offered, passed))
        # The oldest kept sample is the last one at or before the window's begin.
        while len(self._samples) > 2 and self._samples[1][0] <= now - WINDOW_S:
            self._samples.popleft()

    def ratio(self) -> float | None:
        """In [0, 1]; None when nothing was offered."""
        if len(self._samples) < 2:
            return None
        (_, offered_before, passed_before), (_, offered, passed) = self._samples[0], self._samples[-1]
        if offered <= offered_before:
            return None
        return min(1.0, (passed - passed_before) / (offered - offered_before))


def filter_counts(graph: Graph, name: str) -> tuple[int, int]:
    """Messages offered to and passed by the filter ``Module.port`` so far, with those that their source left out."""
    module, _, port = name.partition(".")
    context = graph.modules[module].context
    if port in context.inputs:
        statistics = context.inputs[port].subscription.statistics()
        return statistics.received, statistics.passed
    output = context.outputs[port]
    return output.offered, 0 if output.channel is None else output.channel.periods


class LaneSampler:
    """Builds the rows of the ``lanes`` message; :meth:`sample` is called 10 times a second."""

    def __init__(self, graph: Graph, classes: Iterable[str], strategies: Iterable[Strategy]) -> None:
        self._graph = graph
        self._classes = tuple(classes)
        #: Filters by class, over all its strategies, and by strategy.
        self._filters: dict[str, tuple[str, ...]] = dict.fromkeys(self._classes, ())
        self._of_strategy: dict[str, tuple[str, ...]] = {}
        #: Filters that a strategy closes on purpose: another behavior's output, a stream it does without. The first
        #: filter that it does not close is its main input.
        self._closes: dict[str, frozenset[str]] = {}
        self._class_of: dict[str, str] = {}
        for strategy in strategies:
            names = tuple(name for name in strategy.filters if name in graph.filters.names())
            self._of_strategy[strategy.name] = names
            self._closes[strategy.name] = frozenset(name for name in names if strategy.filters[name] == CLOSED)
            self._class_of[strategy.name] = strategy.cls
            if strategy.cls in self._filters:
                self._filters[strategy.cls] = tuple(dict.fromkeys(self._filters[strategy.cls] + names))
        every = {name for names in self._filters.values() for name in names}
        self._windows = {name: RatioWindow() for name in sorted(every)}

    def reset(self) -> None:
        """Measure from now on."""
        self._windows = {name: RatioWindow() for name in self._windows}

    def sample(
        self,
        now: float,
        strongest: Mapping[str, Desire],
        selected: Iterable[str],
        reasons: Mapping[str, Reason],
    ) -> Lanes:
        """The lanes at ``now``. ``selected`` are the strategies at work, ``reasons`` say why, by desired class."""
        for name, window in self._windows.items():
            window.add(now, *filter_counts(self._graph, name))
        ratios = {name: window.ratio() for name, window in self._windows.items()}
        return Lanes(now, self.rows(strongest, selected, reasons, self._graph.filters.divisors(), ratios))

    def rows(
        self,
        strongest: Mapping[str, Desire],
        selected: Iterable[str],
        reasons: Mapping[str, Reason],
        divisors: Mapping[str, float],
        ratios: Mapping[str, float | None],
    ) -> tuple[LaneRow, ...]:
        """The rows for φ by filter, and what each filter let through of what was offered (None: nothing was)."""
        at_work: dict[str, list[str]] = {}
        for strategy in selected:
            if strategy in self._class_of:
                at_work.setdefault(self._class_of[strategy], []).append(strategy)
        rows = []
        for cls in self._classes:
            names, divisor, rate, each = self._passing(cls, at_work.get(cls, []), divisors, ratios)
            desire = strongest.get(cls)
            state, text = _state(desire, at_work.get(cls, []), reasons.get(cls))
            rows.append(
                LaneRow(
                    cls=cls,
                    intensity=None if desire is None else desire.intensity,
                    utility=None if desire is None else desire.utility,
                    rate=None if rate is None else round(rate, 4),
                    divisor=divisor if names else CLOSED,
                    divisors=each,
                    state=state,
                    text=text,
                )
            )
        return tuple(rows)

    def _passing(
        self, cls: str, strategies: list[str], divisors: Mapping[str, float], passing: Mapping[str, float | None]
    ) -> tuple[tuple[str, ...], float, float | None, dict[str, float]]:
        """The filters that ``cls`` is shown by, the largest φ of them, what they let through, and φ of every filter of
        its ``strategies`` at work."""
        # A filter closed on purpose holds nothing up.
        served = [[name for name in self._of_strategy[s] if name not in self._closes[s]] for s in strategies]
        names = tuple(dict.fromkeys(names[0] for names in served if names)) or self._filters[cls]
        divisor = max((divisors[name] for name in names), default=1.0)
        if any(divisors[name] == math.inf for names in served for name in names):
            divisor = math.inf  # what comes in does not get out
        ratios = [ratio for name in names if (ratio := passing[name]) is not None]
        rate = 0.0 if divisor == math.inf else min(ratios, default=None)
        return names, divisor, rate, {name: divisors[name] for names in served for name in names}


def _state(desire: Desire | None, strategies: list[str], reason: Reason | None) -> tuple[LaneState, str]:
    if desire is None:
        if strategies:
            return "needed", f"No desire for it, but another strategy needs it: {', '.join(strategies)}."
        return "undesired", "No desire for it."
    if reason is None:
        return "unfulfilled", "Waiting for the next intention."
    return reason.state, reason.text


class LaneMonitor:
    """Publishes the lanes on ``channel`` until :meth:`run` is cancelled: 10 times a second of ``pace`` while that is
    wanted, twice a second while it is not. ``now`` is the robot's clock."""

    def __init__(
        self,
        channel: Channel[Lanes],
        sampler: LaneSampler,
        workspace: IntentionWorkspace,
        translator: IntentionTranslator,
        *,
        now: Callable[[], float],
        pace: Clock,
    ) -> None:
        self._channel = channel
        self._sampler = sampler
        self._workspace = workspace
        self._translator = translator
        self._now = now
        self._pace = pace

    async def run(self) -> None:
        """Sample. Beats missed are skipped, never made up for."""
        due = self._pace.now()
        while True:
            self._channel.publish(self._sample())
            period_s = PERIOD_S if self._channel.wanted else UNWANTED_PERIOD_S
            due = max(due + period_s, self._pace.now())
            await self._pace.sleep_until(due)

    def reset(self) -> None:
        """Time has jumped."""
        self._sampler.reset()

    def _sample(self) -> Lanes:
        current = self._translator.current
        return self._sampler.sample(
            self._now(),
            self._workspace.strongest(),
            () if current is None else [strategy.name for strategy in current.strategies],
            {} if current is None else current.reasons,
        )
