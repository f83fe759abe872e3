"""A run that was under way when the program ended: how it goes on, and TourGuide in a program that is started again."""

from __future__ import annotations

import asyncio
import math
from dataclasses import replace
from pathlib import Path

import pytest

from app.maps.map_service import MapService
from app.messages.tours import TourState
from app.modules.motivations.tour_guide.kept import KeptRun, read_kept
from app.modules.motivations.tour_guide.progress import View
from app.modules.motivations.tour_guide.resumption import Resumption
from app.runtime.clock import in_virtual_time
from app.tours.run_service import TourRefused
from app.tours.tour_file import digest
from tests.modules.motivations.tour_guide.lab_tour import PLACES, lab
from tests.modules.motivations.tour_guide.led_lab import LabMaps, LedLab, Visitor
from tests.modules.motivations.tour_guide.run import LAB, Run, say, stop

AT = 1_795_000_000.0
SEEN = View(5.0, people=2, farthest_m=1.0, near=2)
GONE = replace(SEEN, people=0, near=0)


def kept(run: Run) -> Resumption:
    return Resumption(KeptRun(digest(LAB), AT, run.progress, pose=(4.0, 1.0, 0.5)), LAB)


def leading() -> Run:
    return Run().started().until("leading")


async def interrupted(tmp_path: Path, state: TourState) -> LedLab:
    """The program after one that ended in ``state``; robot and visitors are where they were."""
    first = await lab(tmp_path)
    async with first as led:
        led.start()
        await led.until("confirming")
        led.press("agree")
        await led.until(state)
        await led.live(1.0)
    second = await asyncio.to_thread(LedLab, tmp_path, first.tour, PLACES)
    second.robot, second.visitors = first.robot, first.visitors
    return second


def test_it_waits_for_its_pose_and_then_for_visitors() -> None:
    run, at = leading(), AT + 30
    resumed = kept(run)
    assert [wish.cls for wish in resumed.wishes(at)] == ["SLAM", "LocateFaces", "TrackPersons"]
    assert resumed.waits(at, GONE, localized=False)
    assert resumed.wishes(at + 20)
    assert resumed.waits(at + 20, GONE, localized=True)
    assert resumed.wishes(at + 29)
    assert not resumed.waits(at + 29, SEEN, localized=True)
    again = resumed.progress(at + 29, SEEN, run.scene, localized=True)
    assert (again.state, again.excuse) == ("leading", "again")


def test_it_waits_for_visitors_some_seconds_from_when_it_knows_where_it_is() -> None:
    run, at = leading(), AT + 30
    resumed = kept(run)
    assert resumed.wishes(at)
    assert resumed.waits(at, GONE, localized=True)
    assert resumed.wishes(at + 9.9)
    assert resumed.waits(at + 9.9, GONE, localized=True)
    assert resumed.wishes(at + 10.1) == ()
    again = resumed.progress(at + 10.1, GONE, run.scene, localized=True)
    assert (again.state, again.reason) == ("going_home", "no visitor was there when the program was back")


def test_a_robot_that_does_not_find_its_pose_ends_the_run() -> None:
    run, at = leading(), AT + 30
    resumed = kept(run)
    assert resumed.wishes(at)
    assert resumed.wishes(at + 59)
    assert resumed.wishes(at + 61) == ()
    again = resumed.progress(at + 61, SEEN, run.scene, localized=False)
    assert (again.state, again.reason) == ("idle", "the robot does not know where it is on the map lab")


def test_an_emergency_stop_meanwhile_is_a_pause_which_waits_for_nothing_else() -> None:
    run, stopped = leading(), replace(GONE, e_stop=True)
    resumed = kept(run)
    assert resumed.wishes(AT + 1)
    assert resumed.interrupt(stopped, run.scene)
    assert not resumed.interrupt(stopped, run.scene), "once"
    assert (resumed.kept.progress.state, resumed.kept.progress.to_press) == ("paused", True)
    assert not resumed.waits(AT + 1.2, stopped, localized=False)
    again = resumed.progress(AT + 1.2, stopped, run.scene, localized=False)
    assert (again.state, again.resume) == ("paused", "leading")


def test_a_tour_that_only_waits_for_visitors_is_gone_on_with_at_once() -> None:
    run = Run()
    resumed = kept(run)
    assert resumed.wishes(AT) == ()
    assert not resumed.interrupt(replace(SEEN, e_stop=True), run.scene)
    assert resumed.progress(AT, SEEN, run.scene, localized=False).state == "idle"


@in_virtual_time
async def test_the_map_of_the_tour_is_taken_into_use_once_and_only_for_a_fresh_run() -> None:
    for run, since_s, loads in ((leading(), 60.0, 1), (leading(), 601.0, 0), (Run(), 60.0, 0)):
        maps, server = MapService(), LabMaps()
        server.name = ""
        resumed = kept(run)
        await resumed.take_map(maps, AT + since_s)  # nothing makes a map yet
        maps.attach(server)  # type: ignore[arg-type]  # what is asked of it
        for _ in range(2):
            await resumed.take_map(maps, AT + since_s)
        assert [name for name, _ in server.loaded] == ["lab"] * loads


