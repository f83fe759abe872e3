"""The robot's end of the link to one node: sends messages and orders, takes results, and keeps its health."""

from __future__ import annotations

import asyncio
import logging
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from app.base.observers import Observers
from app.remote import wire
from app.remote.health import LinkHealth
from app.remote.session import Mailbox, Outbox, from_key, to_key
from app.remote.settings import NodeSettings
from app.remote.wire import Beat, Data, FromNode, Handled, Orders, Pulse, Result
from app.runtime.clock import Clock

if TYPE_CHECKING:
    import zenoh

log = logging.getLogger("hbba.remote")

#: Messages of an input on their way: one is worked at while the next one comes.
MOST_UNDER_WAY = 2
#: Weight of the messages before in the mean of their sizes.
_REMEMBERED = 0.95
#: Beats whose answers are still waited for.
_MOST_BEATS = 32
#: Bytes that a beat is filled with at most.
_MOST_FILLING = 256 * 1024


class StandIn(Protocol):
    """The module at home that represents one on the node."""

    def take(self, result: Result) -> None:
        """A message of one of its outputs has come."""
        ...

    def orders(self) -> Orders:
        """What the module over there must know from the beginning."""
        ...


class _UnderWay:
    """Messages of one input that were sent and not handled yet: :meth:`room` waits until another may follow."""

    def __init__(self) -> None:
        self._count = 0
        self._changed = asyncio.Event()

    def add(self) -> None:
        self._count += 1

    def end(self, count: int | None = None) -> None:
        """One of them, or all, is handled or given up."""
        self._count = 0 if count is None else max(self._count - count, 0)
        self._changed.set()

    async def room(self) -> None:
        while self._count >= MOST_UNDER_WAY:
            self._changed.clear()
            await self._changed.wait()


@dataclass(frozen=True, slots=True)
class _Sent:
    stamp: float
    under_way: _UnderWay
    #: Gives it up when the deadline is over.
    timer: asyncio.TimerHandle


