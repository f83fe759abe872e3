"""The one way to the map, and who keeps something with it."""

from __future__ import annotations

import asyncio
from pathlib import Path

import pytest

from app.base.geometry import Pose2
from app.maps.map_service import Files, MapService, MapUnavailable
from app.messages import Zone


class FakeMapServer:
    """Has a map by name, and remembers what was kept with each; a load waits for ``go_on``."""

    def __init__(self, name: str = "") -> None:
        self.name = name
        self.kept: dict[str, Files] = {}
        self.go_on = asyncio.Event()
        self.go_on.set()

    async def save(self, name: str, others: Files | None = None) -> None:
        self.kept[name] = others or {}
        self.name = name

    async def load(self, name: str, X_MB: Pose2 | None = None, extend: bool = False) -> None:
        await self.go_on.wait()
        self.name = name

    async def begin(self) -> None:
        self.name = ""

    async def place(self, X_MB: Pose2) -> None: ...

    async def search(self) -> None: ...

    async def mark(self, zones: tuple[Zone, ...]) -> None: ...


class Layer:
    """Records its calls."""

    def __init__(self, lacks: str = "") -> None:
        self.calls: list[str] = []
        self._lacks = lacks

    async def files(self) -> Files:
        return {"layer": lambda path: void(path)}

    async def load(self, name: str) -> None:
        self.calls.append(name)
        if name == self._lacks:
            raise MapUnavailable(f"nothing is known of {name}")

    async def clear(self) -> None:
        self.calls.append("")


def void(path: Path) -> None:
    path.touch()


def test_there_is_a_map_server_while_one_is_attached() -> None:
    control = MapService()
    with pytest.raises(MapUnavailable, match="makes no maps"):
        _ = control.server
    leave = control.attach(FakeMapServer("first"))
    assert control.available
    assert control.server.name == "first"
    control.attach(FakeMapServer("second"))
    leave()  # the first one's, after a restart: the second stays
    assert control.server.name == "second"


async def test_a_layer_is_loaded_for_the_map_in_either_order() -> None:
    control, early, late = MapService(), Layer(), Layer()
    await control.add(early)
    assert early.calls == [], "nobody knows yet which map is in use"
    await control.resume("hall", same=False)
    control.attach(FakeMapServer("hall"))
    await control.add(late)
    assert early.calls == late.calls == ["hall"]


async def test_after_a_restart_on_the_same_map_a_layer_goes_on_and_on_another_it_does_not() -> None:
    control, layer = MapService(), Layer()
    await control.add(layer)
    for name, same in (("", False), ("", True), ("", False), ("hall", False), ("hall", True), ("attic", True)):
        await control.resume(name, same=same)
        leave = control.attach(FakeMapServer(name))
        leave()
    assert layer.calls == ["", "", "hall", "attic"]
    late = Layer()
    await control.add(late)
    await control.resume("attic", same=True)
    assert late.calls == ["attic"], "who was not there knows nothing of it"
    assert layer.calls[-2:] == ["hall", "attic"]


async def test_a_layer_added_during_a_load_is_loaded_for_the_new_map() -> None:
    control, server, layer = MapService(), FakeMapServer("hall"), Layer()
    control.attach(server)
    server.go_on.clear()
    load = asyncio.create_task(control.server.load("attic"))
    await asyncio.sleep(0)
    await control.add(layer)
    server.go_on.set()
    await load
    assert layer.calls == ["hall", "attic"]


async def test_what_layers_know_is_written_with_the_map_by_those_that_know_it() -> None:
    control, server, layer = MapService(), FakeMapServer(), Layer()
    control.attach(server)
    leave = await control.add(layer)
    await control.server.save("hall")
    assert list(server.kept["hall"]) == ["layer"]
    await control.server.save("hall")
    assert list(server.kept["hall"]) == ["layer"]
    await control.resume("hall", same=True)
    assert layer.calls == [""], "it has the name that it was kept under"
    server.name = "attic"  # taken into use, and no layer is loaded yet
    await control.server.save("attic")
    assert not server.kept["attic"], "what it knows is of another map"
    leave()
    await control.server.save("hall")
    assert not server.kept["hall"]


async def test_a_layer_that_lacks_something_holds_up_no_other(caplog: pytest.LogCaptureFixture) -> None:
    control, one, other = MapService(), Layer("hall"), Layer()
    control.attach(FakeMapServer())
    await control.add(one)
    await control.add(other)
    with pytest.raises(MapUnavailable, match="nothing is known of hall"):
        await control.server.load("hall")
    assert other.calls[-1] == "hall"
    await control.resume("hall", same=False)
    assert "nothing is known of hall" in caplog.text
