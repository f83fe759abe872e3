"""Robots of a fleet over REST: real consoles, each really served."""

from __future__ import annotations

import asyncio
import time
from dataclasses import replace
from pathlib import Path

import httpx

from app.console.app import create_app
from app.console.fleet.asking import Fleet
from app.console.fleet.fleet_file import RobotConsole
from app.program.system import System
from tests.console.program import Body, served
from tests.patience import PATIENCE_S


def named(system: System, name: str) -> None:
    program = system.config.program
    console = program.console.model_copy(update={"name": name})
    system.config = replace(system.config, program=program.model_copy(update={"console": console}))


async def test_each_robot_is_listed_with_its_state_and_who_drives(
    system: System, built: tuple[System, Body], page: Path
) -> None:
    """The same console three times: without a login, with one that is known, and with one that is not."""
    body = built[1]
    named(system, "Ada")
    nothing = await asyncio.start_server(lambda _, writer: writer.close(), "127.0.0.1", 0)
    gone = f"http://127.0.0.1:{nothing.sockets[0].getsockname()[1]}"
    nothing.close()
    asked = create_app(system, static_dir=page, early_view=False, token="secret")
    async with served(asked) as guarded:
        fleet = Fleet((RobotConsole(guarded, "secret"), RobotConsole(guarded), RobotConsole(gone)))
        here = create_app(system, static_dir=page, early_view=False, fleet=fleet)
        async with served(here) as url, httpx.AsyncClient(timeout=PATIENCE_S, base_url=f"{url}/api/v1") as client:
            body.emit_status(time.time())
            this, twin, refused, unreachable = (await client.get("/fleet")).raise_for_status().json()["robots"]
            assert (this["name"], this["body"], this["url"], this["driver"]) == ("Ada", "a test body", "", None)
            assert (twin["name"], twin["url"], twin["simulated"]) == ("Ada", guarded, True)
            assert this["state"] == twin["state"] == "problem"
            assert "called Ada" in twin["detail"]
            assert (refused["state"], refused["name"]) == ("refused", "")
            assert "token" in refused["detail"]
            assert unreachable["state"] == "unreachable"
            body.e_stop("a test")
            body.emit_status(time.time())
            robots = (await client.get("/fleet")).json()["robots"]
            assert [robot["state"] for robot in robots[:2]] == ["stopped", "stopped"]


async def test_a_robot_without_a_fleet_lists_itself(client: httpx.AsyncClient) -> None:
    assert [robot["name"] for robot in (await client.get("/fleet")).json()["robots"]] == ["a test body"]
