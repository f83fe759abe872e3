"""The node's side: joins a robot, runs the modules that it may, and gives them up when the robot is gone.

A node can be asked for nothing else: it takes messages for the inputs of its modules, their parameters, and beats.
Modules are made when the robot has admitted the node, and again each time, on a clock that reads as the robot's.
"""

from __future__ import annotations

import asyncio
import functools
import logging
import socket
import time
from collections.abc import Callable, Mapping
from contextlib import AsyncExitStack
from typing import TYPE_CHECKING, Any
from uuid import uuid4

import msgspec

from app.base import paths
from app.base.errors import ConfigError
from app.messages import Message
from app.remote import wire
from app.remote.codec import BadPayload, Codec
from app.remote.contract import Described
from app.remote.link import kept_of
from app.remote.session import ROBOT_ALIVE, Mailbox, Outbox, alive_key, from_key, join_key, open_session, to_key
from app.remote.wire import Admission, Beat, Data, Handled, Offer, Orders, Pulse, Result
from app.runtime.channel import Channel
from app.runtime.channel_table import ChannelSpec
from app.runtime.clock import RealClock
from app.runtime.errors import InboxOverflow
from app.runtime.graph import Graph, ModuleSpec
from app.runtime.subscription import Subscription
from app.runtime.supervisor import Supervisor

if TYPE_CHECKING:
    import zenoh

log = logging.getLogger("hbba.node")

ANSWER_WITHIN_S = 5.0
#: Results of an output that may wait to be sent.
_MOST_RESULTS = 256


class Refused(Exception):
    """The robot does not want this node; the message is its reason."""


class Node:
    """A node called ``name`` that runs ``modules``; :meth:`run` does it until cancelled."""

    def __init__(
        self,
        name: str,
        modules: Mapping[str, Described],
        channels: Mapping[str, ChannelSpec],
        *,
        quality: int | None = None,
    ) -> None:
        """``channels``: the table of the program. ``quality`` of images among the results (JPEG); None: raw."""
        self.name = name
        self._modules = dict(modules)
        self._channels = dict(channels)
        self._quality = quality
        self.process = uuid4().hex
        modules_offered = {module: described.offer() for module, described in self._modules.items()}
        self._offer = Offer(
            name,
            instance="",
            process=self.process,
            host=socket.gethostname(),
            version=paths.version(),
            modules=modules_offered,
        )
        self._changes: asyncio.Queue[bool] = asyncio.Queue(maxsize=64)

    async def run(self, settings: dict[str, Any], joined: Callable[[], None] = lambda: None) -> None:
        """Join the robot that ``settings`` (:func:`app.remote.session.configuration`) lead to, whenever it is there.

        ``joined`` is called each time the modules are about to run. Raises Refused, ConfigError.
        """
        async with AsyncExitStack() as stack:
            session = await asyncio.to_thread(open_session, settings)
            stack.push_async_callback(asyncio.to_thread, session.close)
            there: Mailbox[bool] = Mailbox("the robot comes and goes", self._note)
            stack.callback(there.close)
            watched = await asyncio.to_thread(_watch_robot, session, there)
            stack.callback(watched.undeclare)
            member: asyncio.Task[None] | None = None
            try:
                while True:
                    change = asyncio.create_task(self._changes.get())
                    await asyncio.wait({change} if member is None else {change, member}, return_when="FIRST_COMPLETED")
                    if member is not None and member.done():
                        change.cancel()
                        member.result()
                        raise RuntimeError("the node's membership ended by itself")
                    if member is not None:
                        await _ended(member)
                        member = None
                    if change.result():
                        member = asyncio.create_task(self._belong(session, joined), name="membership")
                    else:
                        log.warning("the robot is gone; waiting for it")
            finally:
                if member is not None:
                    await _ended(member)

    def _note(self, there: bool) -> None:
        if self._changes.full():
            self._changes.get_nowait()
        self._changes.put_nowait(there)

    async def _belong(self, session: zenoh.Session, joined: Callable[[], None]) -> None:
        """Join, and run the modules until cancelled. Raises Refused."""
        instance = uuid4().hex
        async with AsyncExitStack() as stack:
            outbox = Outbox(session, from_key(self.name, instance))
            stack.callback(outbox.close)
            before: list[bytes] = []
            home: Callable[[bytes], None] = before.append
            mailbox: Mailbox[bytes] = Mailbox("messages of the robot", lambda data: home(data))
            stack.callback(mailbox.close)
            subscriber = session.declare_subscriber(
                to_key(self.name, instance), lambda sample: mailbox.put(sample.payload.to_bytes())
            )
            stack.callback(subscriber.undeclare)
            offset = await self._admitted(session, instance)
            token = session.liveliness().declare_token(alive_key(self.name, instance))
            stack.callback(token.undeclare)
            running = _Running(self._modules, self._channels, RealClock(offset), outbox, self._quality)
            joined()
            home = running.take
            async with running.supervisor:
                for data in before:
                    running.take(data)
                await running.relay()

    async def _admitted(self, session: zenoh.Session, instance: str) -> float:
        """What the robot's clock has at least more than this computer's monotonic one, s. Raises Refused."""
        offer = msgspec.structs.replace(self._offer, instance=instance)
        while True:
            answer = await asyncio.to_thread(_ask, session, join_key(self.name), wire.encode(offer))
            if answer is not None:
                break
            log.info("the robot does not answer yet, or knows no node named %s", self.name)
        if answer.refusal:
            raise Refused(answer.refusal)
        return answer.now - time.monotonic()


