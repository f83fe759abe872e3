"""Modules and a wiring of them for tests of graphs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from pydantic import Field

from app.messages import Twist
from app.runtime.errors import ModuleFailed
from app.runtime.graph import Graph, WiringError
from app.runtime.module import Module, ModuleContext, Settings

Build = Callable[..., Graph]


class SourceSettings(Settings):
    period_s: float = Field(0.1, gt=0)


class Source(Module):
    Settings = SourceSettings
    title = "Counts"
    settings: SourceSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.numbers = self.output("numbers", Twist)


class Relay(Module):
    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.numbers = self.input("numbers", Twist)
        self.safety = self.input("safety", Twist, always_open=True)
        self.relayed = self.output("relayed", Twist)


class Wheels(Module):
    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.driven = self.input("driven", Twist, moves=True)
        self.pushed = self.input("pushed", Twist, moves=True)
        self.brake = self.input("brake", Twist)

    def check_wiring(self) -> None:
        if not self.brake.connected:
            raise ModuleFailed("wheels need a brake")


WIRED: tuple[dict[str, Any], dict[str, Any]] = (
    {"A": (Source, {}, {"numbers": "n"}), "B": (Relay, {"numbers": "n", "safety": "n"}, {"relayed": "r"})},
    {"n": {}, "r": {}},
)


def refused(build: Build, *args: Any, **kwargs: Any) -> str:
    with pytest.raises(WiringError) as caught:
        build(*args, **kwargs)
    return str(caught.value)
