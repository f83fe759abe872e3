"""Graphs of small modules, built as from configuration, for the tests of the runtime."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import pytest

from app.messages import Twist
from app.runtime.channel_table import ChannelSpec
from app.runtime.clock import VirtualClock
from app.runtime.graph import Graph, ModuleSpec
from app.runtime.module import Module

GraphBuilder = Callable[..., Graph]


def number(value: int, stamp: float = 0.0) -> Twist:
    """A small message that carries a number."""
    return Twist(stamp, float(value), 0.0)


def class_path(module_class: type[Module]) -> str:
    """How configuration would name a class."""
    return f"{module_class.__module__}:{module_class.__qualname__}"


@pytest.fixture
def build() -> GraphBuilder:
    """Build a graph: ``modules`` maps a name to (class, inputs, outputs, further keys); channels default to Twist."""

    def build_graph(
        modules: Mapping[str, tuple[Any, ...]],
        channels: Mapping[str, Mapping[str, Any]],
        *,
        services: Mapping[type[Any], Any] | None = None,
        attended: tuple[str, ...] = (),
    ) -> Graph:
        specs = {}
        for name, (module_class, inputs, outputs, *further) in modules.items():
            path = module_class if isinstance(module_class, str) else class_path(module_class)
            extra = further[0] if further else {}
            specs[name] = ModuleSpec.model_validate({"class": path, "inputs": inputs, "outputs": outputs, **extra})
        return Graph(
            clock=VirtualClock(),
            channels={name: ChannelSpec.model_validate({"type": "Twist", **spec}) for name, spec in channels.items()},
            modules=specs,
            services=services or {},
            attended=attended,
        )

    return build_graph


@pytest.fixture
def make() -> Callable[..., Twist]:
    """:func:`number`, as a fixture."""
    return number
