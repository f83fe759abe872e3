"""The robot for assistants, by the Model Context Protocol: ``python -m hbba_client.assistant``.

An assistant asks what the robot attends to and why, and desires what the role of its token allows. Its desires expire.
Needs the extra ``mcp``.
"""

from __future__ import annotations

import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Annotated, Any

import msgspec
from mcp.server.fastmcp import FastMCP
from pydantic import Field

from .async_robot import AsyncRobot
from .records import NewDesire

#: The name beside an assistant's desires.
NAME = "assistant"
#: An assistant's desire lasts at most so long (s); it desires again what it still wants.
LONGEST_TTL_S = 3600.0
ABOUT = """A service robot that attends to several things at once on one small computer. It is given no commands, but
desires (a class such as GoTo or LocateFaces, an intensity from 0 to 8, parameters), and selects what serves them best
within its budgets. Ask `attention` what it attends to now and why something is left out, `desire_classes` what can be
desired, then `desire`. Whatever `desire` answers, look at `outcome` for what became of it."""


def server(robot: AsyncRobot) -> FastMCP:
    """The tools of ``robot``. Refusals come back as the program's own words."""

    @asynccontextmanager
    async def closing(_: FastMCP) -> AsyncIterator[None]:
        yield
        await robot.aclose()

    tools: FastMCP = FastMCP("hbba", instructions=ABOUT, lifespan=closing)

    @tools.tool()
    async def attention() -> Any:
        """What the robot attends to now: strategies selected, classes fulfilled, budgets used, and for each desired
        class its state, the reason in words and what would help."""
        intention = await robot.get_intention()
        found = plain(intention)
        return {name: found[name] for name in ("fulfilled", "strategies", "use", "reasons", "relaxed", "proven")}

    @tools.tool()
    async def desires() -> Any:
        """Every desire, who stated it, and the behaviors that move the robot now."""
        return plain(await robot.list_desires())

    @tools.tool()
    async def desire_classes() -> Any:
        """What can be desired: class, description, JSON Schema of its parameters, whether something serves it."""
        return plain(await robot.list_desire_classes())

    @tools.tool()
    async def desire(
        desire_class: str,
        params: dict[str, Any] | None = None,
        intensity: Annotated[float, Field(gt=0, le=8)] = 4.0,
        seconds: Annotated[float, Field(gt=0, le=LONGEST_TTL_S)] = 60.0,
    ) -> Any:
        """Desire something for some seconds; the answer has its id. It may move the robot: GoTo drives."""
        new = NewDesire(class_=desire_class, intensity=intensity, utility=1.0, params=params or {}, ttl=seconds)
        return plain(await robot.create_desire(new))

    @tools.tool()
    async def outcome(desire_id: str, wait_s: Annotated[float, Field(ge=0, le=60)] = 0.0) -> Any:
        """A desire, and what became of it: done, failed, expired or withdrawn, with the reason; null: not yet."""
        return plain(await robot.get_desire(desire_id, wait=wait_s))

    @tools.tool()
    async def withdraw(desire_id: str) -> str:
        """Remove a desire."""
        await robot.remove_desire(desire_id)
        return "removed"

    @tools.tool()
    async def state() -> Any:
        """The robot: where it is, whether it moves, its battery, what it perceives."""
        return {"robot": plain(await robot.get_robot()), "percepts": plain(await robot.get_percepts())}

    @tools.tool()
    async def events(limit: Annotated[int, Field(ge=1, le=200)] = 50) -> Any:
        """The newest events of the timeline, oldest first: why the robot did what it did."""
        return plain(await robot.get_timeline())["events"][-limit:]

    @tools.tool()
    async def stop() -> Any:
        """Latch the emergency stop: nothing moves until a person releases it. For danger only."""
        return plain(await robot.latch_e_stop())

    return tools


def plain(record: msgspec.Struct) -> Any:
    """``record`` as JSON has it."""
    return msgspec.to_builtins(record)


def main() -> int:
    """Serve an assistant over standard input and output; the robot is that of ``HBBA_ADDRESS``."""
    try:
        robot = AsyncRobot(operator=NAME)
    except ValueError as mistake:
        sys.stderr.write(f"hbba_client.assistant: {mistake}\n")
        return 2
    server(robot).run()
    return 0


if __name__ == "__main__":
    sys.exit(main())
