"""Compiles the numerical kernels before a robot runs: beside it, compilation would take its processor for minutes."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import os
import signal
from collections.abc import Sequence

from app.base.child_processes import python

log = logging.getLogger("hbba.kernels")


async def kernels_ready(command: Sequence[str] = ()) -> None:
    """Compile the numerical kernels that are not compiled yet, saying each file; to cancel it ends that at once.

    ``command`` compiles them and prints a line for each; replaced in tests. A kernel that cannot be compiled is logged
    here, and its module fails later, with the reason.
    """
    from app.base import compiled

    if await asyncio.to_thread(compiled.is_ready):
        return
    print("HBBA compiles its numerical kernels, once on this computer: a minute or two.", flush=True)
    log.info("compiling the numerical kernels; the robot starts after it")
    process = await asyncio.create_subprocess_exec(
        *(command or python("-m", "app.base.compiled")),
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.PIPE,
        start_new_session=True,
    )
    assert process.stdout is not None
    try:
        async for line in process.stdout:
            log.info(line.decode(errors="replace").strip().removeprefix("hbba: "))
        if status := await process.wait():
            log.error("a kernel could not be compiled (status %d): modules that need it will fail", status)
    finally:
        if process.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)  # with the processes that it shares the work with
            await process.wait()
