"""How regularly the robot decides while it drives.

The whole lab program in real time, everything desired that attention admits, going to and fro in its corridor.

The period of cycle starts (the stamps of what is commanded) and that of commands (when they are published), in ms; once
with all cores and once confined to one, the world (the body's process) being on another. Take it on a quiet computer.
"""

from __future__ import annotations

import asyncio
import os
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
import psutil

from app.attention.desires import Source
from app.base import logging_setup, paths
from app.experiments.simulated import simulated_program
from app.messages import Twist
from app.runtime.realtime import tune_for_latency
from benchmarks.report import Row, benchmark_main, row

SETTLE_S = 12.0
#: On the map that begins where the robot does: down the corridor from the south, and back.
PLACES = ((-2.5, 0.0), (0.0, 0.0))
BESIDE = ("FindQRCodes", "LocateFaces", "LocateVoices", "DetectNoises", "Telepresence")
_SOURCE = Source("operator", "the benchmark")


def measure(quick: bool) -> Sequence[Row]:
    """Both cases, of 20 s or 90 s each."""
    cv2.setNumThreads(1)
    logging_setup.configure("warning", as_json=False)
    rows: list[Row] = []
    for case, one_core in (("all cores", False), ("one core", True)):
        starts, commands, chosen = asyncio.run(_drive(20.0 if quick else 90.0, one_core=one_core))
        print(f"   {case}: {', '.join(chosen)}", flush=True)
        for what, times in (("cycle starts", starts), ("commands", commands)):
            periods = 1e3 * np.diff(times)
            for metric, value in zip(("p50", "p99"), np.percentile(periods, (50, 99)), strict=True):
                rows.append(row("period", f"{what}, {case}", metric, "ms", [float(value)]))
            rows.append(row("period", f"{what}, {case}", "max", "ms", [float(periods.max())]))
    return rows


async def _drive(seconds: float, *, one_core: bool) -> tuple[list[float], list[float], list[str]]:
    with tempfile.TemporaryDirectory() as folder:
        os.environ["HBBA_MAPS"] = folder
        program = await asyncio.to_thread(simulated_program, None, _scenario())
        system, link = await asyncio.to_thread(program.system)
        cores = os.sched_getaffinity(0)
        starts: list[float] = []
        commands: list[float] = []

        def commanded(twist: Twist) -> None:
            starts.append(twist.stamp)
            commands.append(time.monotonic())

        async with system:
            await system.supervisor.started()
            tune_for_latency()
            if one_core:
                await asyncio.to_thread(_confine, os.getpid(), {min(cores)})
                if link.process_id is not None and len(cores) > 1:
                    await asyncio.to_thread(_confine, link.process_id, cores - {min(cores)})
            for name in BESIDE:
                system.workspace.add(name, intensity=4, utility=1, source=_SOURCE)
            system.workspace.add("SLAM", intensity=8, utility=1, source=_SOURCE)
            await asyncio.sleep(SETTLE_S)
            chosen: list[str] = []
            end = system.clock.now() + seconds
            stop = system.graph.channels["path_twist"].observe(commanded)
            turn = 0
            while system.clock.now() < end:
                x, y = PLACES[turn % 2]
                turn += 1
                params = {"x": x, "y": y}
                goal = system.workspace.add("GoTo", intensity=8, utility=4, params=params, source=_SOURCE)
                while any(d.id == goal.id for d in system.workspace.desires()) and system.clock.now() < end:
                    await asyncio.sleep(0.2)
                    if (current := system.translator.current) is not None:
                        chosen = [strategy.name for strategy in current.strategies]
                # Between two goals there are no commands: that gap is no period.
                starts.append(float("nan"))
                commands.append(float("nan"))
            stop()
        os.sched_setaffinity(0, cores)
        return _without_gaps(starts), _without_gaps(commands), chosen


def _without_gaps(times: list[float]) -> list[float]:
    """``times`` with what lies between two goals left out, so that differences are periods."""
    starts: list[float] = []
    shift = 0.0
    gap = False
    for now in times:
        if np.isnan(now):
            gap = bool(starts)
        elif gap:
            shift, gap = starts[-1] - now, False  # the first after a gap follows none: it takes the last one's place
        else:
            starts.append(now + shift)
    return starts


def _confine(process: int, cores: set[int]) -> None:
    family = [psutil.Process(process)]
    if process != os.getpid():
        family += family[0].children(recursive=True)
    for member in family:
        for thread in member.threads():
            os.sched_setaffinity(thread.id, cores)


def _scenario() -> Path:
    return paths.config_dir() / "scenarios" / "lab.yaml"


if __name__ == "__main__":
    sys.exit(benchmark_main(__doc__ or "", measure))
