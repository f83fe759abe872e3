"""LookAround by itself: rows, pauses, rounds."""

from __future__ import annotations

import math
from typing import Any

import pytest

from app.attention.desires import DesireClasses, Source
from app.attention.workspace import IntentionWorkspace
from app.messages import JointState
from app.modules.behaviors.gaze.look_around import LOOK_AROUND
from app.runtime.clock import VirtualClock, in_virtual_time
from tests.modules.behaviors.gaze.head_bench import HEAD, NAMES, commanded, desire, head_bench

WIDE = {"width_deg": 90.0, "pause_s": 0.5, "rounds": None}


def stops(positions: list[tuple[float, ...]]) -> list[tuple[int, int]]:
    """Degrees of the different positions, in order."""
    found: list[tuple[int, int]] = []
    for pan, tilt in positions:
        here = (round(math.degrees(pan)), round(math.degrees(tilt)))
        if not found or found[-1] != here:
            found.append(here)
    return found


@in_virtual_time
async def test_it_sweeps_row_by_row_with_a_pause_at_each_direction() -> None:
    async with head_bench("look_around:LookAround", step_deg=45, elevations_deg=(0.0, -10.0)) as b:
        desire(b, **WIDE)
        commands = await commanded(b, 4.6)
        found = stops([command.positions for command in commands])
        assert found[:6] == [(-45, 0), (0, 0), (45, 0), (45, -10), (0, -10), (-45, -10)]
        assert found[6:7] in ([], [(-45, 0)]), "and from the beginning"
        first = [command for command in commands if stops([command.positions]) == [(-45, 0)]]
        assert first[5].stamp - first[0].stamp >= 0.5 - 1e-6


@in_virtual_time
async def test_a_direction_counts_once_the_joints_are_there() -> None:
    async with head_bench("look_around:LookAround") as b:
        desire(b, **WIDE)
        given = b.listen("command")
        for _ in range(40):  # another behavior has the head
            b.feed("joints", JointState(b.clock.now(), NAMES, (1.0, 0.0)))
            await b.clock.sleep(0.1)
        seen = [given.receive_nowait().positions for _ in range(given.statistics().depth)]
        assert len(stops(seen)) == 1


@in_virtual_time
async def test_what_is_out_of_reach_is_looked_at_as_near_as_can_be_and_holds_nothing_up() -> None:
    async with head_bench("look_around:LookAround", elevations_deg=(0.0,)) as b:
        desire(b, width_deg=360.0, pause_s=0.0, rounds=None)
        pans = [command.positions[0] for command in await commanded(b, 6.0)]
        assert min(pans) == pytest.approx(HEAD.joints[0].lower)
        assert max(pans) == pytest.approx(HEAD.joints[0].upper)


@in_virtual_time
async def test_after_its_rounds_it_leaves_the_head_to_others() -> None:
    params: dict[str, Any] = {"width_deg": 90.0, "pause_s": 0.1, "rounds": 1}
    workspace = IntentionWorkspace(DesireClasses([LOOK_AROUND]), VirtualClock().now)
    wanted = workspace.add("LookAround", intensity=5, utility=4, params=params, source=Source("rest", "a test")).id
    async with head_bench("look_around:LookAround", workspace=workspace, elevations_deg=(0.0,)) as b:
        b.graph.channel("accomplishments").observe(workspace.accomplish)
        desire(b, **params)
        assert await commanded(b, 3.0) != []
        assert await commanded(b, 2.0) == []
        assert workspace.report(wanted).outcome == "done"
        assert workspace.desires() == (), "there is nothing left to do"
        desire(b, width_deg=60.0, pause_s=0.1, rounds=1)
        assert await commanded(b, 1.0) != [], "another desire"


@in_virtual_time
async def test_without_a_desire_or_while_closed_nothing_is_commanded() -> None:
    async with head_bench("look_around:LookAround") as b:
        b.graph.configure("Tested", WIDE)
        assert await commanded(b, 1.0) == []
        desire(b)
        assert await commanded(b, 1.0) == []
