"""A program that drives the simulated robot, swings its head and an arm, to be killed, frozen or stuck by the guard's
tests.

``python driving_program.py GUARD_LOG [regex]``: prints the link process's id, then drives and swings; with ``regex`` it
goes, one second later, into a C call that holds the interpreter's lock, having printed the time.
"""

from __future__ import annotations

import asyncio
import re
import sys
import time
from pathlib import Path

from app.messages import JointCommand, Twist
from app.robots.config import load_robot_config
from app.robots.factory import create_link

CONFIG = Path(__file__).parents[3] / "config" / "robots" / "irl1_tr.yaml"


async def main(guard_log: str, fault: str) -> None:
    """Drive for as long as it is let."""
    robot = load_robot_config(CONFIG)
    streams = robot.streams.model_copy(update={"kinect": None, "panorama": None})
    robot = robot.model_copy(update={"guard_log": Path(guard_log), "streams": streams, "scenario": None})
    link = create_link(robot, 0.0)
    await link.start()
    print(link.process_id, flush=True)  # type: ignore[attr-defined]
    until = time.monotonic() + (1.0 if fault else 600.0)
    while time.monotonic() < until:
        now = time.monotonic()
        link.command(Twist(now, 0.3, 0.2))
        # Turned about before head and arm arrive: they never rest.
        side = 1.0 if now % 2.0 < 1.0 else -1.0
        link.command(JointCommand(now, "head", ("pan_joint",), (2.0 * side,)))
        link.command(JointCommand(now, "left_arm", ("left_shoulder_pitch_joint",), (-0.5 + 1.5 * side,)))
        await asyncio.sleep(0.05)
    print(time.monotonic(), flush=True)
    re.match(r"(a|a)*$", "a" * 40 + "b")


if __name__ == "__main__":
    asyncio.run(main(sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else ""))