class _Running:
    """The modules of one membership, wired to the link."""

    def __init__(
        self,
        modules: Mapping[str, Described],
        channels: Mapping[str, ChannelSpec],
        clock: RealClock,
        outbox: Outbox,
        quality: int | None,
    ) -> None:
        # A channel for each port: what two modules here take of one channel the robot sends to each by itself.
        table = {
            channel: channels[name].model_copy(update={"external": channel.startswith("in ")})
            for module in modules.values()
            for channel, name in _wiring(module).items()
        }
        specs = {name: _rewired(module) for name, module in modules.items()}
        self.graph = Graph(clock=clock, channels=table, modules=specs, services={})
        self.supervisor = Supervisor(self.graph.modules, clock)
        self._clock = clock
        self._outbox = outbox
        self._codecs: dict[tuple[str, str], Codec] = {}
        self._result_codecs: dict[tuple[str, str], Codec] = {}
        self._inputs: dict[tuple[str, str], Channel[Any]] = {}
        self._results: dict[tuple[str, str], Subscription[Any]] = {}
        #: Messages in the modules, by identity, until their handler has returned.
        self._at_work: dict[int, tuple[int, Message]] = {}
        for name, module in modules.items():
            slot = self.graph.modules[name]
            slot.context.handled = functools.partial(self._handled, name)
            for port, described in module.inputs.items():
                self._codecs[name, port] = Codec(described.message_type, quality)
                self._inputs[name, port] = self.graph.channels[f"in {name}.{port}"]
            for port, output in module.outputs.items():
                self._result_codecs[name, port] = Codec(output.message_type, quality)
                self._results[name, port] = self.graph.channels[f"out {name}.{port}"].subscribe(
                    f"robot.{name}.{port}", capacity=_MOST_RESULTS, lossless=True, demands=False
                )

    def take(self, data: bytes) -> None:
        """Do what the robot asks; what cannot be understood is logged and dropped."""
        try:
            envelope = wire.to_node(data)
            if isinstance(envelope, Beat):
                # It was read before it came: of all beats the quickest says best how far the clocks are apart.
                self._clock.offset = max(self._clock.offset, envelope.now - time.monotonic())
                self._outbox.send(wire.encode(Pulse(envelope.seq, self._down())), newest=True)
            elif isinstance(envelope, Orders):
                self._order(envelope)
            else:
                self._give(envelope)
        except (wire.BadEnvelope, BadPayload) as failure:
            log.warning("the robot sends what this node does not understand: %s", failure)

    async def relay(self) -> None:
        """Send every result, in order, until cancelled."""
        async with asyncio.TaskGroup() as group:
            for (module, port), subscription in self._results.items():
                group.create_task(self._relay(module, port, subscription), name=f"results of {module}.{port}")

    def _give(self, data: Data) -> None:
        channel = self._inputs.get((data.module, data.port))
        if channel is None:
            raise BadPayload(f"there is no input {data.module}.{data.port} here")
        slot = self.graph.modules[data.module]
        for key, value in data.kept.items():
            slot.context.persistent[key] = max(value, slot.context.persistent.get(key, value))
        message = self._codecs[data.module, data.port].decode(data.payload)
        if data.seq:
            self._at_work[id(message)] = (data.seq, message)
        while len(self._at_work) > _MOST_RESULTS:
            del self._at_work[next(iter(self._at_work))]
        channel.publish(message)

    def _order(self, orders: Orders) -> None:
        if orders.module not in self.graph.modules:
            raise BadPayload(f"there is no {orders.module} here")
        self.graph.configure(orders.module, orders.parameters)
        for port, wanted in orders.wanted.items():
            subscription = self._results.get((orders.module, port))
            if subscription is not None:
                subscription.demand(wanted)

    def _handled(self, _module: str, _port: str, message: Message) -> None:
        known = self._at_work.pop(id(message), None)
        if known is not None:
            # After what it published, which is sent in the turns of the loop before.
            asyncio.get_running_loop().call_soon(self._confirm, known[0])

    def _confirm(self, seq: int) -> None:
        self._outbox.send(wire.encode(Handled(seq)))

    async def _relay(self, module: str, port: str, subscription: Subscription[Any]) -> None:
        codec, context = self._result_codecs[module, port], self.graph.modules[module].context
        while True:
            try:
                message = await subscription.receive()
            except InboxOverflow as loss:
                log.error("results are lost: %s", loss)
                continue
            payload = await asyncio.to_thread(codec.encode, message) if codec.heavy else codec.encode(message)
            self._outbox.send(wire.encode(Result(module, port, payload, kept_of(context.persistent))))

    def _down(self) -> dict[str, str]:
        states = self.supervisor.states.values()
        return {
            state.name: f"is {state.status}{f': {state.problem}' if state.problem else ''}"
            for state in states
            if state.stale
        }


