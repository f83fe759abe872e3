"""The program over REST: the emergency stop, the body that is silent, the health of modules."""

from __future__ import annotations

import asyncio

import httpx

from app.console.live.hub import Hub
from app.program.system import System
from tests.console.answers import is_problem
from tests.console.program import Body


async def test_the_emergency_stop_is_latched_and_released(client: httpx.AsyncClient, body: Body) -> None:
    latched = (await client.post("/stop")).json()
    assert latched["e_stop"] == "latched"
    assert body.stops == ["pressed by REST client"]
    robot = (await client.get("/robot")).json()
    assert robot["guard"]["state"] == "e_stopped"
    assert robot["stamp"] > latched["stamp"]
    released = await client.delete("/stop", params={"seen": robot["stamp"]})
    assert released.json()["e_stop"] == "released"
    assert not body.e_stopped
    assert (await client.delete("/stop")).json()["e_stop"] == "released", "nothing is latched: may be repeated"


async def test_a_stop_that_was_not_seen_is_not_released(
    client: httpx.AsyncClient, body: Body, system: System, hub: Hub
) -> None:
    before = (await client.get("/robot")).json()["stamp"]
    first = (await client.post("/stop")).json()["stamp"]
    problem = is_problem(await client.delete("/stop"), 409, "stop-not-seen")
    assert "?seen=" in problem["detail"]
    for stamp in (before, first - 60, system.clock.now() + 60):
        is_problem(await client.delete("/stop", params={"seen": stamp}), 409, "stop-not-seen")
    # Released with the stamp of the first stop, but late: it was pressed again meanwhile.
    hub.driving.e_stop("Ann")
    is_problem(await client.delete("/stop", params={"seen": first}), 409, "stop-not-seen")
    assert body.e_stopped
    is_problem(await client.delete("/stop", params={"seen": "nan"}), 422, "invalid-request")
    seen = (await client.get("/robot")).json()["stamp"]
    assert (await client.delete("/stop", params={"seen": seen})).status_code == 200
    assert not body.e_stopped


async def test_a_stop_that_the_guard_does_not_confirm_is_not_called_latched(
    client: httpx.AsyncClient, body: Body
) -> None:
    body.confirms = False
    is_problem(await client.post("/stop"), 504, "unconfirmed")
    assert body.e_stopped


async def test_a_body_that_falls_silent_is_reported(client: httpx.AsyncClient, system: System, body: Body) -> None:
    state = "silent"
    while state == "silent":  # a busy computer may answer later than a status lasts
        body.emit_status(system.clock.now())
        state = (await client.get("/robot")).json()["guard"]["state"]
    assert state == "idle"
    body.emit_status(system.clock.now() - 2)
    guard = (await client.get("/robot")).json()["guard"]
    assert guard["state"] == "silent"
    assert "nothing for 2" in guard["reason"]
    health = (await client.get("/health")).json()
    assert health["status"] == "degraded"
    assert guard["reason"][:30] in health["problems"][-1]


async def test_the_health_names_a_module_that_fails(client: httpx.AsyncClient, system: System) -> None:
    assert (await client.get("/health")).json()["status"] == "ok"
    failed = asyncio.Event()
    system.supervisor.observe(lambda state: failed.set() if state.status == "failed" else None)
    system.graph.channel("teleop_command").publish("no message at all")
    await failed.wait()
    health = (await client.get("/health")).json()
    assert health["status"] == "degraded"
    assert health["problems"] == ["Teleop: failed"]
    assert "AttributeError" in (await client.get("/modules/Teleop")).json()["problem"]
