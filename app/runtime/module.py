"""The base of modules: typed ports, handlers, and a life cycle that the supervisor drives.

A module declares its ports and handlers in its constructor and does nothing else there; long set-up belongs in
``start``. A new instance is made for every (re)start, on the same ports: subscriptions, filters and counters survive a
crash.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable, Coroutine, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, TypeVar

from pydantic import BaseModel

from app.messages import Message
from app.messages.records import ModuleRole
from app.runtime.channel_table import ChannelSpec
from app.runtime.clock import Clock
from app.runtime.errors import InboxOverflow, ModuleFailed
from app.runtime.load import CpuMeter, MeteredCoroutine
from app.runtime.pending_work import PendingWork
from app.runtime.ports import Input, Output, Wants
from app.runtime.worker import ModuleWorker

__all__ = ["Caution", "Input", "Module", "ModuleContext", "Output", "Settings"]

M = TypeVar("M", bound=Message)
T = TypeVar("T")
ServiceT = TypeVar("ServiceT")


class Settings(BaseModel, frozen=True, extra="forbid", allow_inf_nan=False):
    """Base of a module's settings, as configured: frozen; unknown keys and numbers that are not finite are refused."""


@dataclass(frozen=True, slots=True)
class Caution:
    """A warning about a program's configuration: a ``title`` of a few words, and a ``text`` of one sentence with the
    reason and the remedy. ``where``: file and line, "" if unknown."""

    title: str
    text: str
    where: str = ""

    def __str__(self) -> str:
        return f"{self.where}: {self.text}" if self.where else self.text


class ModuleContext:
    """The state of a module that survives restarts: ports, clock, settings, services, its CPU meter and its worker."""

    def __init__(self, name: str, clock: Clock, settings: Settings, services: Mapping[type[Any], Any]) -> None:
        self.name = name
        self.clock = clock
        self.settings = settings
        self.services = services
        self.inputs: dict[str, Input[Any]] = {}
        self.outputs: dict[str, Output[Any]] = {}
        self.parameters: dict[str, Any] = {}
        #: Values that survive a restart; see :attr:`Module.persistent`.
        self.persistent: dict[str, Any] = {}
        #: The newest instance of the module.
        self.instance: Module | None = None
        self.meter = CpuMeter()
        self.worker = ModuleWorker(name)
        #: Runs ``compute_background``; its thread starts with the first call.
        self.background_worker = ModuleWorker(f"{name}, background")
        #: Counts calls in threads; one object for the whole graph.
        self.pending_work = PendingWork()
        #: Called with the port's name and each message whose handler has returned.
        self.handled: Callable[[str, Message], None] | None = None


