"""The package's parts by themselves, and its program in virtual time."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import hbba_example
import pytest
from hbba_example import experiment
from hbba_example.body import JOINTS_HZ, PostConfig, PostLink, scan
from hbba_example.lantern_pointer import nearest_bearing
from hbba_example.messages import NearThings
from hbba_example.near_thing_counter import near_things

from app.attention.desires import Source
from app.base.geometry import Pose3
from app.messages import LinkStatus
from app.program.config import load_configuration
from app.program.system import System
from app.robots.config import load_body_config
from app.runtime.clock import VirtualClock, run_virtual


@pytest.fixture
def post() -> PostConfig:
    """The package's body."""
    return load_body_config(Path(hbba_example.__file__).with_name("robot.yaml"), PostConfig)


@pytest.mark.parametrize("at_s", [0.0, 2.5, 7.0, 9.9, 10.0, 10.1, 13.0])
def test_the_thing_is_one_wherever_it_is(post: PostConfig, at_s: float) -> None:
    assert near_things(scan(at_s, post, Pose3.identity()), 1.5) == NearThings(at_s, 1, 1.0)


def test_what_is_far_is_not_near(post: PostConfig) -> None:
    assert near_things(scan(3.0, post, Pose3.identity()), 0.9) == NearThings(3.0, 0, None)


def test_the_program_counts_while_it_is_desired() -> None:
    things = experiment.near_things(3.0)
    assert len(things) > 10
    assert {each.count for each in things} == {1}


@pytest.mark.parametrize("at_s", [1.0, 9.9, 10.1, 19.0])
def test_the_nearest_thing_has_a_bearing(post: PostConfig, at_s: float) -> None:
    """The middle of its rays, also where they pass from the last to the first."""
    toward = 2 * math.pi * at_s / post.period_s
    bearing = nearest_bearing(scan(at_s, post, Pose3.identity()))
    assert bearing is not None
    assert abs(math.remainder(bearing - toward, 2 * math.pi)) < math.radians(10)


def test_the_lantern_turns_while_it_is_desired_and_holds_else(post: PostConfig) -> None:
    """Within its speed; still before the desire, held within its timeout after it, and in an emergency stop."""
    configuration = load_configuration(Path(hbba_example.__file__).with_name("example.yaml"))
    clock = VirtualClock(1_700_000_000.0)
    link = PostLink(post, clock.now)
    system = System(configuration, link=link, body=post, clock=clock, reproducible=True)
    turned: list[float] = []
    statuses: list[LinkStatus] = []

    async def main() -> None:
        async with system:
            link.attach("joints", lambda joints: turned.append(joints.positions[0]))
            link.attach("status", statuses.append)
            await clock.sleep(3.0)
            assert set(turned) == {0.0}
            desire = system.workspace.add("PointLantern", intensity=5, utility=4, source=Source("operator", "a test"))
            await clock.sleep(4.0)
            toward = 2 * math.pi * clock.now() / post.period_s
            assert abs(math.remainder(turned[-1] - toward, 2 * math.pi)) < math.radians(25)
            system.workspace.remove(desire.id)
            await clock.sleep(1.0)
            held = turned[-1]
            await clock.sleep(2.0)
            assert turned[-1] == held
            assert [group.guard for group in statuses[-1].groups] == ["idle"]

    run_virtual(main())
    steps = [abs(after - before) for before, after in pairwise(turned)]
    assert max(steps) <= 2.0 / JOINTS_HZ + 1e-9
