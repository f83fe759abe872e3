"""A module's typed ends of channels; made by ``Module.input`` and ``Module.output``, wired by the graph."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Generic, TypeVar

from app.messages import Message
from app.runtime.channel import Channel, Subscription
from app.runtime.errors import ModuleFailed
from app.runtime.filter import CLOSED, RateFilter

M = TypeVar("M", bound=Message)

log = logging.getLogger("hbba.module")


class Input(Generic[M]):
    """An input port. Once wired, ``subscription`` is the module's end of a channel.

    ``always_open`` inputs are not attention's to decimate: safety and self-motion, where a gap is a fault. What comes
    in by an input that ``moves`` can move the body. A ``passive`` input takes what passes and keeps no source awake.
    """

    def __init__(
        self,
        module: str,
        name: str,
        message_type: type[M],
        capacity: int,
        lossless: bool,
        always_open: bool,
        moves: bool = False,
        passive: bool = False,
    ) -> None:
        self.module = module
        self.name = name
        self.message_type = message_type
        self.capacity = capacity
        self.lossless = lossless
        self.always_open = always_open
        self.moves = moves
        self.passive = passive
        self.channel: Channel[M] | None = None
        self._subscription: Subscription[M] | None = None

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

    def connect(self, channel: Channel[M], divisor: float, *, passive: bool = False) -> None:
        """Subscribe this port to ``channel`` (done once, by the graph)."""
        self.channel = channel
        self._subscription = channel.subscribe(
            f"{self.module}.{self.name}",
            capacity=self.capacity,
            lossless=self.lossless,
            divisor=divisor,
            passive=passive,
        )


class Output(Generic[M]):
    """An output port: publishes on its channel what its own filter lets through.

    When the filter closes, the module's last word for this port (a stop, say) is published once, unfiltered; nothing
    is said on a channel that is closed.
    """

    def __init__(self, module: str, name: str, message_type: type[M]) -> None:
        self.module = module
        self.name = name
        self.message_type = message_type
        self.channel: Channel[M] | None = None
        self.filter = RateFilter(1, self._filter_changed)
        #: Asked for a closing word when the filter closes.
        self.last_word: Callable[[], M | None] | None = None
        self.offered = 0
        self._wanted_callbacks: list[Callable[[bool], None]] = []
        self._told_wanted = False
        self._stop_listening: Callable[[], None] | None = None

    def connect(self, channel: Channel[M]) -> None:
        """Publish on ``channel`` from now on (done once, by the graph)."""
        self.channel = channel
        if self._wanted_callbacks:
            self._listen(channel)

    def succeed(self, former: Output[M]) -> None:
        """Take over channel, filter and counter from ``former``, whose module instance is gone.

        Whatever is left of that instance publishes into the void from then on.
        """
        self.channel, self.filter, self.offered = former.channel, former.filter, former.offered
        self.filter.on_change = self._filter_changed
        former.channel, former.filter, former.last_word = None, RateFilter(CLOSED), None
        former.forget_callbacks()

    def publish(self, message: M) -> None:
        """Publish ``message`` if the filter lets it pass; an unwired output swallows it."""
        self.offered += 1
        if self.filter.offer() and self.channel is not None:
            self.channel.publish(message)

    @property
    def wanted(self) -> bool:
        """Whether publishing would reach anyone: a module may save itself the work otherwise."""
        return self.channel is not None and self.channel.wanted and self.filter.is_open

    def on_wanted(self, callback: Callable[[bool], None]) -> Callable[[], None]:
        """Call ``callback(wanted)`` now and whenever :attr:`wanted` changes; returns what ends it.

        Ends by itself with this module instance: a restarted one registers anew.
        """
        self._wanted_callbacks.append(callback)
        callback(self.wanted)
        if self._stop_listening is None and self.channel is not None:
            self._told_wanted = self.wanted
            self._listen(self.channel)

        def end() -> None:
            if callback in self._wanted_callbacks:
                self._wanted_callbacks.remove(callback)

        return end

    def forget_callbacks(self) -> None:
        """Forget everybody who asked to be told whether this output is wanted."""
        self._wanted_callbacks.clear()
        if self._stop_listening is not None:
            self._stop_listening()
            self._stop_listening = None

    def close_quietly(self) -> None:
        """Close the filter without a last word: nothing was said yet."""
        last_word, self.last_word = self.last_word, None
        self.filter.divisor = CLOSED
        self.last_word = last_word

    def _listen(self, channel: Channel[M]) -> None:
        self._stop_listening = channel.on_wanted(self._tell_wanted)

    def _filter_changed(self, _before: float, after: float) -> None:
        # On a stream that has ended a last word is not received, and a rewrite of many filters must not stop half-way.
        if after == CLOSED and self.channel is not None and not self.channel.closed and self.last_word is not None:
            message = self.last_word()
            if message is not None:
                self.channel.publish(message)
        self._tell_wanted(self.wanted)

    def _tell_wanted(self, _: bool) -> None:
        wanted = self.wanted
        if wanted != self._told_wanted:
            self._told_wanted = wanted
            for callback in tuple(self._wanted_callbacks):
                try:
                    callback(wanted)
                except Exception:
                    # As in Channel: whoever wrote the filter is half-way through an intention.
                    log.exception("%s.%s: a source could not be told whether it is wanted", self.module, self.name)
