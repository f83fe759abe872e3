"""ProgressSupervisor on virtual time: its changes of desires and its messages to people."""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping
from typing import Any

import pytest
from pydantic import BaseModel

from app.attention.desires import Desire, DesireClass, DesireClasses, Source
from app.attention.timeline import Timeline
from app.attention.workspace import IntentionWorkspace
from app.base.geometry import Pose2
from app.messages import Exploitation, NavigationStatus, Twist
from app.runtime.clock import run_virtual
from app.runtime.graph import WiringError
from tests.modules.fakes import Bench

MODULE = "app.modules.motivations.progress_supervisor:ProgressSupervisor"
PORTS = {"navigation": NavigationStatus, "going_toward": NavigationStatus, "exploitation": Exploitation}
ADA = Source("operator", "ada")
SETTINGS = {"insist_s": 5, "inhibit_s": 10, "give_up_s": 20, "unreachable_s": 2, "relief_s": 4}


class Place(BaseModel):
    """Parameters as the class GoTo has them."""

    x: float
    y: float
    heading: float | None = None
    name: str = ""


CLASSES = (
    DesireClass("GoTo", "Go somewhere", "Go.", Place, achievement=True),
    DesireClass("LocateFaces", "Locate faces", "Faces."),
    DesireClass("FindQRCodes", "Find QR codes", "Codes."),
)


class Life:
    """The module, a workspace and a timeline on the bench's clock, and a behavior that goes somewhere."""

    def __init__(self, settings: Mapping[str, Any] | None = None, *, inputs: Mapping[str, Any] | None = None) -> None:
        self.workspace = IntentionWorkspace(DesireClasses(CLASSES), lambda: self.bench.clock.now())
        self.timeline = Timeline(100, lambda: self.bench.clock.now())
        services = {IntentionWorkspace: self.workspace, Timeline: self.timeline}
        merged = {**SETTINGS, **(settings or {})}
        self.bench = Bench(MODULE, inputs=inputs or PORTS, services=services, settings=merged)
        self.progress: float | None = None
        self.left_m = 2.0

    def go(
        self, x: float = 3.0, y: float = 4.0, heading: float | None = None, *, name: str = "", **options: Any
    ) -> Desire:
        params = {"x": x, "y": y, "heading": heading, "name": name}
        wanted: dict[str, Any] = {"intensity": 6.0, "utility": 1.0, "source": ADA} | options
        return self.workspace.add("GoTo", params=params, **wanted)

    def say(self, state: str, desire: Desire | None, *, port: str = "navigation", reason: str = "") -> None:
        """What the behavior that goes for ``desire`` says."""
        goal = None
        if desire is not None:
            heading = desire.params["heading"]
            goal = Pose2(desire.params["x"], desire.params["y"], math.nan if heading is None else heading)
        now = self.bench.clock.now()
        behavior = {"navigation": "PlanAndFollowPath", "going_toward": "GoToward"}[port]
        self.bench.feed(port, NavigationStatus(now, behavior, state, reason, goal, goal, self.left_m, self.progress))

    def drives(self, behavior: str | None, limited: str = "") -> None:
        now = self.bench.clock.now()
        self.bench.feed("exploitation", Exploitation(now, behavior, Twist(now, 0.0, 0.0), limited))

    async def pass_time(self, seconds: float, state: str | None, desire: Desire | None = None, **options: Any) -> None:
        driver = options.pop("driver", "PlanAndFollowPath")
        limited = options.pop("limited", "")
        for _ in range(round(seconds / 0.1)):
            self.drives(driver, limited)
            if state is not None:
                self.say(state, desire, **options)
            await self.bench.clock.sleep(0.1)
            self.workspace.expire()

    @property
    def sentences(self) -> list[str]:
        return [event.text for event in self.timeline.query(kinds=["goal"])]


def test_what_it_did_about_distress_is_undone_at_the_goal() -> None:
    async def main() -> None:
        life = Life()
        async with life.bench:
            goal = life.go()
            await life.pass_time(6, "following", goal)
            assert life.workspace.get(goal.id).utility == 8
            life.say("arrived", goal)
            await life.bench.settle()
            assert life.workspace.desires() == (goal,), "the behavior ends it, not the motivation"
            assert life.sentences[-1] == "Distress is over, it has arrived: desires are as they were before"

    run_virtual(main())


