"""What a module is: typed ports, handlers, and a life cycle that the supervisor drives.

A module declares its ports and handlers in its constructor and does nothing else there; heavy set-up belongs in
``start``. A fresh instance is made for every (re)start, on the same ports: subscriptions, filters and counters
outlive a crash.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable, Coroutine, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, TypeVar

from pydantic import BaseModel, ConfigDict

from app.messages import Message
from app.runtime.channel_table import ChannelSpec
from app.runtime.clock import Clock
from app.runtime.errors import InboxOverflow, ModuleFailed
from app.runtime.load import CpuMeter, MeteredCoroutine
from app.runtime.pending_work import Activity
from app.runtime.ports import Input, Output
from app.runtime.worker import ModuleWorker

__all__ = ["Caution", "Input", "Module", "ModuleContext", "Output", "Settings"]

M = TypeVar("M", bound=Message)
T = TypeVar("T")
ServiceT = TypeVar("ServiceT")


class Settings(BaseModel):
    """Base of a module's settings, as they stand in configuration: frozen; unknown keys and what is no finite number
    are refused."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


@dataclass(frozen=True, slots=True)
class Caution:
    """What people must know of how a program is configured: a ``title`` of a few words, and a sentence that says why
    and what to do. ``where``: its file and line, "" where it has none."""

    title: str
    text: str
    where: str = ""

    def __str__(self) -> str:
        return f"{self.where}: {self.text}" if self.where else self.text


class ModuleContext:
    """What a module slot keeps between restarts: ports, clock, settings, services, its CPU meter and its worker."""

    def __init__(self, name: str, clock: Clock, settings: Settings, services: Mapping[type[Any], Any]) -> None:
        self.name = name
        self.clock = clock
        self.settings = settings
        self.services = services
        self.inputs: dict[str, Input[Any]] = {}
        self.outputs: dict[str, Output[Any]] = {}
        self.parameters: dict[str, Any] = {}
        #: What an instance leaves to the one after a restart; see :attr:`Module.kept`.
        self.kept: dict[str, Any] = {}
        #: The latest instance made for this place.
        self.instance: Module | None = None
        self.meter = CpuMeter()
        self.worker = ModuleWorker(name)
        #: For what may take long; its thread begins with the first of that.
        self.behind = ModuleWorker(f"{name}, behind")
        #: Where work in threads is counted; the graph's own.
        self.activity = Activity()


