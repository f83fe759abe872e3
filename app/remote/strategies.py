"""Strategies for modules on other computers, made from those at home: the solver chooses where (thesis 4.5).

``locate-faces-1@desk`` is ``locate-faces-1`` with the filters of ``FaceDetector@desk`` instead of ``FaceDetector``'s,
which it closes, so that both are never selected together. It costs the other computer's CPU and bandwidth of the link
(bytes of a message × rate ÷ φ), and at home what it takes to send.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from app.attention.calibration import RESOURCE as CPU
from app.attention.desires import GRAIN
from app.attention.strategies import CLOSED, Resource, Strategy, StrategyTable
from app.remote.settings import NodeSettings

#: Until messages were measured: bytes of an image, with its depth, as JPEG and raw; of a frame of sound; of all else.
JPEG_BYTES, RAW_BYTES, SOUND_BYTES, OTHER_BYTES = 200e3, 1_200e3, 8.5e3, 200.0
#: CPU time (s) of an image at home, to encode and send it.
IMAGE_CPU_S = 0.006


#: Sizes of messages that differ by less than this share are taken for the same: each change is a new problem to solve.
SAME = 0.25


@dataclass(frozen=True, slots=True)
class Stream:
    """What comes to an input at home: nominal ``rate_hz``, bytes of a message on the link, and whether it is encoded
    as an image."""

    rate_hz: float
    size: float
    image: bool


@dataclass(frozen=True, slots=True)
class Elsewhere:
    """A node as attention sees it. ``streams``: of each input ``Module.port`` of its modules."""

    name: str
    settings: NodeSettings
    streams: Mapping[str, Stream]

    @property
    def cpu(self) -> str:
        """The resource of its CPU."""
        return f"{CPU}@{self.name}"

    @property
    def bandwidth(self) -> str:
        """The resource of the link to it."""
        return f"bandwidth@{self.name}"


def with_nodes(table: StrategyTable, nodes: list[Elsewhere]) -> StrategyTable:
    """``table`` with the strategies of each node after all those at home, and its resources."""
    resources = dict(table.resources)
    strategies = list(table.strategies)
    for node in nodes:
        resources[node.cpu] = Resource(node.cpu, node.settings.cpu, "% of one core", f"CPU of modules on {node.name}")
        resources[node.bandwidth] = Resource(
            node.bandwidth, node.settings.bandwidth, "MB/s", f"What is sent to modules on {node.name}"
        )
        strategies += strategies_of(table, node)
    return StrategyTable(tuple(strategies), resources)


def strategies_of(table: StrategyTable, node: Elsewhere) -> Iterator[Strategy]:
    """The strategies of ``table`` whose filters are all of modules that ``node`` may run, as they are there."""
    for strategy in table.strategies:
        modules = {name.partition(".")[0] for name in strategy.filters}
        if modules and modules <= set(node.settings.modules):
            yield _moved(strategy, node)


def differs(measured: float | None, reckoned: float) -> bool:
    """Whether the ``measured`` size of a message (None: there was none) is another than the ``reckoned`` one."""
    return measured is not None and not (1 - SAME) * reckoned <= measured <= (1 + SAME) * reckoned


def _moved(strategy: Strategy, node: Elsewhere) -> Strategy:
    filters = {}
    for name, divisor in strategy.filters.items():
        module, _, port = name.partition(".")
        filters[f"{module}@{node.name}.{port}"] = divisor
        filters[name] = CLOSED
    parameters = {
        f"{module}@{node.name}" if module in node.settings.modules else module: values
        for module, values in strategy.parameters.items()
    }
    return replace(
        strategy,
        name=f"{strategy.name}@{node.name}",
        filters=filters,
        parameters=parameters,
        costs=_costs(strategy, node),
    )


def _costs(strategy: Strategy, node: Elsewhere) -> dict[str, float]:
    modules = {name.partition(".")[0] for name in strategy.filters}
    sent_bps = encoding = 0.0
    for name, stream in node.streams.items():
        if name.partition(".")[0] not in modules:
            continue
        divisor = strategy.filters.get(name, 1.0)
        rate_hz = 0.0 if divisor == CLOSED else stream.rate_hz / divisor
        sent_bps += rate_hz * stream.size
        encoding += 100 * IMAGE_CPU_S * rate_hz * stream.image
    costs = dict(strategy.costs)
    there = costs.pop(CPU, 0.0) / node.settings.speed
    costs[CPU] = _grained(encoding)
    # Never free: without CPU there, as when it is lost, nothing of it can be selected.
    costs[node.cpu] = max(_grained(there), 1 / GRAIN)
    costs[node.bandwidth] = _grained(1e-6 * sent_bps)
    return {name: cost for name, cost in costs.items() if cost}


def _grained(value: float) -> float:
    """Rounded up to what the solver counts in."""
    return math.ceil(value * GRAIN - 1e-6) / GRAIN
