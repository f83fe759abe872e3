"""What is reported of where the robot goes."""

from __future__ import annotations

import pytest

from app.attention.desires import DesireClasses, Source
from app.attention.timeline import Timeline
from app.attention.workspace import IntentionWorkspace
from app.base.geometry import Pose2
from app.messages import Localization, NavigationReport, NavigationStatus, PlannedPath
from app.modules.behaviors.go_to import GO_TO
from app.modules.behaviors.navigation_reporter import ARRIVED_S, at_work
from app.runtime.clock import VirtualClock, run_virtual
from tests.console.places import localization, path, status
from tests.modules.fakes import Bench

MODULE = "app.modules.behaviors.navigation_reporter:NavigationReporter"
INPUTS = {
    "navigation": NavigationStatus,
    "going_toward": NavigationStatus,
    "path": PlannedPath,
    "localization": Localization,
}


class Going:
    """The module, a workspace and a timeline."""

    def __init__(self) -> None:
        clock = VirtualClock()
        self.workspace = IntentionWorkspace(DesireClasses([GO_TO]), clock.now)
        self.timeline = Timeline(100, clock.now)
        services = {IntentionWorkspace: self.workspace, Timeline: self.timeline}
        self.bench = Bench(MODULE, inputs=INPUTS, outputs={"report": NavigationReport}, services=services)

    @property
    def report(self) -> NavigationReport:
        latest = self.bench.graph.channel("report").latest
        assert isinstance(latest, NavigationReport)
        return latest

    def feed(self, channel: str, message: object) -> None:
        self.bench.feed(channel, message)

    async def after(self, seconds: float = 0.25) -> NavigationReport:
        await self.bench.clock.sleep(seconds)
        return self.report

    def give_up(self) -> None:
        """As the progress supervisor notes it."""
        goal = {"x": 3.0, "y": 1.0, "heading": None}
        about = {"desire": "d", "arrived": False, "why": "a zone is in the way", "goal": goal}
        self.timeline.add("goal", "GoTo", "Gave up going there", about)


def test_of_two_behaviors_the_one_under_way_is_reported() -> None:
    driving, done = status(1.0, "recovering"), status(2.0, "idle", "GoToward")
    assert at_work([done, driving]) is driving
    assert at_work([status(3.0, "waiting"), driving]) is driving
    both = [status(1.0, "waiting"), status(2.0, "waiting", "GoToward")]
    assert at_work(both) is both[0]
    assert at_work([done, status(1.0, "arrived")]) is done
    assert at_work([]) is None


def test_a_path_in_odom_is_reported_on_the_map_while_it_is_followed() -> None:
    async def main() -> None:
        going = Going()
        async with going.bench as bench:
            assert (going.report.state, going.report.path.shape) == ("idle", (0, 2))
            now = bench.clock.now()
            going.feed("localization", localization(now, Pose2(1.0, 0.5, 0.0)))
            going.feed("path", path(now, 2, frame="odom"))
            going.feed("navigation", status(now))
            report = await going.after()
            assert report.path.tolist() == [[1.0, 0.5], [1.1, 0.5]]
            assert (report.behavior, report.remaining_m, report.recoveries) == ("PlanAndFollowPath", 2.34, 1)
            going.feed("localization", localization(now, Pose2(2.0, 0.5, 0.0)))
            assert (await going.after()).path[0].tolist() == [2.0, 0.5]
            going.feed("navigation", status(bench.clock.now(), "arrived"))
            assert len((await going.after()).path) == 0

    run_virtual(main())


def test_an_arrival_is_reported_for_a_while() -> None:
    async def main() -> None:
        going = Going()
        async with going.bench as bench:
            now = bench.clock.now()
            going.feed("navigation", status(now, "arrived"))
            going.feed("navigation", NavigationStatus(now, "PlanAndFollowPath", "idle", "no goal"))
            assert (await going.after()).state == "arrived"
            assert (await going.after(ARRIVED_S)).state == "idle"

    run_virtual(main())


@pytest.mark.parametrize("ended_by", ["another goal", "an event"])
def test_a_goal_given_up_is_reported_until_it_is_void(ended_by: str) -> None:
    async def main() -> None:
        going = Going()
        async with going.bench:
            going.give_up()
            given_up = (await going.after()).given_up
            assert given_up is not None
            assert (given_up.goal.x, given_up.reason) == (3.0, "a zone is in the way")
            if ended_by == "an event":
                going.timeline.add("goal", "GoTo", "void", {"given_up": None})
            else:
                going.workspace.add(
                    "GoTo", intensity=8, utility=4, params={"x": 1, "y": 1}, source=Source("rest", "ann")
                )
            assert (await going.after()).given_up is None

    run_virtual(main())


def test_a_goal_given_up_for_another_is_not_reported() -> None:
    async def main() -> None:
        going = Going()
        async with going.bench:
            source = Source("rest", "x")
            other = going.workspace.add("GoTo", intensity=1, utility=4, params={"x": 9, "y": 9}, source=source)
            going.give_up()
            report = await going.after()
            assert (report.desire, report.given_up) == (other.id, None)

    run_virtual(main())
