"""Modules and channels built from configuration; every wiring error is found before anything starts."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Any, TypeVar

from pydantic import BaseModel, Field, ValidationError

from app.base.errors import ConfigError
from app.base.extensions import load_named, why_absent
from app.base.yaml_source import validation_message
from app.runtime.channel import Channel
from app.runtime.channel_table import ChannelSpec
from app.runtime.clock import Clock
from app.runtime.digraph import find_cycle
from app.runtime.errors import ModuleFailed
from app.runtime.filter import CLOSED
from app.runtime.filter_bank import FilterBank, unknown
from app.runtime.module import Module, ModuleContext, Settings
from app.runtime.pending_work import PendingWork
from app.runtime.ports import Input, Output

T = TypeVar("T")

#: Raises the error for a wiring mistake: (message, key path in the configuration).
WiringErrorFactory = Callable[[str, tuple[str, ...]], Exception]


class WiringError(Exception):
    """An invalid graph: the message names the module or channel, the mistake and what is allowed."""


def _plain_wiring_error(message: str, key: tuple[str, ...]) -> Exception:
    return WiringError(f"{'.'.join(key)}: {message}")


class ModuleSpec(BaseModel, frozen=True, extra="forbid"):
    """One module as configured; its name is its key in the file."""

    # `class` is what people write; it is a keyword here.
    class_path: str = Field(alias="class", description="package.module:Class")
    inputs: dict[str, str] = Field(default_factory=dict, description="input port: channel")
    outputs: dict[str, str] = Field(default_factory=dict, description="output port: channel")
    settings: dict[str, Any] = Field(default_factory=dict)
    hang_after_s: float = Field(1.0, gt=0, description="hung when it takes nothing for this long while messages wait")
    start_within_s: float = Field(30.0, gt=0, description="hung when it has not started after this long")
    cpu_budget: float | None = Field(None, gt=0, description="per cent of one core it is expected to stay under")
    stands_for: str | None = Field(
        None, description="a module before it, whose channels it publishes on as well: the same, on another computer"
    )


class ModuleSlot:
    """A module's place in the graph: its ports, filters, meter and worker outlive any instance of the module."""

    def __init__(self, name: str, module_class: type[Module], spec: ModuleSpec, context: ModuleContext) -> None:
        self.name = name
        self.module_class = module_class
        self.spec = spec
        self.context = context
        #: The instance at work, or the last one.
        self.module: Module = module_class(context)
        self._fresh = True

    @property
    def title(self) -> str:
        """The module's title, as the page shows it."""
        return self.module_class.title or self.name

    def renew(self) -> Module:
        """A fresh instance on the same ports, for a restart."""
        self.module = self.module_class(self.context)
        self._fresh = True
        return self.module

    def take(self) -> Module:
        """An instance that has not run yet: the one at hand, or a new one. Raises what its constructor raises."""
        module = self.module if self._fresh else self.renew()
        self._fresh = False
        return module

    def adopt_inputs(self) -> dict[str, int]:
        """Give the inboxes to a new instance; returns the number of messages that each lossless input lost meanwhile,
        if any."""
        lost = {name: port.subscription.adopt() for name, port in self.context.inputs.items() if port.connected}
        return {name: count for name, count in lost.items() if count}

    def leave_inputs(self) -> None:
        """Mark the consumer of all inboxes as down until the next instance adopts them."""
        for port in self.context.inputs.values():
            if port.connected:
                port.subscription.leave()

    def configure(self, parameters: Mapping[str, Any]) -> None:
        """Hand P' to the module if it runs, and remember it for its next start; unchanged ones are not handed again.

        Never raises: a module that cannot take its parameters fails, and is restarted, for itself.
        """
        if dict(parameters) != self.context.parameters:
            self.context.parameters = dict(parameters)
            self.module.reconfigure(self.context.parameters)


