"""Distress for behaviors in conflict: beside a real workspace and attention, and arbiters that report as they do."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import pytest

from app.attention.desires import Desire, DesireClass, DesireClasses
from app.attention.reports import desires_report, intention_report
from app.attention.strategies import Resource, Strategy, StrategyTable
from app.attention.timeline import Timeline
from app.attention.workspace import IntentionWorkspace
from app.messages import Desires, Exploitation, IntentionReport, NavigationStatus, Twist
from app.modules.motivations.conflicts import GAP_S, Conflict, ConflictLog
from app.runtime.clock import in_virtual_time
from app.runtime.graph import WiringError
from tests.attention.setting import Setting
from tests.modules.fakes import Bench

MODULE = "app.modules.motivations.progress_supervisor:ProgressSupervisor"
#: By class, the behavior, its group and its priority there.
SERVED = {
    "Teleoperation": ("Teleop", "base", 3),
    "PointAt": ("PointAt", "base", 2),
    "LookAt": ("LookAt", "head", 6),
    "LookAround": ("LookAround", "head", 1),
    "RotateToHeading": ("RotateToHeading", "base", 1),
}
#: PointAt moves an arm as well, which no other behavior does here.
TABLE = StrategyTable(
    tuple(
        Strategy(cls.lower(), cls, 8, filters={f"{behavior}.command": 1}, costs={"cpu": 1})
        for cls, (behavior, _, _) in SERVED.items()
    ),
    {"cpu": Resource("cpu", 100)},
)
CLASSES = DesireClasses([DesireClass(cls, cls, "") for cls in SERVED])


class Robot(Setting):
    """Desires, attention, arbiters of base, head and arm, and the motivation that watches them."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(TABLE, CLASSES)
        self.watch = Bench(
            MODULE,
            inputs={
                "navigation": NavigationStatus,
                "exploitation": Exploitation,
                "head": Exploitation,
                "arm": Exploitation,
                "desires": Desires,
                "intention": IntentionReport,
            },
            services={IntentionWorkspace: self.workspace, Timeline: self.timeline},
            settings={"conflict_s": 20, **settings},
        )

    @asynccontextmanager
    async def alive(self) -> AsyncIterator[None]:
        async with self.running(), self.watch:
            yield
        assert self.watch.problem == ""

    async def live(self, seconds: float) -> None:
        for _ in range(round(seconds / 0.1)):
            await self.translator.settled()
            now, current = self.clock.now(), self.translator.current
            assert current is not None
            selected = {strategy.cls for strategy in current.strategies}
            moved = {port: self._arbitrated(port, selected, now) for port in ("exploitation", "head", "arm")}
            drivers = {report.behavior for report in moved.values()}
            strongest = self.workspace.strongest()
            exploited = tuple(strongest[cls].id for cls in selected & strongest.keys() if SERVED[cls][0] in drivers)
            for port, report in moved.items():
                self.watch.feed(port, report)
            self.watch.feed("desires", desires_report(self.workspace, now, exploited))
            self.watch.feed("intention", intention_report(current, TABLE.resources))
            await asyncio.sleep(0.1)
            self.workspace.expire()

    def _arbitrated(self, port: str, selected: set[str], now: float) -> Exploitation:
        group = {"exploitation": "base"}.get(port, port)
        there = {
            behavior: priority for behavior, where, priority in (SERVED[cls] for cls in selected) if where == group
        }
        if group == "arm" and "PointAt" in selected:
            there["PointAt"] = 0
        ranked = sorted(there, key=there.__getitem__, reverse=True)
        driver = ranked[0] if ranked else None
        return Exploitation(now, driver, Twist(now, 0, 0), group=group, outdone=tuple(ranked[1:]))

    @property
    def inhibited(self) -> list[Desire]:
        return [desire for desire in self.workspace.desires() if desire.utility == 0]

    @property
    def words(self) -> list[str]:
        return [event.text for event in self.timeline.query(kinds={"exploitation"})]


