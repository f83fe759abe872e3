"""A module's typed ends of channels; made by ``Module.input`` and ``Module.output``, wired by the graph."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass, field
from typing import Generic, Literal, TypeVar

from app.base.observers import Observers
from app.messages import Message
from app.runtime.channel import Channel
from app.runtime.errors import ModuleFailed
from app.runtime.filter import CLOSED, RateFilter
from app.runtime.subscription import Subscription

M = TypeVar("M", bound=Message)

#: When an input wants its channel, so that the source must work: always; only while an output of its module is wanted;
#: or never (but a channel from outside the graph: a log feeds only what is wanted). What is published comes in at any
#: rate.
Wants = Literal["always", "if_wanted", "never"]


@dataclass(eq=False)
class Input(Generic[M]):
    """An input port, as :meth:`app.runtime.module.Module.input` declares it. Once wired, ``subscription`` is the
    module's end of a channel.

    ``always_open``: attention may not decimate the input; for safety and self-motion, where a gap is a fault.
    ``rests``: while attention has closed all it controls of the module, the newest ``capacity`` messages wait in the
    inbox and do not wake the module; see :meth:`Subscription.rest`.
    """

    module: str
    name: str
    message_type: type[M]
    _: KW_ONLY
    capacity: int = 1
    lossless: bool = False
    always_open: bool = False
    moves: bool = False
    wants: Wants = "always"
    rests: bool = False
    channel: Channel[M] | None = field(default=None, init=False)
    _subscription: Subscription[M] | None = field(default=None, init=False)

    @property
    def subscription(self) -> Subscription[M]:
        """The module's end of the channel. Raises ModuleFailed while the port is not wired."""
        if self._subscription is None:
            raise ModuleFailed(f"{self.module}.{self.name} is not connected to any channel")
        return self._subscription

    @property
    def connected(self) -> bool:
        """Whether configuration wired this port."""
        return self._subscription is not None

    def connect(self, channel: Channel[M], divisor: float, *, demands: bool = True) -> None:
        """Subscribe this port to ``channel`` (done once, by the graph), which is wanted for it if it ``demands``."""
        self.channel = channel
        self._subscription = channel.subscribe(
            f"{self.module}.{self.name}",
            capacity=self.capacity,
            lossless=self.lossless,
            divisor=divisor,
            demands=demands,
        )


class Output(Generic[M]):
    """An output port: publishes on its channel the messages that pass its own filter.

    When the filter closes, the module's last message for this port (a stop, for instance) is published once,
    unfiltered; a closed channel gets none.
    """

    def __init__(self, module: str, name: str, message_type: type[M]) -> None:
        self.module = module
        self.name = name
        self.message_type = message_type
        self.channel: Channel[M] | None = None
        self.filter = RateFilter(1, self._filter_changed)
        #: Returns the last message when the filter closes.
        self.last_word: Callable[[], M | None] | None = None
        self.offered = 0
        #: By how much the source is thinned now, on behalf of the filters: 1 for a source that gives every message.
        self.thinned: float = 1
        self._divisor_observers: Observers[[float]] = Observers(f"demand for {module}.{name}")
        self._reported_divisor: float = CLOSED
        self._stop_listening: Callable[[], None] | None = None

    def connect(self, channel: Channel[M]) -> None:
        """Publish on ``channel`` from now on (done once, by the graph)."""
        self.channel = channel
        if self._divisor_observers:
            self._listen(channel)

    def succeed(self, former: Output[M]) -> None:
        """Take over channel, filter and counter from ``former``, whose module instance has ended.

        Messages that the former instance still publishes are discarded.
        """
        self.channel, self.filter, self.offered = former.channel, former.filter, former.offered
        self.filter.on_change = self._filter_changed
        former.channel, former.filter, former.last_word = None, RateFilter(CLOSED), None
        former.clear_callbacks()

    def publish(self, message: M, periods: int = 1) -> None:
        """Publish ``message`` if the filter lets it pass; an unwired output swallows it.

        It ends ``periods`` of the source: more than one after some that the source left out, see :attr:`divisor`.
        """
        self.offered += periods
        if (passed := self.filter.offer(periods)) and self.channel is not None:
            self.channel.publish(message, passed)

    @property
    def wanted(self) -> bool:
        """Whether publishing would reach a subscription: a module may skip the work otherwise."""
        return self.channel is not None and self.channel.wanted and self.filter.is_open

    @property
    def divisor(self) -> float:
        """One message in so many suffices for this filter and the channel's (:attr:`Channel.divisor`); ``CLOSED``: none
        is wanted.
        """
        return CLOSED if self.channel is None else self.filter.divisor * self.channel.divisor

    def on_divisor(self, callback: Callable[[float], None]) -> Callable[[], None]:
        """Call ``callback(divisor)`` now and whenever :attr:`divisor` changes; returns a function that ends this.

        It ends with this module instance: after a restart the next instance registers again.
        """
        remove = self._divisor_observers.add(callback)
        callback(self.divisor)
        if self._stop_listening is None and self.channel is not None:
            self._reported_divisor = self.divisor
            self._listen(self.channel)
        return remove

    def clear_callbacks(self) -> None:
        """Remove every callback of :meth:`on_divisor`."""
        self._divisor_observers.clear()
        if self._stop_listening is not None:
            self._stop_listening()
            self._stop_listening = None

    def close_quietly(self) -> None:
        """Close the filter without a last message: nothing was published yet."""
        last_word, self.last_word = self.last_word, None
        self.filter.divisor = CLOSED
        self.last_word = last_word

    def _listen(self, channel: Channel[M]) -> None:
        self._stop_listening = channel.on_divisor(self._report_divisor)

    def _filter_changed(self, _before: float, after: float) -> None:
        # A closed stream delivers no last message, and a rewrite of many filters must not stop half-way.
        if after == CLOSED and self.channel is not None and not self.channel.closed and self.last_word is not None:
            message = self.last_word()
            if message is not None:
                self.channel.publish(message)
        self._report_divisor(self.divisor)

    def _report_divisor(self, _: float) -> None:
        divisor = self.divisor
        if divisor != self._reported_divisor:
            self._reported_divisor = divisor
            self._divisor_observers.notify(divisor)
