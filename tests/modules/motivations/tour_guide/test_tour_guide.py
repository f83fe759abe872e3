"""TourGuide in virtual time: tours with visitors who come along, lag, ask and leave, and what may come between."""

from __future__ import annotations

import asyncio
import math
from pathlib import Path

import pytest

from app.base.geometry import Pose2
from app.messages import Landmark, Landmarks, LinkStatus, Twist
from app.runtime.clock import in_virtual_time
from app.tours.run_service import TourRefused
from tests.modules.motivations.tour_guide.lab_tour import PLACES, lab, tour
from tests.modules.motivations.tour_guide.led_lab import LedLab, Visitor, failed
from tests.modules.motivations.tour_guide.run import LAB, say, stop

pytestmark = pytest.mark.slow

ARM = {"file": "media/arm.jpg", "alt": {"en": "An orange arm"}}


@in_virtual_time
async def test_a_whole_tour(tmp_path: Path) -> None:
    stops = [stop("one", do=[say("This is one.") | {"show": ARM}]), LAB.stops[1].model_dump()]
    async with await lab(tmp_path, stops=stops) as led:
        led.start()
        await led.until("confirming")
        listens = led.desired("ListenForWords")
        assert listens is not None
        assert listens.params["words"] == "yes, no"
        led.hear("yes")
        await led.until("leading")
        assert led.desired("LocateFaces") is None, "it sees only ahead"
        assert led.desired("LocateVoices") is not None, "ears hear all round"
        await led.until("presenting")
        assert (led.progress.stop, led.progress.number, led.progress.stops) == ("one", 1, 2)
        assert led.progress.shown is not None
        assert (led.progress.shown.file, led.progress.text) == ("media/arm.jpg", {"en": "This is one."})
        await led.until("listening")
        assert led.progress.shown is None, "it was of the other stop"
        assert [question.id for question in led.progress.questions] == ["weight"]
        led.hear("heavy")
        await led.until("answering")
        await led.until("listening")
        led.clap()
        await led.live(0.5)
        led.clap()
        await led.until("going_home")
        await led.until("idle")
        assert led.said == [
            *("Hello.", "Shall I?", "This is one.", "This is two.", "Four kilograms.", "Goodbye."),
        ]
        assert led.moving() == ["Dock"], "it charges"
        await led.live(1.0)
        (report,) = await asyncio.to_thread(led.runs.reports)
        assert (report.outcome, report.agreed, report.people_most) == ("the tour is over", True, 2)
        assert [(each.stop, each.presented, each.people) for each in report.stops] == [
            ("one", True, 2),
            ("two", True, 2),
        ]
        assert report.stops[1].questions == {"weight": 1}
        assert report.driven_m == pytest.approx(led.driven_m, rel=0.02)
        assert await asyncio.to_thread(led.runs.kept) is None
        subjects = [event.subject for event in led.timeline.query(kinds=["tour"])]
        assert subjects
        assert set(subjects) == {"lab-tour"}


@in_virtual_time
async def test_a_call_ends_a_wait_and_a_clap_does_not(tmp_path: Path) -> None:
    calls = stop("one", do=[{"wait": {"at_most_s": 60, "call": True}}])
    async with await lab(tmp_path, stops=[calls]) as led:
        led.start()
        await led.until("confirming")
        led.press("agree")
        await led.until("listening")
        assert led.desired("DetectNoises") is not None
        led.clap()
        await led.live(3.0)
        assert led.progress.state == "listening"
        led.speaks = True
        await led.live(0.5)
        led.clap()
        await led.until("parting", limit_s=2)


