"""The nodes of a program: stand-ins at home, strategies elsewhere, and what attention knows of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

from app.attention.strategies import StrategyTable
from app.base.errors import ConfigError
from app.messages import Audio, Image
from app.program.config import Configuration
from app.remote.contract import Described, NotElsewhere, describe
from app.remote.hub import NodeHub, stand_in_name
from app.remote.settings import NodeSettings
from app.remote.strategies import (
    JPEG_BYTES,
    OTHER_BYTES,
    RAW_BYTES,
    SOUND_BYTES,
    Elsewhere,
    Stream,
    differs,
    strategies_of,
    with_nodes,
)
from app.runtime.channel_table import ChannelSpec
from app.runtime.clock import Clock


class ProgramNodes:
    """The nodes that a configuration declares: its ``configuration`` with the modules that stand for those there, and
    the ``hub`` that they join."""

    def __init__(self, configuration: Configuration, clock: Clock) -> None:
        """Raises ConfigError for a module that cannot run elsewhere."""
        settings = configuration.program.nodes
        assert settings is not None
        for name, node in settings.computers.items():
            described_modules(configuration, name, node)
        self.hub = NodeHub(settings, configuration.program.modules, clock, configuration.folder)
        modules = {**configuration.program.modules, **self.hub.stand_ins()}
        self._home = StrategyTable((), {})
        self._elsewhere: dict[str, Elsewhere] = {}
        self.configuration = replace(
            configuration, program=configuration.program.model_copy(update={"modules": modules})
        )

    def extend(self, table: StrategyTable) -> StrategyTable:
        """``table`` with the strategies of all nodes. Raises ConfigError for a module that none of them opens."""
        program, document = self.configuration.program, self.configuration.program_document
        self._home = table
        self._elsewhere = {
            name: Elsewhere(name, link.settings, streams_of(self.configuration, link.settings))
            for name, link in self.hub.links.items()
        }
        extended = with_nodes(table, list(self._elsewhere.values()))
        assert program.nodes is not None
        for name, node in program.nodes.computers.items():
            for number, module in enumerate(node.modules):
                opened = f"{stand_in_name(module, name)}."
                if not any(each.startswith(opened) for each in extended.filters):
                    raise document.error(
                        f"no strategy has filters of {module} alone, so that none could choose it on {name}",
                        ("nodes", "computers", name, "modules", number),
                    )
        return extended

    def measured(self) -> dict[str, dict[str, float]]:
        """New costs of the strategies of those nodes whose messages differ in size from what was reckoned with."""
        costs: dict[str, dict[str, float]] = {}
        for name, node in self._elsewhere.items():
            sizes = self.hub.link(name).sizes
            streams = {
                port: replace(stream, size=sizes[port]) if differs(sizes.get(port), stream.size) else stream
                for port, stream in node.streams.items()
            }
            if streams != node.streams:
                self._elsewhere[name] = replace(node, streams=streams)
                costs |= {s.name: dict(s.costs) for s in strategies_of(self._home, self._elsewhere[name])}
        return costs

    def observe(self, set_capacity: Callable[[str, float, str], None]) -> Callable[[], None]:
        """Give each node's CPU to attention while it may be used, and nothing otherwise, with the reason."""

        def change(node: str, usable: bool, why: str) -> None:
            cpu = self.hub.link(node).settings.cpu
            set_capacity(f"cpu@{node}", cpu if usable else 0.0, why or f"{node} is well")

        return self.hub.observe(change)


def streams_of(configuration: Configuration, node: NodeSettings) -> dict[str, Stream]:
    """What comes to the inputs of the modules that ``node`` may run, by ``Module.port``, at sizes not measured yet."""
    channels, modules = configuration.channels, configuration.program.modules
    return {
        f"{module}.{port}": _stream(channels[channel], node)
        for module in node.modules
        for port, channel in modules[module].inputs.items()
    }


def described_modules(configuration: Configuration, name: str, node: NodeSettings) -> Mapping[str, Described]:
    """The modules that the computer ``name`` may run. Raises ConfigError, with the line that names a wrong one."""
    found = {}
    for number, module in enumerate(node.modules):
        where = ("nodes", "computers", name, "modules", number)
        spec = configuration.program.modules.get(module)
        if spec is None:
            raise configuration.program_document.error(f"there is no module {module!r} in this program", where)
        try:
            found[module] = describe(module, spec)
        except NotElsewhere as failure:
            raise configuration.program_document.error(str(failure), where) from None
    return found


def node_of(configuration: Configuration, name: str | None) -> tuple[str, NodeSettings]:
    """The computer called ``name`` (None: the only one). Raises ConfigError where the program has no such node."""
    nodes = configuration.program.nodes
    if nodes is None:
        raise ConfigError("this program declares no other computers: `nodes`", configuration.program_document.file)
    names = ", ".join(nodes.computers)
    if name is None:
        if len(nodes.computers) > 1:
            raise ConfigError(f"which of the program's computers this is: {names}", "--name")
        name = next(iter(nodes.computers))
    if name not in nodes.computers:
        raise ConfigError(f"this program has no computer {name!r}; there is: {names}", "--name")
    return name, nodes.computers[name]


def _stream(channel: ChannelSpec, node: NodeSettings) -> Stream:
    image = channel.message_type is Image
    if image:
        size = JPEG_BYTES if node.images == "jpeg" else RAW_BYTES
    else:
        size = SOUND_BYTES if channel.message_type is Audio else OTHER_BYTES
    return Stream(channel.rate_hz or 0.0, size, image)
