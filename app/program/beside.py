"""A script that runs beside a program, in its event loop."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from typing import TypeVar

from app.program.system import System

T = TypeVar("T")


async def run_beside(system: System, script: Callable[[], Awaitable[T]]) -> T:
    """Run ``system``, and once it is up ``script`` until that ends; return what it returns.

    Raises what the script raises, and what ended the program if it ended before the script.
    """
    async with system:
        failed = asyncio.create_task(system.wait_failed(), name="failure")
        scripted = asyncio.ensure_future(script())
        try:
            await asyncio.wait({scripted, failed}, return_when=asyncio.FIRST_COMPLETED)
            if not scripted.done():
                raise failed.result()
            return scripted.result()
        finally:
            failed.cancel()
            scripted.cancel()
            await asyncio.wait({failed, scripted})