class Module:
    """Base of all modules; see the top of this file, and docs/writing-a-module.md."""

    #: Name of the module on the page and in messages.
    title: ClassVar[str] = ""
    #: Column of the page's graph in which it stands; None: that of the package it is in (``perception``), or others.
    role: ClassVar[ModuleRole | None] = None
    #: Model that validates the settings.
    Settings: ClassVar[type[Settings]] = Settings
    #: Desire classes (:class:`app.attention.desires.DesireClass`) that this module serves or needs; a program has the
    #: union of its modules' classes. ``object``, for the type is above the runtime.
    desire_classes: ClassVar[tuple[object, ...]] = ()
    #: Stream of the body that each output relays; a replay feeds a recorded channel to the stream named here.
    streams: ClassVar[Mapping[str, str]] = {}
    #: Those of ``streams`` without which it runs all the same.
    optional_streams: ClassVar[frozenset[str]] = frozenset()
    #: Whether it may run on another computer (docs/nodes.md): all it knows comes by its inputs, it needs no service,
    #: and what it must keep is numbers in :attr:`persistent`, which it also reads there before it uses them.
    runs_elsewhere: ClassVar[bool] = False
    #: Inputs that improve the results of other inputs and are useless alone.
    auxiliary_inputs: ClassVar[frozenset[str]] = frozenset()

    @classmethod
    def default_inputs(cls, channels: Mapping[str, ChannelSpec]) -> Mapping[str, str]:
        """Channels by input port, for a module whose configuration names no inputs; ``channels`` is the whole table."""
        return {}

    def accept(self, name: str, message_type: type[Message]) -> None:
        """Declare an input that the configuration names and the constructor did not declare, for modules that accept
        any input.

        By default nothing is declared, and the graph refuses the input.
        """

    def __init__(self, context: ModuleContext) -> None:
        self._context = context
        self.name = context.name
        self.clock = context.clock
        #: The configured settings; a subclass with its own ``Settings`` annotates this with that class.
        self.settings: Settings = context.settings
        self.log = logging.getLogger(f"hbba.{context.name}")
        #: By periodic handler: time of its last call (robot's clock, s) and period (s). The supervisor detects hangs by
        #: it.
        self.ticks: dict[str, tuple[float, float]] = {}
        self._handlers: list[tuple[Input[Any], Callable[[Any], Awaitable[None] | None]]] = []
        self._timers: list[tuple[float, Callable[[], Awaitable[None] | None]]] = []
        self._failure: asyncio.Future[None] | None = None

        context.instance = self

    @property
    def persistent(self) -> dict[str, Any]:
        """Values that survive a restart of the module: the next instance reads them here.

        Meant for small values that must not repeat (the next number of a track) and for frozen values that cannot be
        computed again (a map that was not saved). A value that may itself have caused the failure is to be removed once
        it was read. The dictionary is empty at the beginning, and again after a reset of the program (a replay jumps).
        """
        return self._context.persistent

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
        wants: Wants = "always",
        rests: bool = False,
    ) -> Input[M]:
        """Declare an input port of ``message_type`` with an inbox of ``capacity`` messages.

        ``moves``: what comes in by it can move the body. The output of another module that leads to it stays closed
        unless a strategy names it. ``wants``: whether the source works for this input ``always``, ``if_wanted`` (only
        while an output of this module is wanted), or ``never``; what is published comes in at any rate.
        ``rests``: while attention has closed all filters that it controls of this module, the newest ``capacity``
        messages wait without waking it; they come first when one opens. For state that is needed only at work.
        """
        port = self._context.inputs.get(name)
        if port is None:
            port = Input(
                self.name,
                name,
                message_type=message_type,
                capacity=capacity,
                lossless=lossless,
                always_open=always_open,
                moves=moves,
                wants=wants,
                rests=rests,
            )
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

    def on(self, port: Input[M], handler: Callable[[M], Awaitable[None] | None]) -> None:
        """Have ``handler``, ``async`` or not, called with each message taken from ``port``, one at a time."""
        self._handlers.append((port, handler))

    def every(self, period_s: float, handler: Callable[[], Awaitable[None] | None]) -> None:
        """Have ``handler``, ``async`` or not, called every ``period_s`` seconds; beats missed meanwhile are skipped."""
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
        """Refuse a wiring with which the module must not run: called once, with all ports wired and before anything
        starts.

        Raises ModuleFailed with a sentence that gives a remedy.
        """

    def cautions(self) -> tuple[Caution, ...]:
        """Warnings about this module's configuration; called once, with all ports wired."""
        return ()

    async def start(self) -> None:
        """Set up what takes time or can fail; called before the first message."""

    async def stop(self) -> None:
        """Release the resources of ``start``; called once, however the module ended."""

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
        """Run CPU-bound ``function(*args)`` in this module's thread and charge its CPU time to this module.

        Calls run one at a time, in order. Raises what ``function`` raises.
        """
        loop = asyncio.get_running_loop()
        with self._context.pending_work.one():
            return await loop.run_in_executor(self._context.worker, self._context.meter.call, function, *args)

    async def compute_background(self, function: Callable[..., T], *args: Any) -> T:
        """As :meth:`compute`, in a second thread of this module: for long work that must delay no message.

        Data shared with :meth:`compute` must be safe for two threads. The thread has normal priority: with a lower one,
        a busy computer could suspend it while it holds the interpreter lock (GIL), and every other thread would wait.
        """
        loop = asyncio.get_running_loop()
        with self._context.pending_work.one():
            return await loop.run_in_executor(
                self._context.background_worker, self._context.meter.call, function, *args
            )

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

    async def _serve(self, port: Input[M], handler: Callable[[M], Awaitable[None] | None]) -> None:
        while True:
            try:
                message = await anext(port.subscription)
            except StopAsyncIteration:
                return
            except InboxOverflow as loss:
                self.overflowed(port.name, loss)
                continue
            if (handled := handler(message)) is not None:
                await handled
            if self._context.handled is not None:
                self._context.handled(port.name, message)
            if self._superseded:
                # It outlived its cancellation; what comes now is for its successor.
                return

    async def _repeat(self, key: str, period_s: float, handler: Callable[[], Awaitable[None] | None]) -> None:
        due = self.clock.now()
        while not self._superseded:
            self.ticks[key] = (self.clock.now(), period_s)
            if (handled := handler()) is not None:
                await handled
            due += period_s
            # A beat that comes late is made up for at once and leaves those after it where they are; of several that
            # were missed, the last one is.
            late = self.clock.now() - due
            due += max(late // period_s, 0.0) * period_s
            await self.clock.sleep_until(due)


async def _outcome(future: asyncio.Future[None]) -> None:
    await future
