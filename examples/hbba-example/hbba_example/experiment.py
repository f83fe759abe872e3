"""``hbba experiment near``: how many scans show something nearby, in virtual time."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any


def add_parser(experiments: Any) -> None:
    """Declare ``hbba experiment near``."""
    parser = experiments.add_parser("near", help="how many scans show something nearby, in virtual time")
    parser.add_argument("--seconds", type=float, default=10.0, metavar="S", help="how long (default 10)")


def run(args: argparse.Namespace) -> int:
    """Run it and print what came."""
    things = near_things(args.seconds)
    print(f"{len(things)} scans in {args.seconds:g} s, {sum(1 for each in things if each.count)} with something nearby")
    return 0


def near_things(seconds: float) -> list[Any]:
    """Every NearThings message of so many seconds of the program ``example``, in virtual time."""
    from app.program.config import load_configuration
    from app.program.system import System
    from app.robots.config import load_body_config
    from app.runtime.clock import VirtualClock, run_virtual
    from hbba_example.body import PostConfig, PostLink

    configuration = load_configuration(Path(__file__).with_name("example.yaml"))
    body = load_body_config(configuration.path(configuration.program.robot), PostConfig)
    clock = VirtualClock(1_700_000_000.0)
    system = System(configuration, link=PostLink(body, clock.now), body=body, clock=clock, reproducible=True)
    heard: list[Any] = []

    async def main() -> None:
        async with system:
            release = system.graph.channel("near_things").observe(heard.append)
            await clock.sleep(seconds)
            release()

    run_virtual(main())
    return heard