def test_an_arrival_from_before_the_goal_was_desired_is_none() -> None:
    async def main() -> None:
        life = Life()
        async with life.bench:
            first = life.go()
            life.say("arrived", first)
            await life.bench.settle()
            life.workspace.remove(first.id)
            again = life.go()
            await life.pass_time(6, "following", again)
            assert life.workspace.get(again.id).utility == 8
            # A desire changed to another goal and back keeps its creation.
            life.workspace.change(again.id, params={"x": 0.0, "y": 0.0})
            life.say("arrived", life.workspace.get(again.id))
            life.workspace.change(again.id, params=again.params)
            await life.pass_time(6, "following", again)
            assert life.workspace.get(again.id).utility == 8

    run_virtual(main())


def test_distress_insists_inhibits_and_is_over_when_it_gets_on() -> None:
    async def main() -> None:
        life = Life({"inhibits": ["LocateFaces", "FindQRCodes"]})
        async with life.bench:
            faces = life.workspace.add("LocateFaces", intensity=8, utility=1, source=ADA)
            life.workspace.add("FindQRCodes", intensity=4, utility=1, source=ADA, security=True)
            goal = life.go()
            await life.pass_time(4.5, "following", goal)
            assert life.workspace.get(goal.id) == goal
            await life.pass_time(1, "following", goal)
            assert (life.workspace.get(goal.id).intensity, life.workspace.get(goal.id).utility) == (8, 8)
            assert life.workspace.strongest()["LocateFaces"] == faces
            await life.pass_time(5, "recovering", goal)
            assert life.workspace.strongest()["LocateFaces"].utility == 0, "silenced"
            assert life.workspace.strongest()["FindQRCodes"].security, "security is not"
            life.progress, life.left_m = life.bench.clock.now(), 1.0
            await life.pass_time(4.5, "following", goal)
            assert life.workspace.get(goal.id) == goal
            assert life.workspace.strongest()["LocateFaces"] == faces
            assert len(life.workspace.desires()) == 3
            assert life.sentences == [
                "Distress: (3.00, 4.00) has come no nearer for 5 s; insists on it",
                "Distress: (3.00, 4.00) has come no nearer for 10 s; insists on it and inhibits LocateFaces",
                "Distress is over, it gets on again: desires are as they were before",
            ]

    run_virtual(main())


def test_what_comes_no_nearer_is_given_up_and_people_are_asked(caplog: pytest.LogCaptureFixture) -> None:
    async def main() -> None:
        life = Life({"inhibits": ["LocateFaces"]})
        async with life.bench:
            faces = life.workspace.add("LocateFaces", intensity=8, utility=1, source=ADA)
            goal = life.go()
            await life.pass_time(21, "waiting", goal, reason="asks for help", limited="stopped: something 0.1 m ahead")
            assert life.workspace.desires() == (faces,)
            why = "no progress for 20 s (asks for help; stopped: something 0.1 m ahead)"
            assert life.sentences[-2:] == [
                "Distress is over, it is given up: desires are as they were before",
                f"Gave up going to (3.00, 4.00): {why}. Please help, or send it elsewhere",
            ]
            event = life.timeline.query(kinds=["goal"])[-1]
            where = {"x": 3.0, "y": 4.0, "heading": None}
            assert event.data == {"desire": goal.id, "arrived": False, "why": why, "goal": where}

    with caplog.at_level(logging.WARNING, "hbba"):
        run_virtual(main())
    assert [r.message for r in caplog.records if "Gave up" in r.message]