def _wiring(module: Described) -> dict[str, str]:
    """The channels of the node for ``module``, each with that of the robot it represents."""
    inputs = {f"in {module.name}.{port}": channel for port, channel in module.spec.inputs.items()}
    return inputs | {f"out {module.name}.{port}": channel for port, channel in module.spec.outputs.items()}


def _rewired(module: Described) -> ModuleSpec:
    wiring = {
        "inputs": {port: f"in {module.name}.{port}" for port in module.spec.inputs},
        "outputs": {port: f"out {module.name}.{port}" for port in module.spec.outputs},
    }
    return module.spec.model_copy(update=wiring)


def _watch_robot(session: zenoh.Session, there: Mailbox[bool]) -> zenoh.Subscriber[None]:
    import zenoh

    return session.liveliness().declare_subscriber(
        ROBOT_ALIVE, lambda sample: there.put(sample.kind == zenoh.SampleKind.PUT), history=True
    )


def _ask(session: zenoh.Session, key: str, payload: bytes) -> Admission | None:
    """The robot's answer, None without one; it blocks. Raises ConfigError for one that cannot be understood."""
    for reply in session.get(key, payload=payload, timeout=ANSWER_WITHIN_S):
        if reply.ok is not None:
            try:
                return wire.admission(reply.ok.payload.to_bytes())
            except wire.BadEnvelope as failure:
                raise ConfigError(f"the robot's answer is of another version: {failure}") from None
    return None


async def _ended(task: asyncio.Task[None]) -> None:
    task.cancel()
    await asyncio.wait({task})
    if not task.cancelled() and (error := task.exception()) is not None:
        raise error