@in_virtual_time
async def test_what_is_outdone_for_long_is_inhibited_until_the_other_lets_go() -> None:
    robot = Robot()
    async with robot.alive():
        robot.add("LookAround")
        looked = robot.add("LookAt")
        await robot.live(19)
        assert (robot.inhibited, robot.words) == ([], [])
        await robot.live(3)
        (inhibiting,) = robot.inhibited
        assert (inhibiting.cls, inhibiting.source.motive) == ("LookAround", "emotional")
        assert robot.selected == ("lookat",), "what it costs is free"
        said = "Distress: LookAround has been outdone by LookAt for 20 s (head); inhibits LookAround"
        assert robot.words == [said]
        await robot.live(120)
        assert robot.inhibited[0].id == inhibiting.id, "it is renewed, and stays as it is"
        assert len(robot.words) == 1
        robot.workspace.remove(looked)
        await robot.live(3)
        assert robot.inhibited == []
        assert robot.selected == ("lookaround",)
        assert robot.words[1:] == ["Distress is over: LookAround is inhibited no more"]
        await robot.live(60)
        assert len(robot.words) == 2


@in_virtual_time
async def test_it_ends_with_the_desire_that_was_outdone_and_with_the_module() -> None:
    robot = Robot()
    async with robot.alive():
        around = robot.add("LookAround")
        robot.add("LookAt")
        await robot.live(22)
        assert len(robot.inhibited) == 1
        robot.workspace.remove(around)
        await robot.live(1)
        assert robot.inhibited == []
        robot.add("LookAround")
        await robot.live(22)
        assert len(robot.inhibited) == 1
        await robot.watch.supervisor.stop_modules()
        assert robot.inhibited == []


@pytest.mark.parametrize(
    ("desired", "options"),
    [
        (("Teleoperation", "RotateToHeading"), {}),  # a person drives
        (("PointAt", "Teleoperation"), {"hands": []}),  # it moves an arm meanwhile
        (("LookAt", "RotateToHeading"), {}),  # of different groups
        (("LookAt", "LookAround"), {"conflict_s": None}),  # switched off
    ],
)
@in_virtual_time
async def test_what_is_no_conflict_is_left_alone(desired: tuple[str, ...], options: dict[str, Any]) -> None:
    robot = Robot(**options)
    async with robot.alive():
        for cls in desired:
            robot.add(cls)
        await robot.live(40)
        assert (robot.inhibited, robot.words) == ([], [])
        assert len(robot.selected) == len(desired)


@in_virtual_time
async def test_security_is_not_inhibited_and_what_a_person_withdraws_is_not_stated_again() -> None:
    robot = Robot()
    async with robot.alive():
        robot.add("LookAround", security=True)
        robot.add("LookAt")
        await robot.live(40)
        assert robot.inhibited == []
        assert robot.words == [
            "Distress: LookAround has been outdone by LookAt for 20 s (head); LookAround is security and stays"
        ]
    other = Robot()
    async with other.alive():
        other.add("LookAround")
        other.add("LookAt")
        await other.live(22)
        other.workspace.remove(other.inhibited[0].id)
        await other.live(60)
        assert other.inhibited == []
        assert len(other.words) == 1


def test_a_conflict_outlasts_a_short_pause_and_begins_again_after_a_long_one() -> None:
    log, conflict = ConflictLog(), Conflict("head", "LookAt", "LookAround")

    def report(stamp: float, *outdone: str) -> None:
        log.take(Exploitation(stamp, "LookAt", Twist(stamp, 0, 0), group="head", outdone=outdone))

    report(0.0, "LookAround")
    report(0.5)
    report(0.9, "LookAround")
    assert log.lasting(1.0) == {conflict: 1.0}
    report(5.0, "LookAround")
    assert log.lasting(5.5) == {conflict: 0.5}
    assert log.lasting(5.0 + GAP_S + 0.01) == {}
    assert log.moves("LookAt", "head", 6.0)
    assert not log.moves("LookAt", "head", 7.0)
    assert not log.moves("LookAt", "base", 5.0)


def test_conflicts_without_what_they_are_judged_by_are_refused() -> None:
    inputs = {"navigation": NavigationStatus, "exploitation": Exploitation, "intention": IntentionReport}
    with pytest.raises(WiringError, match=r"judges conflicts \(conflict_s\).* wire its input desires"):
        Bench(MODULE, inputs=inputs, settings={"conflict_s": 20})
    Bench(MODULE, inputs=inputs)
