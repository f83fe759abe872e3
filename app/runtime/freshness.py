"""Freshness of channels: whether the newest message is recent enough for the rate that attention commands.

Judged against the nominal rate, every switch of attention would raise a false alarm; a channel without an open
subscription is closed, not stale. The measured rate is reported beside the commanded one (as openpilot's ``freq_ok``).
"""

from __future__ import annotations

import logging
import math
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

from app.base.observers import Observers
from app.runtime.channel_table import ChannelSpec
from app.runtime.digraph import Feed, slowdowns
from app.runtime.filter import CLOSED
from app.runtime.graph import Graph
from app.runtime.supervisor import ModuleState

log = logging.getLogger("hbba.freshness")

#: ``live``: recent enough; ``waiting``: just started or opened, the first message is not due yet; ``stale``: too old,
#: or the producing module does not run; ``closed``: no subscription is open.
FreshnessState = Literal["live", "waiting", "stale", "closed"]

#: Seconds allowed for the first message after a channel was opened or its module first started: a camera's driver, or a
#: process behind the body, takes that long to start.
GRACE_S = 5.0
#: A channel that is stale for less (s) is not worth a line in the log: a computer is busy for a moment.
HICCUP_S = 0.9
RATE_WINDOW_S = 2.0
RATE_SAMPLES = 20


@dataclass(frozen=True, slots=True)
class Freshness:
    """State of one channel: ``age_s`` of its newest message (None before the first) and the age allowed.

    ``limit_s`` is None for a channel of events and for a closed one; ``commanded_hz`` is None for events, 0 when
    closed; ``rate_hz`` is what was measured over the last two seconds, None until there are two samples.
    """

    state: FreshnessState
    age_s: float | None
    limit_s: float | None
    commanded_hz: float | None
    rate_hz: float | None = None


def judge(
    spec: ChannelSpec,
    divisor: float,
    last_stamp: float | None,
    producer: ModuleState | None,
    now: float,
    since: float = -math.inf,
    opened: float = -math.inf,
) -> Freshness:
    """The state of a channel: a pure function.

    ``divisor`` is φ between the source's nominal rate and the channel, ``CLOSED`` without an open subscription;
    ``producer`` is the state of the module that publishes it, None for a channel fed from outside; ``since`` is the
    time from which this divisor holds: the next message is due one allowed age later, however old the last one is.
    ``opened`` is the time when the channel was last opened, or its module first ran: the first message after that may
    take :data:`GRACE_S`.
    """
    age_s = None if last_stamp is None else now - last_stamp
    if divisor == CLOSED:
        return Freshness("closed", age_s, None, None if spec.rate_hz is None else 0.0)
    limit_s = spec.stale_after_s(divisor)
    commanded_hz = None if spec.rate_hz is None else spec.rate_hz / divisor
    state: FreshnessState
    if producer is not None and producer.stale and (producer.status != "starting" or producer.restarts > 0):
        state = "stale"
    elif limit_s is None:
        state = "waiting" if age_s is None else "live"
    elif age_s is not None and age_s <= limit_s:
        state = "live"
    else:
        nothing_since = last_stamp is None or last_stamp < opened
        waiting = now - since <= limit_s or (nothing_since and now - opened <= GRACE_S)
        state = "waiting" if waiting else "stale"
    return Freshness(state, age_s, limit_s, commanded_hz)


def sources(graph: Graph) -> frozenset[str]:
    """The channels with a source: a module of the program produces them, or they are fed from outside.

    The other channels have subscriptions, but this program has no producer for them: silence there is no fault.
    """
    return frozenset(name for name, spec in graph.specs.items() if name in graph.producers or spec.external)


class RateMeter:
    """Messages per second over the last ``window_s``, from the counter at each look; keeps a bounded few of them."""

    def __init__(self, window_s: float = RATE_WINDOW_S, samples: int = RATE_SAMPLES) -> None:
        self._window_s = window_s
        self._spacing_s = window_s / samples
        self._samples: deque[tuple[float, int]] = deque()

    def sample(self, now: float, published: int) -> float | None:
        """Note that ``published`` messages have gone out by ``now``; the rate since the window began, or None."""
        samples = self._samples
        if not samples or now - samples[-1][0] >= self._spacing_s:
            samples.append((now, published))
        while len(samples) > 1 and samples[1][0] <= now - self._window_s:
            samples.popleft()
        then, before = samples[0]
        return (published - before) / (now - then) if now > then else None