def test_an_unreachable_goal_is_given_up_with_its_reason() -> None:
    async def main() -> None:
        life = Life()
        async with life.bench:
            same, goal = life.go(intensity=2.0), life.go()
            other = life.go(heading=0.7, intensity=1.0)
            await life.pass_time(1.5, "unreachable", goal, reason="walls all around")
            assert life.workspace.desires() == (same, goal, other)
            await life.pass_time(1.5, "unreachable", goal, reason="walls all around")
            assert life.workspace.desires() == (other,), "all who desired the same are refused"
            for desire in (same, goal):
                ended = life.workspace.report(desire.id)
                assert (ended.outcome, ended.behavior, ended.reason) == ("failed", "Tested", "walls all around")
            assert life.sentences == [
                "Gave up going to (3.00, 4.00): walls all around. Please help, or send it elsewhere"
            ]

    run_virtual(main())


def test_a_goal_at_a_place_is_called_by_its_name() -> None:
    async def main() -> None:
        life = Life()
        async with life.bench:
            goal = life.go(name="Robotics lab")
            for _ in range(2):
                await life.pass_time(1.5, "unreachable", goal, reason="walls all around")
            assert life.sentences == [
                "Gave up going to Robotics lab: walls all around. Please help, or send it elsewhere"
            ]

    run_virtual(main())


def test_while_people_drive_it_waits() -> None:
    async def main() -> None:
        life = Life()
        async with life.bench:
            goal = life.go()
            await life.pass_time(60, "waiting", goal, driver="Teleop")
            await life.pass_time(4, "waiting", goal)
            assert life.workspace.desires() == (goal,)
            await life.pass_time(2, "waiting", goal)
            assert life.workspace.get(goal.id).utility == 8

    run_virtual(main())


def test_a_desire_that_people_change_meanwhile_stays_as_they_want_it() -> None:
    async def main() -> None:
        life = Life()
        async with life.bench:
            goal = life.go()
            await life.pass_time(6, "following", goal)
            life.workspace.change(goal.id, intensity=3.0)
            life.progress, life.left_m = life.bench.clock.now(), 1.0
            await life.pass_time(5, "following", goal)
            assert (life.workspace.get(goal.id).intensity, life.workspace.get(goal.id).utility) == (3, 8)

    run_virtual(main())


@pytest.mark.parametrize("ended", ["removed", "stopped"])
def test_nothing_of_it_is_left_when_the_goal_or_the_module_is_gone(ended: str) -> None:
    async def main() -> None:
        life = Life({"inhibits": ["LocateFaces"]})
        faces = life.workspace.add("LocateFaces", intensity=8, utility=1, source=ADA)
        async with life.bench:
            goal = life.go()
            await life.pass_time(12, "following", goal)
            assert life.workspace.strongest()["LocateFaces"].utility == 0
            if ended == "removed":
                life.workspace.remove(goal.id)
                await life.pass_time(0.5, "idle")
                assert life.workspace.desires() == (faces,)
        if ended == "stopped":
            assert life.workspace.desires() == (faces, goal)

    run_virtual(main())


def test_an_inhibited_class_is_no_errand() -> None:
    async def main() -> None:
        life = Life()
        async with life.bench:
            goal = life.go()
            life.go(intensity=8.0, utility=0.0)
            await life.pass_time(30, "following", goal)
            assert len(life.workspace.desires()) == 2
            assert life.sentences == []

    run_virtual(main())


def test_inhibiting_ends_by_itself_if_it_is_not_taken_back() -> None:
    async def main() -> None:
        life = Life({"inhibits": ["LocateFaces"]})
        async with life.bench:
            life.workspace.add("LocateFaces", intensity=8, utility=1, source=ADA)
            await life.pass_time(12, "following", life.go())
            inhibiting = life.workspace.strongest()["LocateFaces"]
            assert inhibiting.source == Source("motivation", "Tested", motive="emotional")
            assert inhibiting.expires == pytest.approx(inhibiting.created + 14)

    run_virtual(main())


def test_times_that_do_not_follow_each_other_are_refused() -> None:
    with pytest.raises(WiringError, match="none may be shorter"):
        Life({"inhibit_s": 3})


def test_a_program_without_a_straight_way_is_supervised_too() -> None:
    async def main() -> None:
        life = Life(inputs={"navigation": NavigationStatus})
        async with life.bench:
            goal = life.go()
            life.say("unreachable", goal, reason="walls all around")
            await life.bench.clock.sleep(3)
            assert life.workspace.report(goal.id).outcome == "failed"

    run_virtual(main())
