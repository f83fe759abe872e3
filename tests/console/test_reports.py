"""How fresh each channel is, in the words of REST and the live stream."""

from __future__ import annotations

import asyncio

import httpx
import pytest

from app.console import reports
from app.console.playback import rate
from app.console.records.program import SourceState
from app.console.records.robot import GroupReport
from app.messages import Exploitation, GroupStatus, JointState, LinkStatus, TimelineEvent, Twist
from app.program.system import System
from app.runtime.clock import RealClock
from app.runtime.freshness import Freshness
from app.runtime.replay_clock import ReplayClock
from tests.console.program import HEAD, Body, image
from tests.patience import PATIENCE_S


def test_freshness_is_in_milliseconds_and_beside_the_expected_rate() -> None:
    state = reports.source_state("scan", Freshness("live", 0.012345, 0.3, 15 / 4, 3.7512))
    assert state == SourceState("scan", "live", age_ms=12.3, rate_hz=3.75, expected_hz=3.75)
    state = reports.source_state("scan", Freshness("waiting", None, None, None))
    assert state == SourceState("scan", "waiting", age_ms=None, rate_hz=None, expected_hz=None)


async def test_page_and_rest_and_timeline_agree_on_a_channel(
    client: httpx.AsyncClient, system: System, body: Body
) -> None:
    async def listed(name: str) -> dict[str, object]:
        channels = (await client.get("/channels")).json()["channels"]
        found: dict[str, object] = next(channel for channel in channels if channel["name"] == name)
        return found

    def source(name: str) -> SourceState:
        fresh = system.freshness.read(system.clock.now())
        return next(state for state in reports.source_states(system.graph, fresh) if state.channel == name)

    assert (await listed("kinect"))["state"] == source("kinect").state == "closed"
    subscription = system.graph.channel("kinect").subscribe("test")
    assert (await listed("kinect"))["state"] == source("kinect").state == "waiting"
    body.emit("kinect", image(system.clock.now()))
    kinect = await listed("kinect")
    assert (kinect["state"], kinect["expected_hz"], kinect["stale_after_ms"]) == ("live", 15.0, 300.0)
    assert source("kinect").state == "live"
    # As if the picture had been taken long ago, after time enough to take another.
    late = system.freshness.read(system.clock.now() + 5.0)
    assert late["kinect"].state == "stale"
    system.graph.channel("kinect").unsubscribe(subscription)
    assert (await listed("kinect"))["state"] == "closed"
    assert (await listed("kinect"))["expected_hz"] == 0.0
    assert {state.channel for state in reports.source_states(system.graph, late)} == {
        "kinect", "panorama", "microphones", "scan", "odometry", "joints", "exploitation", "external_forces",
    }  # fmt: skip


@pytest.mark.slow
async def test_a_sensor_that_says_nothing_is_on_the_timeline(system: System) -> None:
    noted: asyncio.Queue[TimelineEvent] = asyncio.Queue()
    end = system.timeline.observe(lambda event: noted.put_nowait(event) if event.subject == "odometry" else None)
    known = system.timeline.query(kinds=["stale"])
    async with asyncio.timeout(PATIENCE_S):
        event = next((event for event in known if event.subject == "odometry"), None) or await noted.get()
    end()
    assert event.kind == "stale"
    assert event.text.startswith("odometry is stale: nothing has come yet")


def test_the_guard_of_a_fast_recording_is_silent_only_when_it_is_so_in_real_time() -> None:
    status = LinkStatus(100.0, "driving", "", False, 0.01, Twist(100.0, 0.1, 0.0), 1.0)
    assert reports.guard(status, 100.6).state == "silent"
    assert reports.guard(status, 105.0, rate=20.0).state == "driving"
    assert reports.guard(status, 111.0, rate=20.0).state == "silent"
    exploitation = Exploitation(100.0, "Teleop", status.applied)
    assert reports.exploited(exploitation, 100.6) is None
    assert reports.exploited(exploitation, 105.0, rate=20.0) == "Teleop"


def test_only_a_recording_that_runs_fast_has_a_rate() -> None:
    clock = ReplayClock(0.0)
    assert [rate(c) for c in (RealClock(), clock)] == [1.0, 1.0]
    clock._state = clock._state._replace(rate=5.0)
    assert rate(clock) == 5.0


def test_a_group_is_reported_with_its_guard_the_behavior_that_moves_it_and_its_speed() -> None:
    still = Twist(100.0, 0.0, 0.0)
    groups = (GroupStatus("head", "moving", "", 0.1), GroupStatus("arm", "refused", "no joint 'thumb'", None))
    status = LinkStatus(100.0, "idle", "", False, None, still, 1.0, groups)
    exploitations = {"head": Exploitation(100.0, "LookAt", still, group="head")}
    names = ("pan_joint", "tilt_joint", "left_wheel_joint")
    speeds = reports.joint_speeds(
        JointState(99.9, names, (0.0, 0.1, 0.0)), JointState(100.0, names, (0.02, 0.05, 9.0)), {"head": HEAD}
    )
    assert reports.groups(status, exploitations, speeds, 100.1) == (
        GroupReport("head", "moving", "", "LookAt", 0.5),
        GroupReport("arm", "refused", "no joint 'thumb'", None, 0.0),
    )
    assert {each.state for each in reports.groups(status, exploitations, speeds, 101.0)} == {"silent"}
    assert reports.groups(None, {}, {}, 100.0) == ()
    assert reports.joint_speeds(None, JointState(100.0, names, (0.0, 0.0, 0.0)), {"head": HEAD}) == {}
