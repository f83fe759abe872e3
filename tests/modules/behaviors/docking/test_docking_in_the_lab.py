"""The whole program in the simulated lab, in virtual time: to the dock and into it, and out of it again."""

from __future__ import annotations

import math

import pytest

from app.base import paths
from app.base.geometry import Pose2, wrap_angle
from app.base.yaml_source import parse
from app.experiments.world_run import WorldRun
from app.messages import DockingStatus
from app.robots.simulated.world_config import WorldConfig
from tests.scenery.docking_lab import ME, X_WD, errors, in_the_lab

pytestmark = pytest.mark.slow

#: In the south corridor: far from the dock and looking away from it; near, looking at it; near and looking aside.
FAR, AHEAD, ASIDE = Pose2(11.0, 4.6, math.pi / 2), Pose2(11.1, 2.2, -math.pi / 2), Pose2(11.6, 1.6, 0.0)


async def docking(run: WorldRun, until: str, limit_s: float = 120.0) -> list[DockingStatus]:
    """What docking reports until it reports the state ``until``."""
    statuses: list[DockingStatus] = []
    end = run.system.graph.channels["docking"].observe(statuses.append)
    try:
        for _ in range(round(limit_s / 0.1)):
            await run.system.clock.sleep(0.1)
            if statuses and statuses[-1].state == until:
                break
    finally:
        end()
    return statuses


async def docked(run: WorldRun) -> None:
    """Wait until it is docked, within 5 cm and 5 degrees of where it should be, and charges."""
    statuses = await docking(run, "docked")
    assert [status.state for status in statuses][-1:] == ["docked"], statuses
    await run.system.clock.sleep(2.0)
    along, aside, turned_deg = errors(run.link.true_pose())
    assert abs(along) < 0.05
    assert abs(aside) < 0.05
    assert abs(turned_deg) < 5
    assert run.system.graph.channels["battery"].latest.charging
    assert run.link.contacts == ()


def dock(run: WorldRun, intensity: float = 5.0) -> str:
    return run.system.workspace.add("Dock", intensity=intensity, utility=1, source=ME).id


def test_from_far_it_docks_and_people_can_have_it_undock() -> None:
    async def script(run: WorldRun) -> None:
        await run.system.clock.sleep(1.0)
        desire = dock(run)
        await docked(run)
        assert run.system.workspace.report(desire).outcome == "done"
        run.system.workspace.remove(desire)
        await run.system.clock.sleep(1.0)
        before = run.link.true_pose()
        undock = run.system.workspace.add("Undock", intensity=5, utility=1, source=ME).id
        await docking(run, "idle")
        await run.system.clock.sleep(1.0)
        after = run.link.true_pose()
        assert "Undock" not in run.system.workspace.strongest()
        assert math.dist((before.x, before.y), (after.x, after.y)) == pytest.approx(0.5, abs=0.05)
        assert run.system.workspace.report(undock).outcome == "done"

    in_the_lab(FAR, script)


def test_a_dock_that_is_not_there_fails_with_a_reason() -> None:
    world = parse(paths.config_dir() / "worlds" / "lab.yaml", WorldConfig)
    world = world.model_copy(update={"objects": tuple(item for item in world.objects if item.kind != "dock")})

    async def script(run: WorldRun) -> tuple[DockingStatus, str | None, str]:
        await run.system.clock.sleep(1.0)
        desire = dock(run)
        statuses = await docking(run, "failed")
        await run.system.clock.sleep(0.5)
        report = run.system.workspace.report(desire)
        assert not [desire for desire in run.system.workspace.desires() if desire.cls == "GoTo"]
        return statuses[-1], report.outcome, report.reason

    status, outcome, reason = in_the_lab(AHEAD, script, world=world)
    assert status.state == "failed"
    assert (outcome, reason) == ("failed", "no dock is seen where it should be")


def test_without_power_it_backs_off_and_tries_again_as_often_as_is_set() -> None:
    async def script(run: WorldRun) -> tuple[list[tuple[str, int]], str]:
        await run.system.clock.sleep(1.0)
        desire = dock(run)
        statuses = await docking(run, "failed")
        await run.system.clock.sleep(0.5)
        assert run.link.contacts == ()
        tries: list[tuple[str, int]] = [
            (status.state, status.attempt) for status in statuses if status.state in ("approaching", "backing")
        ]
        return tries, run.system.workspace.report(desire).reason

    tries, reason = in_the_lab(AHEAD, script, plate_m=0.15, attempts=2)  # too far back for the dock's contacts
    assert tries == [("approaching", 1), ("backing", 2), ("approaching", 2)]
    assert reason == "the charger gives no power, after 2 attempts"


def test_it_leaves_the_dock_backwards_before_it_turns_for_another_place() -> None:
    async def script(run: WorldRun) -> list[Pose2]:
        await run.system.clock.sleep(1.0)
        dock(run)
        await docked(run)
        # A place less desired than charging is none to leave for; a more desired one is.
        there = {"x": 0.0, "y": 0.0}
        run.system.workspace.add("GoTo", intensity=4, utility=1, params=there, source=ME)
        before = run.link.true_pose()
        await run.system.clock.sleep(3.0)
        assert math.dist((before.x, before.y), (run.link.true_pose().x, run.link.true_pose().y)) < 0.01
        run.system.workspace.add("GoTo", intensity=6, utility=1, params=there, source=ME)
        poses = [run.link.true_pose()]
        while len(poses) < 300 and poses[-1].y - X_WD.y < 1.3:
            await run.system.clock.sleep(0.1)
            poses.append(run.link.true_pose())
        assert "Undock" not in run.system.workspace.strongest()
        assert run.link.contacts == ()
        return poses

    poses = in_the_lab(AHEAD, script)
    begin = poses[0]
    for pose in poses:
        if math.dist((pose.x, pose.y), (begin.x, begin.y)) < 0.45:
            assert abs(wrap_angle(pose.theta - begin.theta)) < math.radians(5)
    assert poses[-1].y - X_WD.y >= 1.3


def test_a_low_battery_takes_the_robot_to_the_dock_by_itself() -> None:
    async def script(run: WorldRun) -> tuple[list[str], str]:
        await docked(run)
        wanted = run.system.workspace.wanted("Dock")
        assert wanted is not None
        events = [event.subject for event in run.system.timeline.query(kinds={"battery"})]
        assert run.system.translator.capacities["power"] == 60.0
        return events, wanted.source.name

    events, source = in_the_lab(ASIDE, script, charge=0.2)
    assert events == ["low", "charging"]
    assert source == "Recharge"
