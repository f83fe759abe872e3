"""What a module is: typed ports, handlers, and a life cycle that the supervisor drives.

A module declares its ports and handlers in its constructor and does nothing else there; heavy set-up belongs in
``start``. A fresh instance is made for every (re)start, on the same ports: subscriptions, filters and counters
outlive a crash.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable, Coroutine, Mapping
from typing import Any, ClassVar, Generic, TypeVar

from pydantic import BaseModel, ConfigDict

from app.messages import Message
from app.runtime.channel import Channel, Subscription
from app.runtime.clock import Clock
from app.runtime.errors import ModuleFailed
from app.runtime.filter import CLOSED, RateFilter
from app.runtime.load import CpuMeter, MeteredCoroutine
from app.runtime.worker import ModuleWorker

M = TypeVar("M", bound=Message)
T = TypeVar("T")
ServiceT = TypeVar("ServiceT")


class Settings(BaseModel):
    """Base of a module's settings, as they stand in configuration: frozen, and unknown keys are refused."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class Input(Generic[M]):
    """An input port. Once wired, ``subscription`` is the module's end of a channel.

    ``always_open`` inputs are not attention's to decimate: safety and self-motion, where a gap is a fault.
    """

    def __init__(
        self, module: str, name: str, message_type: type[M], capacity: int, lossless: bool, always_open: bool
    ) -> None:
        self.module = module
        self.name = name
        self.message_type = message_type
        self.capacity = capacity
        self.lossless = lossless
        self.always_open = always_open
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

    def connect(self, channel: Channel[M], divisor: float) -> None:
        """Subscribe this port to ``channel`` (done once, by the graph)."""
        self.channel = channel
        self._subscription = channel.subscribe(
            f"{self.module}.{self.name}", capacity=self.capacity, lossless=self.lossless, divisor=divisor
        )


class Output(Generic[M]):
    """An output port: publishes on its channel what its own filter lets through.

    When the filter closes, the module's last word for this port (a stop, say) is published once, unfiltered.
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

    def publish(self, message: M) -> None:
        """Publish ``message`` if the filter lets it pass; an unwired output swallows it."""
        self.offered += 1
        if self.filter.offer() and self.channel is not None:
            self.channel.publish(message)

    @property
    def wanted(self) -> bool:
        """Whether publishing would reach anyone: a module may save itself the work otherwise."""
        return self.channel is not None and self.channel.wanted and self.filter.is_open

    def _filter_changed(self, _before: float, after: float) -> None:
        if after == CLOSED and self.channel is not None and self.last_word is not None:
            message = self.last_word()
            if message is not None:
                self.channel.publish(message)


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
        self.meter = CpuMeter()
        self.worker = ModuleWorker(name)
        #: When a periodic handler last came round, by handler name, with its period: for telling a hung module.
        self.ticks: dict[str, tuple[float, float]] = {}


class Module:
    """Base of all modules; see the top of this file, and docs/writing-a-module.md."""

    #: What people call it.
    title: ClassVar[str] = ""
    #: The model its settings are checked against.
    Settings: ClassVar[type[Settings]] = Settings

    def __init__(self, context: ModuleContext) -> None:
        self._context = context
        self.name = context.name
        self.clock = context.clock
        self.log = logging.getLogger(f"hbba.{context.name}")
        self._handlers: list[tuple[Input[Any], Callable[[Any], Awaitable[None]]]] = []
        self._timers: list[tuple[float, Callable[[], Awaitable[None]]]] = []

    # --- declaring ---

    def input(
        self,
        name: str,
        message_type: type[M],
        *,
        capacity: int = 1,
        lossless: bool = False,
        always_open: bool = False,
    ) -> Input[M]:
        """Declare an input port of ``message_type`` with an inbox of ``capacity`` messages."""
        port = self._context.inputs.get(name)
        if port is None:
            port = Input(self.name, name, message_type, capacity, lossless, always_open)
            self._context.inputs[name] = port
        return port

    def output(self, name: str, message_type: type[M]) -> Output[M]:
        """Declare an output port of ``message_type``."""
        port = self._context.outputs.get(name)
        if port is None:
            port = Output(self.name, name, message_type)
            self._context.outputs[name] = port
        port.last_word = lambda: self.last_word(name)
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

    async def start(self) -> None:
        """Set up what takes time or can fail; called before the first message."""

    async def stop(self) -> None:
        """Release what ``start`` took; called once, whatever ended the module."""

    def configure(self, parameters: Mapping[str, Any]) -> None:
        """Take over the intention's parameters for this module (P'); called on the loop, again after a restart."""

    def last_word(self, port: str) -> Any:
        """The message to publish once when attention closes output ``port``, or None."""
        return None

    # --- working ---

    async def compute(self, function: Callable[..., T], *args: Any) -> T:
        """Run CPU-bound ``function(*args)`` in this module's thread, charging its CPU time to this module."""
        loop = asyncio.get_running_loop()
        return await loop.run_in_executor(self._context.worker, self._context.meter.call, function, *args)

    async def run(self) -> None:
        """Live: start, serve every input and timer until cancelled or until one of them raises, stop."""
        try:
            # Inside the try: a start that fails half-way still has its stop.
            await self.start()
            self.configure(self._context.parameters)
            async with asyncio.TaskGroup() as group:
                for port, handler in self._handlers:
                    if port.connected:
                        group.create_task(self._metered(self._serve(port, handler)), name=f"{self.name}.{port.name}")
                for number, (period_s, beat) in enumerate(self._timers):
                    key = f"{getattr(beat, '__name__', 'timer')}-{number}"
                    group.create_task(self._metered(self._repeat(key, period_s, beat)), name=f"{self.name}.{key}")
                group.create_task(asyncio.Event().wait(), name=f"{self.name}.alive")
        finally:
            self._context.ticks.clear()
            await self.stop()

    def _metered(self, coroutine: Coroutine[Any, Any, T]) -> Coroutine[Any, Any, T]:
        return MeteredCoroutine(coroutine, self._context.meter)

    async def _serve(self, port: Input[M], handler: Callable[[M], Awaitable[None]]) -> None:
        async for message in port.subscription:
            await handler(message)

    async def _repeat(self, key: str, period_s: float, handler: Callable[[], Awaitable[None]]) -> None:
        due = self.clock.now()
        while True:
            self._context.ticks[key] = (self.clock.now(), period_s)
            await handler()
            due = max(due + period_s, self.clock.now())
            await self.clock.sleep_until(due)