def commanded_divisors(graph: Graph) -> dict[str, float]:
    """φ of every channel against its nominal rate: its output's filter and the slowest of what feeds its module; or
    what its source leaves out, if that is more.

    ``CLOSED`` where every subscription is closed, or the source or what it works on is. Only inputs that may be
    decimated slow a module down: what must arrive whole (commands, odometry) does not set its pace.
    """
    own: dict[str, float] = {}
    thinned: dict[str, float] = {}
    feeds: dict[str, list[Feed]] = {}
    for channel in graph.producers:
        module, _, port = graph.producer_at_work(channel).partition(".")
        context = graph.modules[module].context
        output = context.outputs[port]
        own[channel] = output.filter.divisor
        thinned[channel] = output.thinned
        feeds[channel] = [
            (i.channel.name, i.subscription.filter.divisor)
            for i in context.inputs.values()
            if i.channel is not None and graph.specs[i.channel.name].decimable
        ]
    found = slowdowns(own, feeds)
    # What a source leaves out no filter would let through: it slows its own channel, and nothing that comes after
    return {
        name: max(found.get(name, 1.0), thinned.get(name, 1.0)) if channel.wanted else CLOSED
        for name, channel in graph.channels.items()
    }


class FreshnessWatch:
    """Freshness of every channel of a graph. :meth:`sample`, called about once a second, notifies observers of each
    change of state and logs channels that stay stale; :meth:`read` may be called at any time."""

    def __init__(self, graph: Graph, states: Mapping[str, ModuleState]) -> None:
        self._graph = graph
        self._states = states
        self._rates = {name: RateMeter() for name in graph.channels}
        #: By channel its divisor, since when, and when the channel was opened.
        self._since: dict[str, tuple[float, float, float]] = {}
        self._stale_since: dict[str, float] = {}
        self._logged: set[str] = set()
        self._sources = sources(graph)
        self._observers: Observers[[str, Freshness]] = Observers("the freshness of channels")
        self.latest: dict[str, Freshness] = {}

    def observe(self, callback: Callable[[str, Freshness], None]) -> Callable[[], None]:
        """Call ``callback(channel, freshness)`` at every change of a channel's state; returns a function that ends
        this."""
        return self._observers.add(callback)

    def reset(self) -> None:
        """Clear all measurements and states; every channel's first message is due from now on."""
        self._rates = {name: RateMeter() for name in self._rates}
        self._since.clear()
        self._stale_since.clear()
        self._logged.clear()
        self.latest = {}

    def sample(self, now: float) -> dict[str, Freshness]:
        """The freshness of each channel at ``now``, also kept in :attr:`latest`."""
        before, self.latest = self.latest, self.read(now)
        for name, freshness in self.latest.items():
            if name not in before or before[name].state != freshness.state:
                self._observers.notify(name, freshness)
            self._log(name, freshness, now)
        return self.latest

    def read(self, now: float) -> dict[str, Freshness]:
        """The freshness of each channel at ``now``; notifies no observer."""
        divisors = commanded_divisors(self._graph)
        return {name: self._judge(name, divisor, now) for name, divisor in divisors.items()}

    def _judge(self, name: str, divisor: float, now: float) -> Freshness:
        channel = self._graph.channels[name]
        held, _, opened = self._since.get(name, (CLOSED, now, now))
        if held != divisor or name not in self._since:
            self._since[name] = (divisor, now, now if held == CLOSED else opened)
        producer = self._graph.producer_at_work(name) if name in self._graph.producers else None
        state = None if producer is None else self._states.get(producer.partition(".")[0])
        _, since, opened = self._since[name]
        if state is not None and state.status == "running":
            since = max(since, state.since)
            if not state.restarts:
                opened = max(opened, state.since)
        last_stamp = None if channel.latest is None else channel.latest.stamp
        spec = self._graph.specs[name]
        if name not in self._sources:
            age_s = None if last_stamp is None else now - last_stamp
            return Freshness("closed" if divisor == CLOSED else "waiting", age_s, None, None)
        freshness = judge(spec, divisor, last_stamp=last_stamp, producer=state, now=now, since=since, opened=opened)
        rate_hz = self._rates[name].sample(now, channel.published)
        return Freshness(freshness.state, freshness.age_s, freshness.limit_s, freshness.commanded_hz, rate_hz)

    def _log(self, name: str, freshness: Freshness, now: float) -> None:
        if freshness.state != "stale":
            self._stale_since.pop(name, None)
            if name in self._logged:
                self._logged.remove(name)
                log.info("channel %s is %s again", name, freshness.state)
        elif name not in self._logged and now - self._stale_since.setdefault(name, now) >= HICCUP_S:
            self._logged.add(name)
            producer = self._graph.producers.get(name, "its source outside the program")
            age = (
                "nothing came yet" if freshness.age_s is None else f"its newest message is {freshness.age_s:.2f} s old"
            )
            allowed = "" if freshness.limit_s is None else f", {freshness.limit_s:.2f} s allowed"
            log.warning("channel %s is stale: %s%s; look at %s", name, age, allowed, producer)
