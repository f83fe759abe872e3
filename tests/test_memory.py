"""Whether the program's memory is flat: in virtual time by every object, and in real time for as long as asked.

The second is ``make soak``: HBBA_SOAK_MINUTES says how long, and without it that test is skipped.
"""

from __future__ import annotations

import gc
import os
import re
import statistics
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest

from app.base import paths
from app.experiments.world_run import WorldRun, run_in_world
from app.program.config import load_configuration
from app.robots.config import load_robot_config
from tests.browser.running import running_robot

pytestmark = pytest.mark.slow

#: Scans, odometry and sixty other messages a second: an object kept for one message in ten shows. Histories of bounded
#: length are full after a minute.
WARM_S, IDLE_S = 60.0, 20.0
MOST_KEPT = 200

MINUTES = float(os.environ.get("HBBA_SOAK_MINUTES") or 0)
#: What is loaded, filled or compiled when something happens for the first time has happened after this share.
WARM_SHARE = 0.3
EVERY_S = 10.0
#: How much larger the memory that the program filled itself may be in the last tenth than in the first after it was
#: warm (bytes). Libraries, and pictures in shared memory, do not count.
MOST_GROWTH = 12e6


def test_an_idle_program_keeps_no_object() -> None:
    kept: list[int] = []

    async def idle(run: WorldRun) -> None:
        for seconds in (WARM_S, IDLE_S):
            await run.system.clock.sleep(seconds)
            gc.collect()
            kept.append(sys.getallocatedblocks())

    body = load_robot_config(paths.config_dir() / "robots" / "irl1_tr.yaml")
    run_in_world(load_configuration(paths.config_dir() / "lab.yaml"), body, idle)
    assert kept[1] - kept[0] < MOST_KEPT


@pytest.mark.skipif(not MINUTES, reason="takes as long as HBBA_SOAK_MINUTES says: make soak")
@pytest.mark.timeout(60 * MINUTES + 600)
@pytest.mark.blocking("watches another process")
def test_the_memory_of_an_idle_robot_is_flat(tmp_path: Path) -> None:
    with running_robot(tmp_path) as robot:
        runtime = Path(f"/proc/{robot.process.pid}/status")
        samples: list[float] = []
        began = time.monotonic()
        while time.monotonic() - began < 60 * MINUTES:
            anonymous = re.search(r"^RssAnon:\s+(\d+) kB$", runtime.read_text(), re.MULTILINE)
            assert anonymous is not None
            samples.append(1024.0 * int(anonymous[1]))
            if len(samples) % 30 == 0:
                print(f"{(time.monotonic() - began) / 60:5.1f} min {samples[-1] / 1e6:6.1f} MB", flush=True)
            with suppress(subprocess.TimeoutExpired):
                pytest.fail(f"the program ended with code {robot.process.wait(EVERY_S)}")
    warm = samples[int(WARM_SHARE * len(samples)) :]
    tenth = max(len(warm) // 10, 1)
    first, last = statistics.median(warm[:tenth]), statistics.median(warm[-tenth:])
    assert last - first < MOST_GROWTH, f"{first / 1e6:.1f} MB became {last / 1e6:.1f} MB"
