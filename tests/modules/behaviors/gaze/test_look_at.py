"""LookAt by itself: frames of the point, what it waits for, what is out of reach."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from app.attention.desires import DesireClasses, InvalidDesire, Source
from app.attention.workspace import IntentionWorkspace
from app.base.geometry import Pose2
from app.messages import JointCommand, JointState, Landmark, Landmarks, Localization, Odometry
from app.modules.behaviors.gaze.look_at import LOOK_AT
from app.runtime.clock import VirtualClock, in_virtual_time
from tests.modules.behaviors.gaze.head_bench import EYE, HEAD, NAMES, head_bench, off_axis_deg
from tests.modules.fakes import Bench, drain


def bench(eye: str = EYE, group: str = "head", workspace: IntentionWorkspace | None = None) -> Bench:
    inputs = {"localization": Localization, "landmarks": Landmarks}
    return head_bench("look_at:LookAt", inputs, eye=eye, group=group, workspace=workspace)


async def looked(b: Bench, seconds: float, **parameters: Any) -> list[JointCommand]:
    """What it commands within ``seconds`` of being asked to look somewhere."""
    given = b.listen("command")
    b.graph.filters.apply({"Tested.command": 1})
    b.graph.configure("Tested", parameters)
    await b.clock.sleep(seconds)
    b.graph.channel("command").unsubscribe(given)
    return drain(given)


def localized(b: Bench, X_MO: Pose2, state: str) -> Localization:
    return Localization(b.clock.now(), X_MO, X_MO, np.zeros((3, 3)), state, 0.9, "")


@in_virtual_time
async def test_a_point_beside_the_robot_is_looked_at_ten_times_a_second() -> None:
    async with bench() as b:
        assert await looked(b, 0.5) == [], "no point, no command"
        commands = await looked(b, 1.0, x=1.5, y=1.0, z=1.0, frame="base_link")
        assert len(commands) == 10
        assert {command.group for command in commands} == {"head"}
        assert {command.names for command in commands} == {NAMES}
        assert off_axis_deg(commands[-1], [1.5, 1.0, 1.0]) < 0.01
        assert await looked(b, 0.5) == [], "the desire is gone"


@in_virtual_time
async def test_a_point_in_the_room_is_followed_while_the_robot_turns() -> None:
    async with bench() as b:
        assert await looked(b, 0.5, x=2.0, y=0.0, z=1.0, frame="odom") == [], "it does not know where it is"
        b.feed("odometry", Odometry(b.clock.now(), Pose2(0.0, 0.0, -math.pi / 2), 0.0, 0.0))
        commands = await looked(b, 0.3, x=2.0, y=0.0, z=1.0, frame="odom")
        assert off_axis_deg(commands[-1], [0.0, 2.0, 1.0]) < 0.01


@in_virtual_time
async def test_a_point_on_the_map_waits_for_a_pose_on_the_map() -> None:
    async with bench() as b:
        b.feed("odometry", Odometry(b.clock.now(), Pose2(), 0.0, 0.0))
        point = {"x": 2.0, "y": 5.0, "z": 1.0, "frame": "map"}
        assert await looked(b, 0.5, **point) == []
        b.feed("localization", localized(b, Pose2(0.0, 5.0, 0.3), "lost"))
        assert await looked(b, 0.5, **point) == []
        b.feed("localization", localized(b, Pose2(0.0, 5.0, 0.3), "tracking"))
        commands = await looked(b, 0.5, **point)
        assert off_axis_deg(commands[-1], [2 * math.cos(-0.3), 2 * math.sin(-0.3), 1.0]) < 0.01


@in_virtual_time
async def test_what_is_out_of_reach_is_looked_at_as_nearly_as_can_be_and_said_once(
    caplog: pytest.LogCaptureFixture,
) -> None:
    caplog.set_level("INFO")
    async with bench() as b:
        commands = await looked(b, 1.0, x=-3.0, y=0.3, z=1.2, frame="base_link")
        pan, _ = commands[-1].positions
        assert pan == pytest.approx(HEAD.joints[0].upper)
    assert [r.getMessage() for r in caplog.records].count("the point is out of the head's reach") == 1


@in_virtual_time
async def test_the_point_is_looked_at_once_the_joints_are_there_and_stays_desired() -> None:
    workspace = IntentionWorkspace(DesireClasses([LOOK_AT]), VirtualClock().now)
    b = bench(workspace=workspace)
    b.graph.channel("accomplishments").observe(workspace.accomplish)
    ahead = {"x": 1.5, "y": 1.0, "z": 1.0, "frame": "base_link"}
    behind = {"x": -3.0, "y": 0.3, "z": 1.2, "frame": "base_link"}
    async with b:

        def desire(params: dict[str, Any]) -> str:
            source = Source("rest", "test")
            return workspace.add("LookAt", intensity=5, utility=4, params=params, source=source).id

        def becomes(desire_id: str) -> tuple[str | None, str, float | None]:
            report = workspace.report(desire_id)
            return report.outcome, report.reason, report.ended

        one, other = desire(ahead), desire(behind)
        command = (await looked(b, 0.5, **ahead))[-1]
        assert becomes(one) == (None, "", None), "where the joints are is not known"
        for share, outcome in ((0.9, None), (1.0, "done")):
            positions = tuple(share * position for position in command.positions)
            b.feed("joints", JointState(b.clock.now(), command.names, positions))
            await looked(b, 0.5, **ahead)
            assert becomes(one) == (outcome, "", None)
        assert becomes(other) == (None, "", None), "a point that is not looked at"
        await looked(b, 0.5, **behind)
        assert becomes(other) == ("failed", "the point is out of the head's reach", None)


@in_virtual_time
async def test_it_commands_nothing_while_attention_keeps_its_output_closed() -> None:
    async with bench() as b:
        given = b.listen("command")
        b.graph.configure("Tested", {"x": 1.5, "y": 1.0, "z": 1.0, "frame": "base_link"})
        await b.clock.sleep(0.5)
        assert drain(given) == []


@in_virtual_time
async def test_a_body_without_the_eye_or_the_group_is_refused() -> None:
    async with bench(eye="nose") as b:
        assert "cannot look by 'nose': the robot has no link 'nose'" in b.problem
    async with bench(group="tail") as b:
        assert "the group 'tail', which a test body does not have" in b.problem


@in_virtual_time
async def test_a_place_is_looked_at_once_its_code_was_found() -> None:
    async with bench() as b:
        b.feed("odometry", Odometry(b.clock.now(), Pose2(0.0, 0.0, math.pi / 2), 0.0, 0.0))
        assert await looked(b, 0.5, place="the kitchen") == []
        found = Landmark("the kitchen", (1.0, 2.0, 1.3), 0.02, sightings=3, first_seen=1.0, last_seen=2.0)
        b.feed("landmarks", Landmarks(b.clock.now(), (found,)))
        commands = await looked(b, 0.5, place="the kitchen")
        assert off_axis_deg(commands[-1], [2.0, -1.0, 1.3]) < 0.01


@in_virtual_time
async def test_a_place_on_the_map_is_looked_at_from_where_the_robot_is_on_it() -> None:
    async with bench() as b:
        b.feed("odometry", Odometry(b.clock.now(), Pose2(0.0, 0.0, math.pi / 2), 0.0, 0.0))
        found = Landmark("the kitchen", (1.0, 7.0, 1.3), 0.02, sightings=3, first_seen=1.0, last_seen=2.0)
        b.feed("landmarks", Landmarks(b.clock.now(), (found,), "map"))
        assert await looked(b, 0.5, place="the kitchen") == []
        b.feed("localization", localized(b, Pose2(0.0, 5.0, 0.0), "tracking"))
        commands = await looked(b, 0.5, place="the kitchen")
        assert off_axis_deg(commands[-1], [2.0, -1.0, 1.3]) < 0.01


@pytest.mark.parametrize("params", [{}, {"x": 1.0}, {"x": 1.0, "y": 1.0, "place": "the kitchen"}])
def test_a_desire_has_a_point_or_a_place(params: dict[str, Any]) -> None:
    with pytest.raises(InvalidDesire, match="needs x and y, or a place, and not both"):
        LOOK_AT.validated(params)