@in_virtual_time
async def test_visitors_begin_it_again_and_again_by_coming(tmp_path: Path) -> None:
    async with await lab(tmp_path, Visitor(9.0, 0.0, mps=0.0)) as led:
        led.start(waits=True)
        await led.live(5)
        assert (led.progress.state, led.progress.waits, led.moving()) == ("idle", True, [])
        led.visitors = [Visitor(2.0, 0.0)]
        await led.until("inviting", limit_s=10)
        await led.until("idle", limit_s=60)
        assert led.progress.reason == "visitors did not answer"
        await led.live(5)
        assert led.progress.state == "idle", "they know by now"
        led.visitors = [Visitor(9.0, 0.0, mps=0.0)]
        await led.live(5)
        led.visitors = [Visitor(2.0, 0.0)]
        await led.until("inviting", limit_s=10)
        with pytest.raises(TourRefused, match="end it first"):
            led.server.dismiss()
        led.press("decline")
        led.server.dismiss()
        await led.live(10)
        assert (led.progress.tour, led.workspace.desires()) == ("", ())
        assert len(await asyncio.to_thread(led.runs.reports)) == 2


@in_virtual_time
async def test_it_waits_for_one_who_lags_and_looks_where_they_are(tmp_path: Path) -> None:
    async with await lab(tmp_path, Visitor(1.5, 0.0, mps=0.0)) as led:
        led.start()
        await led.until("confirming")
        led.press("agree")
        await led.until("waiting", limit_s=60)
        assert led.desired("GoTo") is None, "waiting is not distress"
        where = led.robot
        await led.live(6)
        visitor = led.visitors[0]
        assert math.dist((led.robot.x, led.robot.y), (where.x, where.y)) == 0
        bearing = math.atan2(visitor.y - led.robot.y, visitor.x - led.robot.x)
        assert abs(math.remainder(led.robot.theta - bearing, math.tau)) < 0.4, "it has turned to them"
        visitor.mps = 1.0
        await led.until("leading", limit_s=60)
        assert math.dist((visitor.x, visitor.y), (led.robot.x, led.robot.y)) <= 2.5
        await led.until("presenting", limit_s=120)
        assert led.server.report is not None
        assert led.server.report.waits >= 1
        assert led.server.report.waited_s > 0


@in_virtual_time
async def test_it_goes_home_when_all_have_left(tmp_path: Path) -> None:
    async with await lab(tmp_path) as led:
        led.start()
        await led.until("confirming")
        led.press("agree")
        await led.until("leading")
        led.visitors = []
        await led.until("waiting", limit_s=60)
        await led.until("searching", limit_s=20)
        await led.until("parting", limit_s=90)
        waiting, still = ["I am waiting for you."] * 2, ["Are you still with me?"] * 2
        assert led.said[1:] == ["I am coming back for you.", *waiting, *still]
        assert led.progress.reason == "all visitors have left"
        await led.until("idle")
        assert math.dist((led.robot.x, led.robot.y), (0, 0)) < 0.2


@in_virtual_time
@pytest.mark.parametrize("give_up_s", [20, 60])
async def test_visitors_who_follow_behind_it_as_it_drives_back_are_found(tmp_path: Path, give_up_s: float) -> None:
    pace = {"look_back_m": 1.5, "give_up_s": give_up_s}
    places = PLACES | {"one": Pose2(12.0, 0.0, 0.0)}
    made = await asyncio.to_thread(LedLab, tmp_path, tour(pace=pace), places)
    made.visitors = [Visitor(1.5, 0.5), Visitor(1.5, -0.5)]
    made.laser = False  # their legs would say that they are there
    async with made as led:

        def follow() -> None:
            """They look elsewhere, then come after it wherever it goes, where it does not see."""
            for side, visitor in enumerate(led.visitors):
                searching = led.progress.state == "searching"
                visitor.looks = ("searching" in led.states and not searching) or led.progress.state == "confirming"
                if searching:
                    at = led.robot @ Pose2(-1.2, 0.6 * side - 0.3)
                    visitor.x, visitor.y = at.x, at.y

        led.start()
        await led.until("confirming")
        led.press("agree")
        await led.until("searching", limit_s=120, each=follow)
        led.detour = (led.robot.x, 15.0)  # they stand in the way that it came
        await led.until("leading", "parting", limit_s=120, each=follow)
        assert led.progress.state == "leading", led.progress.reason
        assert led.robot.y < 2.0, "it did not go far another way"
        led.detour = None
        await led.until("idle", limit_s=600, each=follow)
        assert (led.progress.presented, led.progress.reason) == (("one", "two"), "the tour is over")