@pytest.mark.slow
@in_virtual_time
async def test_a_program_that_is_started_again_goes_on(tmp_path: Path) -> None:
    first = await lab(tmp_path, stops=[stop("one", do=[say("First. Second. Third.")]), stop("two")])
    async with first as led:
        led.start()
        await led.until("confirming")
        led.press("agree")
        await led.until("presenting")
        await led.live(2.0)
        robot, visitors = led.robot, led.visitors
    assert first.workspace.desires() == ()
    kept = await asyncio.to_thread(first.runs.kept)
    assert kept is not None
    known = read_kept(kept)
    assert known is not None
    assert (known.progress.state, known.progress.stop, known.progress.sentence) == ("presenting", 0, 1)
    second = await asyncio.to_thread(LedLab, tmp_path, first.tour, PLACES)
    second.robot, second.visitors = robot, visitors
    async with second as led:
        await led.until("presenting", limit_s=20)
        await led.until("leading", limit_s=20)
        assert led.said == ["I was interrupted. Let us go on.", "Second. Third."]
        assert led.server.report is not None
        assert led.server.report.people_most == 2
        await led.until("idle")
        assert led.progress.presented == ("one", "two")


@pytest.mark.slow
@in_virtual_time
async def test_after_the_emergency_stop_a_waiting_tour_waits_for_a_press_after_a_restart_too(
    tmp_path: Path,
) -> None:
    first = await lab(tmp_path, Visitor(9.0, 0.0, mps=0.0))
    async with first as led:
        led.start(waits=True)
        await led.live(1)
        led.e_stop = True
        await led.live(1)
        led.e_stop = False
        led.visitors = [Visitor(2.0, 1.0)]
        await led.live(10)
        assert (led.progress.state, led.progress.buttons, led.moving()) == ("idle", ("resume",), [])
        assert led.progress.reason == "the emergency stop was pressed: press Resume"
        with pytest.raises(TourRefused, match="start does nothing"):
            led.press("start")
    second = await asyncio.to_thread(LedLab, tmp_path, first.tour, PLACES)
    second.visitors = [Visitor(2.0, 1.0)]
    async with second as led:
        await led.live(10)
        assert (led.progress.state, led.progress.waits, led.moving()) == ("idle", True, [])
        led.press("resume")
        await led.until("inviting", limit_s=5)


@pytest.mark.slow
@in_virtual_time
async def test_an_emergency_stop_before_a_kept_run_goes_on_is_a_pause(tmp_path: Path) -> None:
    second = await interrupted(tmp_path, "leading")
    visitors, second.visitors = second.visitors, []
    second.localization, second.e_stop = "lost", True
    async with second as led:
        led.e_stop, led.localization, led.visitors = False, "tracking", visitors
        await led.live(20)
        assert (led.progress.state, led.moving()) == ("paused", [])
        assert led.progress.reason == "the emergency stop was pressed"
        led.press("resume")
        await led.until("leading", limit_s=5)


@pytest.mark.slow
@in_virtual_time
async def test_a_program_that_is_started_again_takes_the_map_of_the_tour_into_use(tmp_path: Path) -> None:
    second = await interrupted(tmp_path, "presenting")
    second.maps.name, robot = "", second.robot
    async with second as led:
        ((name, X_MB),) = led.maps.loaded
        assert name == "lab"
        assert X_MB is not None
        assert math.dist((X_MB.x, X_MB.y), (robot.x, robot.y)) < 0.5
        await led.until("leading", limit_s=30)


@pytest.mark.slow
@in_virtual_time
async def test_a_map_that_is_gone_is_said_when_a_tour_cannot_go_on(tmp_path: Path) -> None:
    first = await lab(tmp_path)
    async with first as led:
        led.start()
        await led.until("confirming")
        led.press("agree")
        await led.until("leading")
    second = await asyncio.to_thread(LedLab, tmp_path, first.tour, PLACES)
    second.maps.name, second.maps.has = "", ()
    async with second as led:
        await led.live(65)
        assert (led.progress.state, led.moving()) == ("idle", [])
        assert led.progress.reason == "the map lab cannot be taken into use: there is no map lab"


@pytest.mark.slow
@in_virtual_time
async def test_a_program_that_is_started_elsewhere_says_why_it_does_not_go_on(tmp_path: Path) -> None:
    first = await lab(tmp_path)
    async with first as led:
        led.start()
        await led.until("confirming")
        led.press("agree")
        await led.until("leading")
        await led.live(1.0)
    second = await asyncio.to_thread(LedLab, tmp_path, first.tour, PLACES)
    second.localization = "lost"
    async with second as led:
        with pytest.raises(TourRefused, match="is being resumed"):
            led.start()
        await led.live(65)
        assert (led.progress.state, led.moving()) == ("idle", [])
        assert led.progress.reason == "the robot does not know where it is on the map lab"
        (report,) = await asyncio.to_thread(led.runs.reports)
        assert report.outcome == led.progress.reason
    assert await asyncio.to_thread(second.runs.kept) is None