class Graph:
    """The wired program: ``modules`` by name, ``channels`` by name, and all their ``filters``."""

    def __init__(
        self,
        *,
        clock: Clock,
        channels: Mapping[str, ChannelSpec],
        modules: Mapping[str, ModuleSpec],
        services: Mapping[type[Any], Any],
        attended: Collection[str] = (),
        error: WiringErrorFactory = _plain_wiring_error,
    ) -> None:
        """Build and wire everything; nothing runs yet.

        ``attended`` names the filters (``Module.port``) that strategies control: these begin closed (φ = ∞, the
        thesis's default), all others begin open; see :meth:`attend`. ``error`` makes the exception for a wiring
        mistake.
        """
        self._error = error
        self.clock = clock
        self.pending_work = PendingWork()
        self.specs = dict(channels)
        self.channels: dict[str, Channel[Any]] = {}
        for name, channel_spec in channels.items():
            try:
                self.channels[name] = Channel(name, channel_spec.message_type, clock.now)
            except KeyError:
                raise error(channel_spec.no_message(), ("channels", name, "type")) from None
            except ConfigError as failure:
                raise error(failure.message, ("channels", name, "type")) from failure
        self.modules: dict[str, ModuleSlot] = {}
        for name, spec in modules.items():
            self.modules[name] = self._make_slot(name, spec, services)
        self.producers: dict[str, str] = {}
        #: By channel the outputs of those that stand for its producer.
        self.alternatives: dict[str, tuple[str, ...]] = {}
        self.filters = FilterBank()
        for slot in self.modules.values():
            self._wire_outputs(slot)
        for slot in self.modules.values():
            self._wire_inputs(slot)
        for slot in self.modules.values():
            _follow_demand(slot)
        self._refuse_cycles()
        self._refuse_motion_elsewhere()
        for name, slot in self.modules.items():
            try:
                slot.module.check_wiring()
            except ModuleFailed as failure:
                raise error(str(failure), ("modules", name, "inputs")) from None
        self.attend(attended)

    def attend(self, names: Collection[str]) -> None:
        """Hand the filters ``names`` (``Module.port``) over to attention: they close until an intention opens them.

        Raises the graph's wiring error for an input that must stay open.
        """
        for name in sorted(names):
            self._check_attended(name)
        for name in sorted(names):
            module, port_name = name.split(".", 1)
            slot = self.modules[module]
            output = slot.context.outputs.get(port_name)
            if output is not None and not slot.module.running:
                output.close_quietly()
        self.filters.apply(dict.fromkeys(names, CLOSED))
        resting = {
            name: [p.subscription for p in slot.context.inputs.values() if p.connected and p.rests]
            for name, slot in self.modules.items()
        }
        self.filters.attend(names, resting)

    def _check_attended(self, name: str) -> None:
        module, _, port_name = name.partition(".")
        slot = self.modules.get(module)
        if slot is None:
            raise self._error(unknown("module", module, self.modules), ("modules", module))
        if name not in self.filters.names():
            raise self._error(unknown("connected port", port_name, self.ports()[module]), ("modules", module))
        port = slot.context.inputs.get(port_name)
        if port is not None and port.channel is not None:
            key = ("modules", module, "inputs", port_name)
            if port.always_open:
                raise self._error("this input must stay open, no strategy may filter it", key)

    def ports(self) -> dict[str, set[str]]:
        """The filtered ports of each module: its outputs and its connected inputs."""
        return {
            name: {*slot.context.outputs, *(p.name for p in slot.context.inputs.values() if p.connected)}
            for name, slot in self.modules.items()
        }

    def inputs(self) -> dict[str, str]:
        """The channel of every connected input ``Module.port``."""
        return {
            f"{name}.{port.name}": port.channel.name
            for name, slot in self.modules.items()
            for port in slot.context.inputs.values()
            if port.channel is not None
        }

    def moving(self) -> dict[str, str]:
        """The outputs (``Module.port``) that can move the body, each with the input it leads to."""
        return {
            self.producers[port.channel.name]: f"{name}.{port.name}"
            for name, slot in self.modules.items()
            for port in slot.context.inputs.values()
            if port.moves and port.channel is not None and port.channel.name in self.producers
        }

    def producer_at_work(self, channel: str) -> str:
        """The output that publishes on ``channel`` now: of those that stand for the producer the first that is fed,
        unless the producer itself is. Raises KeyError for a channel without a producer."""
        candidates = (self.producers[channel], *self.alternatives.get(channel, ()))
        return (
            next((name for name in candidates if self._fed(name)), candidates[0]) if candidates[1:] else candidates[0]
        )

    def _fed(self, output: str) -> bool:
        context = self.modules[output.partition(".")[0]].context
        return any(
            not port.always_open and port.subscription.filter.is_open and self.specs[port.channel.name].decimable
            for port in context.inputs.values()
            if port.channel is not None
        )

    def configure(self, module: str, parameters: Mapping[str, Any]) -> None:
        """Hand the intention's parameters to ``module``. Raises KeyError for one that is not in the graph."""
        self.modules[module].configure(parameters)

    def reset(self) -> None:
        """Forget every message: what waits in inboxes, each channel's latest, how far each filter has counted; and
        what modules kept for their next instance."""
        for channel in self.channels.values():
            channel.clear()
        for slot in self.modules.values():
            slot.context.persistent.clear()
        self.filters.reset()

    def channel(self, name: str) -> Channel[Any]:
        """A channel by name. Raises KeyError naming those there are."""
        try:
            return self.channels[name]
        except KeyError:
            raise KeyError(f"no channel {name!r}; there are: {', '.join(sorted(self.channels))}") from None

    def _make_slot(self, name: str, spec: ModuleSpec, services: Mapping[type[Any], Any]) -> ModuleSlot:
        key = ("modules", name)
        try:
            module_class = load_class(spec.class_path)
        except ConfigError as failure:
            raise self._error(failure.message, (*key, "class")) from failure
        if module_class is None:
            absent = why_absent(spec.class_path)
            why = "" if absent is None else f": {absent}"
            raise self._error(f"{spec.class_path!r} is not a module class (package.module:Class){why}", (*key, "class"))
        try:
            settings: Settings = module_class.Settings.model_validate(spec.settings)
        except ValidationError as failure:
            detail = failure.errors(include_url=False)[0]
            where = (str(part) for part in detail["loc"] if part != "[key]")
            raise self._error(validation_message(module_class.Settings, detail), (*key, "settings", *where)) from None
        try:
            context = ModuleContext(name, self.clock, settings, services)
            context.pending_work = self.pending_work
            if spec.stands_for is not None:
                context.persistent = self._known(
                    self.modules, "module", spec.stands_for, (*key, "stands_for")
                ).context.persistent
            return ModuleSlot(name, module_class, spec, context)
        except ModuleFailed as failure:
            raise self._error(str(failure), key) from None

    def _wire_outputs(self, slot: ModuleSlot) -> None:
        for port_name, channel_name in slot.spec.outputs.items():
            key = ("modules", slot.name, "outputs", port_name)
            port = self._known(slot.context.outputs, "output", port_name, key)
            channel = self._channel_for(port, channel_name, key)
            if channel_name in self.producers:
                other = self.producers[channel_name]
                if other != f"{slot.spec.stands_for}.{port_name}":
                    raise self._error(f"channel {channel_name} already has a producer, {other}", key)
                others = self.alternatives.get(channel_name, ())
                self.alternatives[channel_name] = (*others, f"{slot.name}.{port_name}")
            else:
                self.producers[channel_name] = f"{slot.name}.{port_name}"
            port.connect(channel)
        for port_name, port in slot.context.outputs.items():
            decimable = port.channel is None or self.specs[port.channel.name].decimable
            self.filters.add(f"{slot.name}.{port_name}", port.filter, decimable=decimable)

    def _wire_inputs(self, slot: ModuleSlot) -> None:
        inputs = slot.spec.inputs or {
            port: channel
            for port, channel in slot.module_class.default_inputs(self.specs).items()
            if channel in self.producers or self.specs[channel].external
        }
        for port_name, channel_name in inputs.items():
            key = ("modules", slot.name, "inputs", port_name)
            if port_name not in slot.context.inputs and channel_name in self.channels:
                slot.module.accept(port_name, self.channels[channel_name].message_type)
            port = self._known(slot.context.inputs, "input", port_name, key)
            channel = self._channel_for(port, channel_name, key)
            if channel_name not in self.producers and not self.specs[channel_name].external:
                raise self._error(f"no module publishes on channel {channel_name}", key)
            # A channel from outside has no source here that could rest: a log feeds only what is wanted.
            outside = channel_name not in self.producers
            port.connect(channel, 1, demands=port.wants == "always" or (port.wants == "never" and outside))
            decimable = self.specs[channel_name].decimable
            self.filters.add(f"{slot.name}.{port_name}", port.subscription.filter, decimable=decimable)

    def _known(self, known: Mapping[str, T], kind: str, name: str, key: tuple[str, ...]) -> T:
        if name not in known:
            raise self._error(unknown(kind, name, known), key)
        return known[name]

    def _channel_for(self, port: Input[Any] | Output[Any], name: str, key: tuple[str, ...]) -> Channel[Any]:
        channel = self._known(self.channels, "channel", name, key)
        if channel.message_type is not port.message_type:
            kind, wanted = channel.message_type.__name__, port.message_type.__name__
            raise self._error(f"channel {name} carries {kind}, the port wants {wanted}", key)
        return channel

    def _refuse_motion_elsewhere(self) -> None:
        for output, moved in self.moving().items():
            module, _, port = output.partition(".")
            channel = self.modules[module].context.outputs[port].channel
            if channel is not None and channel.name in self.alternatives:
                other = self.alternatives[channel.name][0].partition(".")[0]
                raise self._error(
                    f"{output} leads to {moved} and can move the robot: nothing elsewhere may stand for it",
                    ("modules", other),
                )

    def _refuse_cycles(self) -> None:
        followers: dict[str, set[str]] = {name: set() for name in self.modules}
        for name, slot in self.modules.items():
            for channel_name in slot.spec.inputs.values():
                producer = self.producers.get(channel_name)
                if producer is not None and not self.specs[channel_name].feedback:
                    followers[producer.split(".")[0]].add(name)
        if cycle := find_cycle(followers):
            path = " -> ".join(cycle)
            raise self._error(
                f"modules feed each other in a circle: {path}; mark one of its channels `feedback: true` if meant",
                ("modules", cycle[0]),
            )


def _follow_demand(slot: ModuleSlot) -> None:
    """Have the inputs of ``slot`` that are declared so want their channels while one of its outputs is wanted."""
    inputs = [port for port in slot.context.inputs.values() if port.connected and port.wants == "if_wanted"]
    outputs = [port.channel for port in slot.context.outputs.values() if port.channel is not None]

    def follow(_: bool) -> None:
        wanted = any(channel.wanted for channel in outputs)
        for port in inputs:
            port.subscription.demand(wanted)

    for channel in outputs if inputs else ():
        channel.on_wanted(follow)


def load_class(path: str) -> type[Module] | None:
    """The module class at ``package.module:Class``, or None if there is none.

    Raises ConfigError where its file cannot be imported.
    """
    found = load_named(path)
    return found if isinstance(found, type) and issubclass(found, Module) else None