@in_virtual_time
async def test_nothing_moves_after_the_emergency_stop_before_a_press(tmp_path: Path) -> None:
    async with await lab(tmp_path) as led:
        led.start()
        await led.until("confirming")
        led.press("agree")
        await led.until("leading")
        await led.live(1)
        led.e_stop = True
        await led.live(1)
        assert (led.progress.state, led.moving()) == ("paused", [])
        assert led.progress.question is not None
        assert led.progress.question.default == "the tour ends where it is"
        with pytest.raises(TourRefused, match="resume does nothing while the tour is paused; now there are: "):
            led.press("resume")
        led.e_stop = False
        where = led.robot
        await led.live(20)
        assert (led.progress.state, led.moving(), led.robot) == ("paused", [], where)
        assert "I was stopped. One moment, please." in led.said
        led.press("resume")
        assert led.progress.state == "leading"
        await led.until("presenting", limit_s=120)


@in_virtual_time
async def test_hands_pause_it_and_it_goes_on_from_there(tmp_path: Path) -> None:
    async with await lab(tmp_path) as led:
        led.start()
        await led.until("confirming")
        led.press("agree")
        await led.until("leading")
        led.by_hand = True
        await led.live(1)
        assert (led.progress.state, led.moving()) == ("paused", [])
        led.robot = Pose2(3.0, -2.0, 1.0)
        led.by_hand = False
        await led.until("presenting", limit_s=120)
        assert led.progress.stop == "one"


@in_virtual_time
async def test_an_operators_goal_is_a_hand_too(tmp_path: Path) -> None:
    async with await lab(tmp_path) as led:
        led.start()
        await led.until("confirming")
        led.press("agree")
        await led.until("leading")
        led.send(2.0, 3.0)
        await led.live(1)
        assert (led.progress.state, led.moving()) == ("paused", [])
        await led.live(8)
        assert led.driven_m > 3.0, "it went there"
        await led.until("presenting", limit_s=120)


@in_virtual_time
async def test_a_goal_that_the_operator_cancels_is_a_pause(tmp_path: Path) -> None:
    async with await lab(tmp_path) as led:
        led.start()
        await led.until("confirming")
        led.press("agree")
        await led.until("leading")
        goal = led.desired("GoTo")
        assert goal is not None
        led.workspace.remove(goal.id)
        await led.live(5)
        assert (led.progress.state, led.progress.reason, led.moving()) == ("paused", "its goal was withdrawn", [])
        led.press("resume")
        assert led.desired("GoTo") is not None


@in_virtual_time
async def test_people_in_its_way_are_asked_and_then_the_operator(tmp_path: Path) -> None:
    async with await lab(tmp_path, on_failure={"reach": {"retry": 0, "ask_s": 20, "then": "skip"}}) as led:
        led.start()
        await led.until("confirming")
        led.press("agree")
        await led.until("leading")
        led.blocked = True
        await led.live(25)
        assert led.said.count("Excuse me, may I pass?") == 2
        failed(led, "GoTo", "no progress for 90 s")
        await led.until("blocked", limit_s=2)
        question = led.progress.question
        assert question is not None
        assert (question.answers, question.default) == (("retry", "skip", "end"), "the stop is skipped")
        assert question.until - led.bench.clock.now() == pytest.approx(20, abs=0.5)
        led.blocked = False
        await led.until("presenting", limit_s=120)
        assert led.progress.stop == "two"
        assert [(failure.stop, failure.what) for failure in led.progress.failures] == [("one", "not reached")]


