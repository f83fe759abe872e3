"""Strategies and resources (thesis 4.2.5, tables 4.2 and 4.4); ``strategy_file`` reads them.

A strategy serves one desire class: it produces a utility, sets filters and parameters, may require other classes, and
costs resources. Strategies of one class that set the same filter exclude each other without saying so. Where selected
strategies of *different* classes set the same filter, the smallest divisor wins: every one of them receives at least
what it needs, and no desire is dropped for it.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Any

from app.attention.desires import GRAIN

CLOSED = math.inf
"""φ of a closed filter."""

MOST = 1e9
"""No capacity and no cost may be greater: sums of thousandths stay exact."""


@dataclass(frozen=True, slots=True)
class Location:
    """Position of a declaration: ``file`` as given by the user, ``line`` from 1."""

    file: str
    line: int

    def __str__(self) -> str:
        return f"{self.file}:{self.line}"


@dataclass(frozen=True, slots=True)
class Resource:
    """A shared resource: ``capacity`` and costs are in ``unit``; capacity 1 with costs of 1 excludes mutually."""

    name: str
    capacity: float
    unit: str = ""
    description: str = ""


@dataclass(frozen=True, slots=True)
class Strategy:
    """One way to serve a desire class.

    ``utility`` is the produced utility v in ]0, 8]. ``requires`` maps a class to the utility l that this strategy needs
    of it. ``filters`` maps ``"Module.port"`` to its divisor φ: an integer from 1, or ``math.inf`` for closed.
    ``parameters`` maps a module to its parameters while the strategy is selected. ``costs`` maps a resource to the
    amount used.
    """

    name: str
    cls: str
    utility: float
    requires: Mapping[str, float] = field(default_factory=dict)
    filters: Mapping[str, float] = field(default_factory=dict)
    parameters: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    costs: Mapping[str, float] = field(default_factory=dict)
    location: Location | None = None

    @property
    def modules(self) -> tuple[str, ...]:
        """The modules this strategy concerns: those of its filters and of its parameters, sorted."""
        return tuple(sorted({name.partition(".")[0] for name in self.filters} | set(self.parameters)))


@dataclass(frozen=True, slots=True)
class StrategyTable:
    """The strategies in the order that breaks the last ties, and the resources by name."""

    strategies: tuple[Strategy, ...]
    resources: Mapping[str, Resource]

    def __getitem__(self, name: str) -> Strategy:
        """The strategy of this name; raises KeyError."""
        for strategy in self.strategies:
            if strategy.name == name:
                return strategy
        raise KeyError(name)

    @property
    def classes(self) -> tuple[str, ...]:
        """The classes that some strategy serves, in table order."""
        return tuple(dict.fromkeys(strategy.cls for strategy in self.strategies))

    @property
    def filters(self) -> frozenset[str]:
        """Every filter that some strategy sets, ``"Module.port"``."""
        return frozenset(name for strategy in self.strategies for name in strategy.filters)

    def with_costs(self, costs: Mapping[str, Mapping[str, float]]) -> StrategyTable:
        """The same table with other costs of the strategies named. Raises ValueError for a strategy or a resource that
        there is not."""
        unknown = sorted(costs.keys() - {strategy.name for strategy in self.strategies})
        unknown += sorted({name for each in costs.values() for name in each} - self.resources.keys())
        if unknown:
            raise ValueError(f"costs of what does not exist: {', '.join(unknown)}")
        strategies = (replace(s, costs=dict(costs[s.name])) if s.name in costs else s for s in self.strategies)
        return replace(self, strategies=tuple(strategies))

    def with_utilities(self, declared: Mapping[str, float], factors: Mapping[str, float]) -> StrategyTable:
        """The same table with the utilities ``declared``, by strategy, times ``factors`` (over 0, at most 1; 1 where
        there is none), at least a thousandth. Raises ValueError for a strategy that there is not, or another factor."""
        unknown = sorted(factors.keys() - {strategy.name for strategy in self.strategies})
        if unknown:
            raise ValueError(f"utilities of what does not exist: {', '.join(unknown)}")
        wrong = sorted(name for name, factor in factors.items() if not 0 < factor <= 1)
        if wrong:
            raise ValueError(f"a strategy produces over 0 and at most 1 of its utility: {', '.join(wrong)}")
        strategies = (
            replace(s, utility=max(1, math.floor(declared[s.name] * factors.get(s.name, 1.0) * GRAIN + 1e-6)) / GRAIN)
            for s in self.strategies
        )
        return replace(self, strategies=tuple(strategies))

    def changed(self, strategies: Iterable[Strategy]) -> tuple[Strategy, ...]:
        """Those of ``strategies`` (of the same names, in the same order) that cost or produce otherwise than here."""
        pairs = zip(self.strategies, strategies, strict=True)
        return tuple(s for mine, s in pairs if s is not mine and (s.costs != mine.costs or s.utility != mine.utility))

    def capacities(self) -> dict[str, float]:
        """The declared capacity of each resource."""
        return {name: resource.capacity for name, resource in self.resources.items()}


def exclusive(one: Strategy, other: Strategy) -> bool:
    """Whether two strategies can never be selected together: same class and a filter in common."""
    return one.cls == other.cls and not one.filters.keys().isdisjoint(other.filters.keys())


def trimmed(table: StrategyTable, ports: Mapping[str, Collection[str]]) -> StrategyTable:
    """The table for a program that has only the modules in ``ports`` (with these ports).

    Strategies lose filters and parameters of missing modules; a strategy that had filters and lost them all is left
    out. Strategies that excluded each other by a filter that is gone still do: by a resource of its own with capacity
    1.
    """

    def there(name: str) -> bool:
        module, _, port = name.partition(".")
        return port in ports.get(module, ())

    kept: dict[str, Strategy] = {}
    for strategy in table.strategies:
        filters = {name: divisor for name, divisor in strategy.filters.items() if there(name)}
        parameters = {module: values for module, values in strategy.parameters.items() if module in ports}
        if filters or not strategy.filters:
            kept[strategy.name] = replace(strategy, filters=filters, parameters=parameters)
    resources = dict(table.resources)
    for one, other in combinations([s for s in table.strategies if s.name in kept], 2):
        if exclusive(one, other) and not exclusive(kept[one.name], kept[other.name]):
            name = f"{one.cls} by {min(one.filters.keys() & other.filters.keys())}"
            resources.setdefault(name, Resource(name, 1, description=f"One way at a time to serve {one.cls}"))
            for strategy in (kept[one.name], kept[other.name]):
                kept[strategy.name] = replace(strategy, costs={**strategy.costs, name: 1})
    return StrategyTable(tuple(kept.values()), resources)