class Module:
    """Base of all modules; see the top of this file, and docs/writing-a-module.md."""

    #: What people call it.
    title: ClassVar[str] = ""
    #: The model its settings are checked against.
    Settings: ClassVar[type[Settings]] = Settings
    #: The desire classes (:class:`app.attention.desires.DesireClass`) that it serves or needs: those of a program are
    #: the union of its modules'. The type stands above the runtime.
    desire_classes: ClassVar[tuple[object, ...]] = ()
    #: Which stream of the body each output relays: the way back from a recorded channel to the body's stream.
    streams: ClassVar[Mapping[str, str]] = {}
    #: Inputs that only help with what comes on the others: nothing by themselves.
    aids: ClassVar[frozenset[str]] = frozenset()

    @classmethod
    def default_inputs(cls, channels: Mapping[str, ChannelSpec]) -> Mapping[str, str]:
        """Input port: channel, for a module whose configuration names no inputs; ``channels`` is the whole table."""
        return {}

    def accept(self, name: str, message_type: type[Message]) -> None:
        """Declare an input that configuration asks for and the constructor did not; a module that takes whatever there
        is overrides it. By default nothing is declared, and the graph refuses the input.
        """

    def __init__(self, context: ModuleContext) -> None:
        self._context = context
        self.name = context.name
        self.clock = context.clock
        #: As configuration gives them; a subclass with its own ``Settings`` annotates this with that class.
        self.settings: Settings = context.settings
        self.log = logging.getLogger(f"hbba.{context.name}")
        #: When each periodic handler last came round, and its period (s): how the supervisor tells a hung one.
        self.ticks: dict[str, tuple[float, float]] = {}
        self._handlers: list[tuple[Input[Any], Callable[[Any], Awaitable[None]]]] = []
        self._timers: list[tuple[float, Callable[[], Awaitable[None]]]] = []
        self._failure: asyncio.Future[None] | None = None

        context.instance = self

    @property
    def kept(self) -> dict[str, Any]:
        """What outlives this instance: after a restart the next one finds it here. For little that must not be told
        twice (the next number to give out), or frozen values that would be lost for good (a map nobody saved); what it
        may have failed of is handed on once, not again and again. Begins empty, and again whenever all begins anew (a
        replay that jumps).
        """
        return self._context.kept

    # --- declaring ---

    def input(
        self,
        name: str,
        message_type: type[M],
        *,
        capacity: int = 1,
        lossless: bool = False,
        always_open: bool = False,
        moves: bool = False,
    ) -> Input[M]:
        """Declare an input port of ``message_type`` with an inbox of ``capacity`` messages.

        ``moves``: what comes in by it can move the body. The output of another module that leads to it stays closed
        unless a strategy names it.
        """
        port = self._context.inputs.get(name)
        if port is None:
            port = Input(self.name, name, message_type, capacity, lossless, always_open, moves)
            self._context.inputs[name] = port
        return port

    def output(self, name: str, message_type: type[M]) -> Output[M]:
        """Declare an output port of ``message_type``."""
        port = Output(self.name, name, message_type)
        if former := self._context.outputs.get(name):
            port.succeed(former)
        self._context.outputs[name] = port
        port.last_word = lambda: self._closing_word(name)
        return port

    def on(self, port: Input[M], handler: Callable[[M], Awaitable[None]]) -> None:
        """Have ``handler`` called with each message taken from ``port``, one at a time."""
        self._handlers.append((port, handler))

    def every(self, period_s: float, handler: Callable[[], Awaitable[None]]) -> None:
        """Have ``handler`` called every ``period_s`` seconds; beats missed while it ran are skipped."""
        self._timers.append((period_s, handler))

    def service(self, service_type: type[ServiceT]) -> ServiceT:
        """The program's one object of ``service_type`` (the robot link, the Intention Workspace).

        Raises ModuleFailed naming it if this program has none.
        """
        try:
            service: ServiceT = self._context.services[service_type]
        except KeyError:
            raise ModuleFailed(f"{self.name} needs a {service_type.__name__}, which this robot does not have") from None
        return service

    # --- to be overridden ---

    def check_wiring(self) -> None:
        """Refuse what is wired so that it must not run: called once, with all ports wired and before anything starts.

        Raises ModuleFailed with a sentence that says what to do.
        """

    def cautions(self) -> tuple[Caution, ...]:
        """What people must know of how this module is configured; asked once, with all ports wired."""
        return ()

    async def start(self) -> None:
        """Set up what takes time or can fail; called before the first message."""

    async def stop(self) -> None:
        """Release what ``start`` took; called once, whatever ended the module."""

    def configure(self, parameters: Mapping[str, Any]) -> None:
        """Take over the intention's parameters for this module (P'); called on the loop, again after a restart."""

    def last_word(self, port: str) -> Any:
        """The message to publish once when attention closes output ``port``, or None."""
        return None

    def overflowed(self, port: str, loss: InboxOverflow) -> None:
        """Called once after the lossless input ``port`` lost messages; by default that is the module's failure."""
        raise loss

    # --- for the runtime ---

    @property
    def running(self) -> bool:
        """Whether it has started and not ended: only then are parameters handed to it."""
        return self._failure is not None

    def fail(self, error: Exception) -> None:
        """End :meth:`run` with ``error``, which happened in a call from outside its own tasks."""
        if self._failure is None:
            self.log.error("%s, not running: %s: %s", self.name, type(error).__name__, error)
        elif not self._failure.done():
            self._failure.set_exception(error)

    def reconfigure(self, parameters: Mapping[str, Any]) -> None:
        """Call :meth:`configure` now if it runs; what it raises is this module's failure, not the caller's."""
        if self.running:
            try:
                self.configure(parameters)
            except Exception as error:  # noqa: BLE001  # raised by run()
                self.fail(error)

    def _closing_word(self, port: str) -> Any:
        try:
            return self.last_word(port)
        except Exception as error:  # noqa: BLE001  # raised by run()
            self.fail(error)
            return None

    # --- working ---

    async def compute(self, function: Callable[..., T], *args: Any) -> T:
        """Run CPU-bound ``function(*args)`` in this module's thread, charging its CPU time to this module.

        One at a time, in the order asked. Raises what ``function`` raises.
        """
        loop = asyncio.get_running_loop()
        with self._context.activity.one():
            return await loop.run_in_executor(self._context.worker, self._context.meter.call, function, *args)

    async def compute_behind(self, function: Callable[..., T], *args: Any) -> T:
        """As :meth:`compute`, in a second thread of this module: for work that may take long and holds up no message.

        What it shares with :meth:`compute` must bear two threads. It has the priority of all others: a thread of less
        that holds the interpreter's lock would hold up everybody while the computer is busy.
        """
        loop = asyncio.get_running_loop()
        with self._context.activity.one():
            return await loop.run_in_executor(self._context.behind, self._context.meter.call, function, *args)

    async def run(self, started: Callable[[], None] = lambda: None) -> None:
        """Live: start, call ``started``, serve every input and timer until cancelled or until one raises, stop."""
        try:
            # Inside the try: a start that fails half-way still has its stop.
            await self.start()
            self.configure(self._context.parameters)
            self._failure = asyncio.get_running_loop().create_future()
            started()
            async with asyncio.TaskGroup() as group:
                for port, handler in self._handlers:
                    if port.connected:
                        group.create_task(self._metered(self._serve(port, handler)), name=f"{self.name}.{port.name}")
                for number, (period_s, beat) in enumerate(self._timers):
                    key = f"{getattr(beat, '__name__', 'timer')}-{number}"
                    group.create_task(self._metered(self._repeat(key, period_s, beat)), name=f"{self.name}.{key}")
                group.create_task(_outcome(self._failure), name=f"{self.name}.alive")
        finally:
            self._failure = None
            await self.stop()

    @property
    def _superseded(self) -> bool:
        return self._context.instance is not self

    def _metered(self, coroutine: Coroutine[Any, Any, T]) -> Coroutine[Any, Any, T]:
        return MeteredCoroutine(coroutine, self._context.meter)

    async def _serve(self, port: Input[M], handler: Callable[[M], Awaitable[None]]) -> None:
        while True:
            try:
                message = await anext(port.subscription)
            except StopAsyncIteration:
                return
            except InboxOverflow as loss:
                self.overflowed(port.name, loss)
                continue
            await handler(message)
            if self._superseded:
                # It outlived its cancellation; what comes now is for its successor.
                return

    async def _repeat(self, key: str, period_s: float, handler: Callable[[], Awaitable[None]]) -> None:
        due = self.clock.now()
        while not self._superseded:
            self.ticks[key] = (self.clock.now(), period_s)
            await handler()
            due += period_s
            # A beat that comes late is made up for at once and leaves those after it where they are; of several that
            # were missed, the last one is.
            late = self.clock.now() - due
            due += max(late // period_s, 0.0) * period_s
            await self.clock.sleep_until(due)


async def _outcome(future: asyncio.Future[None]) -> None:
    await future
