"""The robot for assistants, asked by a real client of the Model Context Protocol."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest
from hbba_client import AsyncRobot, assistant
from mcp import ClientSession, StdioServerParameters
from mcp.client.stdio import stdio_client
from mcp.shared.memory import create_connected_server_and_client_session

from app.program.system import System
from tests.clients.test_python_client import console


@asynccontextmanager
async def asking(url: str) -> AsyncIterator[ClientSession]:
    tools = assistant.server(AsyncRobot(console(url), operator=assistant.NAME))
    async with create_connected_server_and_client_session(tools._mcp_server) as session:
        yield session


async def answer(session: ClientSession, tool: str, **arguments: Any) -> Any:
    result = await session.call_tool(tool, arguments)
    assert not result.isError, result.content
    return [
        json.loads(each.text) if each.text[0] in "{[" else each.text for each in result.content if each.type == "text"
    ]


async def test_an_assistant_desires_and_sees_what_came_of_it(url: str, system: System) -> None:
    async with asking(url) as session:
        assert {tool.name for tool in (await session.list_tools()).tools} >= {"attention", "desire", "outcome", "stop"}
        (classes,) = await answer(session, "desire_classes")
        assert "Listen" in {each["name"] for each in classes["classes"]}
        (made,) = await answer(session, "desire", desire_class="Listen", seconds=30)
        assert made["source"]["name"] == assistant.NAME
        assert made["expires"] is not None
        (desires,) = await answer(session, "desires")
        assert made["id"] in {each["id"] for each in desires["desires"]}
        await answer(session, "withdraw", desire_id=made["id"])
        (report,) = await answer(session, "outcome", desire_id=made["id"])
        assert report["outcome"] == "withdrawn"
        assert await answer(session, "events", limit=5)


@pytest.mark.parametrize(
    ("tool", "arguments", "words"),
    [
        ("desire", {"desire_class": "Nothing"}, "unknown-desire-class"),
        ("desire", {"desire_class": "Listen", "intensity": 9}, "less than or equal to 8"),
        ("desire", {"desire_class": "Listen", "seconds": 1e6}, "less than or equal to 3600"),
        ("withdraw", {"desire_id": "d-0"}, "no-such-desire"),
    ],
)
async def test_a_refusal_comes_back_in_words(
    url: str, system: System, tool: str, arguments: dict[str, Any], words: str
) -> None:
    async with asking(url) as session:
        result = await session.call_tool(tool, arguments)
        assert result.isError
        assert words in str(result.content)


async def test_the_emergency_stop(url: str, system: System) -> None:
    async with asking(url) as session:
        (stopped,) = await answer(session, "stop")
        assert stopped["e_stop"] == "latched"


async def test_it_speaks_over_standard_input_and_output(url: str, system: System) -> None:
    environment = {**os.environ, "HBBA_ADDRESS": console(url), "PYTHONASYNCIODEBUG": ""}
    environment["PYTHONPATH"] = str(Path(__file__).parents[2] / "clients" / "python")
    command = StdioServerParameters(command=sys.executable, args=["-m", "hbba_client.assistant"], env=environment)
    async with stdio_client(command) as (reading, writing), ClientSession(reading, writing) as session:
        await session.initialize()
        (attention,) = await answer(session, "attention")
        assert "reasons" in attention
