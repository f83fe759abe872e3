"""What robot and node must agree on before anything is sent: version, classes, settings, the shapes of messages.

Both make it of the same classes and configuration, each of its own copy; a difference is refused in words.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError

from app.remote.codec import difference, shape_of, travels
from app.remote.wire import ModuleOffer, Offer, PortShape
from app.runtime.clock import RealClock
from app.runtime.errors import ModuleFailed
from app.runtime.graph import ModuleSpec, load_class
from app.runtime.module import Input, Module, ModuleContext, Output


class NotElsewhere(ValueError):
    """A module that cannot run on another computer; the message is a sentence for people."""


@dataclass(frozen=True, slots=True)
class Described:
    """A module's class as configured: its connected ports, by name."""

    name: str
    module_class: type[Module]
    spec: ModuleSpec
    inputs: Mapping[str, Input[Any]]
    outputs: Mapping[str, Output[Any]]

    def offer(self) -> ModuleOffer:
        """What the other end must have as well."""
        settings = self.module_class.Settings.model_validate(self.spec.settings)
        return ModuleOffer(
            self.spec.class_path,
            settings.model_dump(mode="json"),
            {name: _shape(port) for name, port in self.inputs.items()},
            {name: _shape(port) for name, port in self.outputs.items()},
        )


def describe(name: str, spec: ModuleSpec) -> Described:
    """The ports of a module that may run elsewhere. Raises NotElsewhere; ConfigError where its file cannot be
    imported."""
    module_class = load_class(spec.class_path)
    if module_class is None:
        raise NotElsewhere(f"{spec.class_path!r} is not a module class (package.module:Class)")
    if not module_class.runs_elsewhere:
        raise NotElsewhere(f"{name} can run on the robot's own computer alone: its class does not say `runs_elsewhere`")
    try:
        settings = module_class.Settings.model_validate(spec.settings)
        # Its constructor declares ports and does nothing else.
        context = ModuleContext(name, RealClock(), settings, {})
        module_class(context)
    except (ModuleFailed, ValidationError) as failure:
        raise NotElsewhere(f"{name} cannot run elsewhere: {failure}") from None
    unknown = [port for port in spec.inputs if port not in context.inputs]
    unknown += [port for port in spec.outputs if port not in context.outputs]
    if unknown:
        raise NotElsewhere(f"{name} has no port {unknown[0]!r}")
    inputs = {port: context.inputs[port] for port in spec.inputs}
    outputs = {port: context.outputs[port] for port in spec.outputs}
    types = {port: end.message_type for port, end in inputs.items()}
    for port, kind in (types | {port: end.message_type for port, end in outputs.items()}).items():
        if why := travels(kind):
            raise NotElsewhere(f"{name}.{port} cannot go over the network: {why}")
    for port, end in inputs.items():
        if end.moves:
            raise NotElsewhere(f"what comes to {name}.{port} moves the robot: it stays there")
    return Described(name, module_class, spec, inputs, outputs)


def refusal(robot: Mapping[str, ModuleOffer], version: str, offer: Offer) -> str:
    """Why ``offer`` cannot be accepted by a robot of ``version`` whose modules for that node are ``robot``; "" if it
    can."""
    if offer.version != version:
        return f"the robot runs version {version}, {offer.node} runs {offer.version}: install the same"
    for name, there in offer.modules.items():
        here = robot.get(name)
        if here is None:
            allowed = ", ".join(sorted(robot))
            return f"{name} is not among what the robot lets {offer.node} run; there is: {allowed}"
        if there.class_path != here.class_path:
            return f"{name} is {here.class_path} on the robot, and {there.class_path} on {offer.node}"
        if there.settings != here.settings:
            return f"{name} has other settings on {offer.node}: {_settings(here.settings, there.settings)}"
        for kind, mine, theirs in (("input", here.inputs, there.inputs), ("output", here.outputs, there.outputs)):
            for port in sorted({*mine, *theirs}):
                if port not in mine or port not in theirs:
                    where = "the robot" if port in mine else offer.node
                    return f"{kind} {port} of {name} is connected on {where} alone"
                if words := _differ(mine[port], theirs[port]):
                    return f"messages of {name}.{port} differ, seen from the robot: {words}"
    missing = sorted(set(robot) - set(offer.modules))
    return f"{offer.node} does not offer {missing[0]}, which the robot's configuration lets it run" if missing else ""


def _differ(here: PortShape, there: PortShape) -> str:
    if here.message != there.message:
        return f"{here.message} here and {there.message} there"
    return difference(here.fields, there.fields)


def _settings(here: Mapping[str, Any], there: Mapping[str, Any]) -> str:
    name = next(key for key in sorted({*here, *there}) if here.get(key) != there.get(key))
    return f"{name} is {here.get(name)!r} on the robot and {there.get(name)!r} there"


def _shape(port: Input[Any] | Output[Any]) -> PortShape:
    return PortShape(port.message_type.__name__, shape_of(port.message_type))