class NodeLink:
    """The link to one node, joined or not. All is called on the event loop.

    ``observe`` reports each change of whether the node may be used, with the reason in words.
    """

    def __init__(self, name: str, settings: NodeSettings, clock: Clock) -> None:
        self.name = name
        self.settings = settings
        self.health = LinkHealth(name, settings.deadline_s)
        self.offer: wire.Offer | None = None
        #: Results that came while the node was not used.
        self.refused = 0
        self._clock = clock
        self._stand_ins: dict[str, StandIn] = {}
        self._observers: Observers[[bool, str]] = Observers(f"the link to {name}")
        self._trip_observers: Observers[[float]] = Observers(f"round trips to {name}")
        self._reported = (False, self.health.why)
        self._outbox: Outbox | None = None
        self._mailbox: Mailbox[bytes] | None = None
        self._subscriber: zenoh.Subscriber[None] | None = None
        self._sent: dict[int, _Sent] = {}
        self._under_way: dict[tuple[str, str], _UnderWay] = {}
        self._beats: dict[int, float] = {}
        self._seq = 0
        self._message_bytes = 0
        self.sent_bytes = 0
        #: Mean bytes of a message by input ``Module.port``, of those that were sent lately.
        self.sizes: dict[str, float] = {}

    @property
    def usable(self) -> bool:
        return self.health.usable

    def observe(self, callback: Callable[[bool, str], None]) -> Callable[[], None]:
        """Call ``callback(usable, why)`` now and at each change; returns a function that ends this."""
        callback(*self._reported)
        return self._observers.add(callback)

    def observe_trips(self, callback: Callable[[float], None]) -> Callable[[], None]:
        """Call ``callback`` with the round trip (s) of each message that was handled; returns a function that ends
        this."""
        return self._trip_observers.add(callback)

    # --- Modules at home ---------------------------------------------------------------------------------------------

    def attach(self, module: str, stand_in: StandIn) -> Callable[[], None]:
        """Let ``stand_in`` stand for ``module``; returns a function that ends this."""
        self._stand_ins[module] = stand_in
        if self._outbox is not None:
            self.send_orders(stand_in.orders())

        def detach() -> None:
            if self._stand_ins.get(module) is stand_in:
                del self._stand_ins[module]

        return detach

    def send_orders(self, orders: Orders) -> None:
        """Send parameters and demand; a node that joins later is sent the newest then."""
        if self._outbox is not None:
            self._outbox.send(wire.encode(orders))

    async def send(self, module: str, port: str, payload: bytes, *, kept: Mapping[str, int], awaits: bool) -> None:
        """Send a message while the node may be used. With ``awaits``, return once another may follow: when all but one
        before it were handled there, or not within the deadline. The next is then newer than what a queue would hold.
        """
        outbox = self._outbox
        if outbox is None or not self.usable:
            return
        self._seq += 1
        seq = self._seq if awaits else 0
        data = wire.encode(Data(module, port, seq, payload, dict(kept)))
        self.sent_bytes += len(data)
        name, size = f"{module}.{port}", float(len(data))
        self.sizes[name] = size + _REMEMBERED * (self.sizes.get(name, size) - size)
        if not awaits:
            outbox.send(data)
            return
        self._message_bytes = len(data)
        under_way = self._under_way.setdefault((module, port), _UnderWay())
        under_way.add()
        timer = asyncio.get_running_loop().call_later(self.settings.deadline_s, self._give_up, seq)
        self._sent[seq] = _Sent(self._clock.now(), under_way, timer)
        outbox.send(data, newest=True)
        await under_way.room()

    # --- The node ----------------------------------------------------------------------------------------------------

    def join(self, session: zenoh.Session, offer: wire.Offer) -> None:
        """The node was admitted. What an instance before it still sends is not taken."""
        self.leave("")
        self.offer = offer
        mailbox: Mailbox[bytes] = Mailbox(f"results of {self.name}", self._take)
        self._mailbox = mailbox
        self._subscriber = session.declare_subscriber(
            from_key(self.name, offer.instance), lambda sample: mailbox.put(sample.payload.to_bytes())
        )
        self._outbox = Outbox(session, to_key(self.name, offer.instance))
        self.health.join()
        for stand_in in self._stand_ins.values():
            self.send_orders(stand_in.orders())
        self._report()

    def leave(self, why: str) -> None:
        """The node has gone: nothing is sent or taken any more, and no sender waits."""
        if self._subscriber is not None:
            self._subscriber.undeclare()  # type: ignore[no-untyped-call]
        if self._mailbox is not None:
            self._mailbox.close()
        if self._outbox is not None:
            self._outbox.close()
        self._subscriber, self._mailbox, self._outbox, self.offer = None, None, None, None
        for sent in self._sent.values():
            sent.timer.cancel()
        for under_way in self._under_way.values():
            under_way.end()
        self._sent.clear()
        self._beats.clear()
        if why:
            self.health.leave(why)
            self._report()

    def beat(self) -> None:
        """Ask whether it is there; called every :data:`app.remote.health.BEAT_S`."""
        if self._outbox is None:
            return
        now = self._clock.now()
        self.health.beat(now)
        self._report()
        self._seq += 1
        self._beats[self._seq] = now
        while len(self._beats) > _MOST_BEATS:
            del self._beats[next(iter(self._beats))]
        # A link that was too slow is tried with as much as would be sent.
        filling = bytes(min(self._message_bytes, _MOST_FILLING)) if not self.usable else b""
        self._outbox.send(wire.encode(Beat(self._seq, now, filling)), newest=True)

    # --- Inside ------------------------------------------------------------------------------------------------------

    def _take(self, data: bytes) -> None:
        try:
            envelope: FromNode = wire.from_node(data)
        except wire.BadEnvelope as failure:
            log.warning("%s sends what cannot be understood: %s", self.name, failure)
            return
        now = self._clock.now()
        if isinstance(envelope, Handled):
            sent = self._sent.pop(envelope.seq, None)
            if sent is not None:
                sent.timer.cancel()
                sent.under_way.end(1)
                self.health.trip(now, now - sent.stamp)
                self._trip_observers.notify(now - sent.stamp)
        elif isinstance(envelope, Pulse):
            stamp = self._beats.pop(envelope.seq, None)
            if stamp is not None:
                down = next((f"{module} {why}" for module, why in envelope.down.items()), "")
                self.health.answered(now, now - stamp, down)
        else:
            self._result(envelope)
        self._report()

    def _give_up(self, seq: int) -> None:
        sent = self._sent.pop(seq, None)
        if sent is not None:
            sent.under_way.end(1)
            self.health.trip(self._clock.now(), math.inf)
            self._report()

    def _result(self, result: Result) -> None:
        stand_in = self._stand_ins.get(result.module)
        # What comes after the node was given up is of another time than what is perceived here meanwhile.
        if stand_in is None or not self.usable:
            self.refused += 1
            return
        stand_in.take(result)

    def _report(self) -> None:
        now = (self.health.usable, self.health.why)
        if now != self._reported:
            self._reported = now
            self._observers.notify(*now)


def kept_of(persistent: Mapping[str, Any]) -> dict[str, int]:
    """What a module keeps over restarts, as far as it can go over the network: whole numbers."""
    return {key: value for key, value in persistent.items() if type(value) is int and abs(value) <= wire.MOST_KEPT}