@in_virtual_time
async def test_a_low_battery_ends_it_and_is_said(tmp_path: Path) -> None:
    async with await lab(tmp_path) as led:
        led.start()
        await led.until("confirming")
        led.press("agree")
        await led.until("leading")
        led.battery = 0.15
        await led.until("going_home", limit_s=30)
        assert led.said[-2:] == ["My battery is low. I must end the tour here.", "Goodbye."]
        await led.until("idle")
        with pytest.raises(TourRefused, match="the battery is too low for a tour"):
            led.start()


@in_virtual_time
async def test_an_emergency_stop_that_is_released_at_once_is_a_pause(tmp_path: Path) -> None:
    async with await lab(tmp_path) as led:
        led.start()
        await led.until("confirming")
        led.press("agree")
        await led.until("leading")
        still = Twist(led.bench.clock.now(), 0.0, 0.0)
        for e_stopped in (True, False):
            led.bench.feed("status", LinkStatus(led.bench.clock.now(), "idle", "", e_stopped, None, still, 1.0))
            await led.bench.clock.sleep(0.01)
        await led.live(5)
        assert (led.progress.state, led.moving()) == ("paused", [])
        led.press("resume")
        await led.until("leading", limit_s=5)


@in_virtual_time
async def test_the_report_is_there_as_soon_as_the_run_is_over(tmp_path: Path) -> None:
    async with await lab(tmp_path) as led:
        led.start()
        await led.until("inviting")
        led.press("decline")
        assert led.progress.state == "idle"
        (report,) = await asyncio.to_thread(led.runs.reports)
        assert report.ended is not None


@in_virtual_time
async def test_no_tour_begins_that_cannot_be_led(tmp_path: Path) -> None:
    async with await lab(tmp_path) as led:
        for wrong, why in (
            (tour(map="garage"), "is on the map garage, and the map in use is lab: load garage first"),
            (tour(stops=[stop("three")]), "none of the places"),
        ):
            with pytest.raises(TourRefused, match=why):
                led.server.start_tour(wrong, language="en", waits=False)
        with pytest.raises(TourRefused, match="not in 'fr'; there are: en"):
            led.start(language="fr")
        with pytest.raises(TourRefused, match="no tour is under way"):
            led.press("pause")
        led.e_stop = True
        await led.live(0.5)
        with pytest.raises(TourRefused, match="no tour begins while the robot is held"):
            led.start()
        assert led.progress.tour == ""
        led.e_stop = False
        await led.live(0.5)
        led.start()
        with pytest.raises(TourRefused, match="under way; end it first"):
            led.start()
        with pytest.raises(TourRefused, match="no stop can be gone to while the tour is inviting"):
            led.server.choose("two")
        with pytest.raises(TourRefused, match="no stop 'three'; there are: one, two"):
            led.server.choose("three")
        with pytest.raises(TourRefused, match="'weight' is no question that can be asked now; there are: none"):
            led.server.ask("weight")


@in_virtual_time
async def test_it_turns_to_the_poster_of_a_stop_that_stands_so(tmp_path: Path) -> None:
    async with await lab(tmp_path, stops=[stop("one", poster="P", stand={"face": "poster"})]) as led:
        now = led.bench.clock.now()
        poster = Landmark("P", (4.0, -1.2, 1.3), 0.02, 3, first_seen=now, last_seen=now, id=1)
        led.start()
        led.bench.feed("landmarks", Landmarks(now, (poster,), "odom"))
        led.bench.feed("landmarks", Landmarks(now, (poster,), "map"))
        await led.until("confirming")
        led.press("agree")
        await led.until("presenting")
        assert led.robot.theta == pytest.approx(-math.pi / 2, abs=0.01)


@in_virtual_time
async def test_a_voice_says_where_to_look_for_visitors(tmp_path: Path) -> None:
    async with await lab(tmp_path, Visitor(-2.0, 0.0, mps=0.0)) as led:
        led.start()
        led.speaks = True
        await led.live(4)
        assert abs(abs(led.robot.theta) - math.pi) < 0.4
