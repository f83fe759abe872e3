"""States become events, one for each change."""

from __future__ import annotations

from dataclasses import replace
from itertools import groupby

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.attention.exploitation import ExploitationChange
from app.attention.timeline import Timeline
from app.messages import GroupStatus, LinkStatus, PerceptEvent, PerceptKind, Twist
from app.program.timeline_feed import (
    FOLLOWS_AFTER_S,
    OVERLOAD_WINDOWS,
    SLOW_AFTER_S,
    STALE_LOOKS,
    WELL_AFTER_S,
    TimelineFeed,
)
from app.runtime.freshness import Freshness, FreshnessState
from app.runtime.load import CpuLoad
from app.runtime.supervisor import ModuleState

STILL = Twist(0.0, 0.0, 0.0)
LIVE = Freshness("live", 0.02, 0.3, 40.0, 39.8)
STATUS = LinkStatus(0.0, "idle", "standing; no command", False, None, STILL, 1.0)


@pytest.fixture
def timeline() -> Timeline:
    return Timeline(100, lambda: 5.0)


@pytest.fixture
def feed(timeline: Timeline) -> TimelineFeed:
    return TimelineFeed(timeline, {"Eye": 10.0}, [PerceptKind("smoke", "smoke before {subject}")])


def entries(timeline: Timeline) -> list[tuple[str, str]]:
    """Kind and subject of everything noted."""
    return [(event.kind, event.subject) for event in timeline.query()]


def test_the_guard_is_noted_when_its_state_changes(feed: TimelineFeed, timeline: Timeline) -> None:
    stopped = replace(STATUS, guard="e_stopped", reason="pressed by an operator", e_stopped=True)
    for status in (STATUS, STATUS, stopped, stopped, STATUS):
        feed.guard(status)
    assert entries(timeline) == [("guard", "idle"), ("guard", "e_stopped"), ("guard", "idle")]
    assert timeline.query()[1].text == "Emergency stop: pressed by an operator"
    assert timeline.query()[1].data["e_stopped"] is True


def test_what_the_guard_says_is_not_said_twice(feed: TimelineFeed, timeline: Timeline) -> None:
    feed.guard(replace(STATUS, guard="e_stopped", reason="emergency stop: pressed by Ann", e_stopped=True))
    feed.guard(replace(STATUS, reason=""))
    assert [event.text for event in timeline.query()] == ["Emergency stop: pressed by Ann", "The base rests"]


def test_joints_that_refuse_are_noted_once_and_again_when_they_follow(feed: TimelineFeed, timeline: Timeline) -> None:
    stamp = 0.0

    def seconds(count: float, guard: str, reason: str = "") -> None:
        nonlocal stamp
        for _ in range(int(20 * count)):
            stamp += 0.05
            feed.guard(replace(STATUS, stamp=stamp, groups=(GroupStatus("left_arm", guard, reason, 0.0),)))

    seconds(1, "moving")
    for reason in ("the action rejected the goal", "again"):
        seconds(1, "refused", reason)
        seconds(1, "moving")  # it is tried again
        seconds(5, "holding", "no fresh command")
    seconds(FOLLOWS_AFTER_S + 0.2, "moving")
    seconds(0.1, "refused", "the action aborted the goal")
    assert [event.text for event in timeline.query()[1:]] == [
        "The left arm does not follow: the action rejected the goal",
        "The left arm follows commands again",
        "The left arm does not follow: the action aborted the goal",
    ]


def test_a_slow_world_is_noted_when_it_lasts_and_when_it_is_over(feed: TimelineFeed, timeline: Timeline) -> None:
    stamp = 0.0

    def seconds(count: float, rate: float) -> None:
        nonlocal stamp
        for _ in range(int(20 * count)):
            stamp += 0.05
            feed.guard(replace(STATUS, stamp=stamp, world_rate=rate))

    for _ in range(5):
        seconds(SLOW_AFTER_S - 0.5, 0.8)
        seconds(1, 1.0)
    assert timeline.query(kinds=["overload"]) == ()
    seconds(SLOW_AFTER_S + 1, 0.8)
    seconds(WELL_AFTER_S - 1, 1.0)
    seconds(1, 0.9)
    assert ["0.80" in event.text for event in timeline.query(kinds=["overload"])] == [True]
    seconds(WELL_AFTER_S + 1, 1.0)
    assert "again" in timeline.query(kinds=["overload"])[-1].text


def test_the_begin_and_the_end_of_exploitation_are_noted(feed: TimelineFeed, timeline: Timeline) -> None:
    for group, behavior, exploited in (("base", "Teleop", True), ("head", "LookAt", True), ("base", "Teleop", False)):
        feed.exploitation(ExploitationChange(0.0, group, behavior, exploited), {"Some"})
    events = timeline.query()
    assert [event.text for event in events] == ["Teleop drives", "LookAt moves the head", "Teleop drives no more"]
    assert events[1].subject == "LookAt"
    assert events[1].data == {"group": "head", "exploited": True, "classes": ["Some"]}


def test_a_module_is_noted_when_it_fails_and_when_it_is_back(feed: TimelineFeed, timeline: Timeline) -> None:
    running = ModuleState("Eye", "running", 0.0)
    failed = ModuleState("Eye", "failed", 1.0, 0, "ValueError: no light")
    for state in (running, failed, replace(running, restarts=1)):
        feed.module(state)
    assert entries(timeline) == [("module", "Eye"), ("restart", "Eye")]
    assert timeline.query()[0].text == "Eye failed: ValueError: no light"


@pytest.mark.parametrize(
    ("name", "subject", "words"),
    [
        ("code.leaves", "tour:office", "QR code tour:office leaves"),
        ("noise.appears", "", "Loud noise appears"),
        ("dog.changes", "rex", "Dog rex changes"),
        ("smoke.appears", "kinect", "Smoke before kinect appears"),
        ("{odd}.appears", "{0}", "{odd} {0} appears"),
    ],
)
def test_percepts_are_noted_with_their_own_stamp_under_their_name(
    feed: TimelineFeed, timeline: Timeline, name: str, subject: str, words: str
) -> None:
    feed.percept(PerceptEvent(4.5, name, name.partition(".")[0], subject, "kinect", 3.0, 1.0, None, None))
    (event,) = timeline.query()
    assert (event.stamp, event.kind, event.subject, event.text) == (4.5, "percept", name, words)
    label = event.data["label"]
    assert words == f"{label[0].upper()}{label[1:]} {name.partition('.')[2]}"


def test_overload_is_noted_when_it_lasts_and_when_it_is_over(feed: TimelineFeed, timeline: Timeline) -> None:
    def window(used: float) -> None:
        feed.load(CpuLoad(0.0, 1.0, {"Eye": used}, used))

    window(50.0)
    window(5.0)
    assert entries(timeline) == []
    for _ in range(OVERLOAD_WINDOWS + 2):
        window(20.0)
    assert entries(timeline) == [("overload", "Eye")]
    window(5.0)
    window(5.0)
    assert [event.text for event in timeline.query()] == [
        "Eye uses 20 % of a core, 10 % is its budget",
        "Eye is within its budget again",
    ]


def test_a_stale_channel_is_noted_once_with_its_age_and_what_it_means(feed: TimelineFeed, timeline: Timeline) -> None:
    feed.freshness({"scan": LIVE})
    for age in (0.5, 1.5, 2.5, 3.5):
        feed.freshness({"scan": Freshness("stale", age, 0.3, 40.0, 12.0)})
    feed.freshness({"scan": LIVE})
    feed.freshness({"scan": LIVE})
    entered, left = timeline.query()
    assert (entered.kind, entered.subject) == ("stale", "scan")
    assert (entered.data["age_s"], entered.data["state"]) == (1.5, "stale")
    assert entered.text == (
        "scan is stale: its newest message is 1.50 s old, 0.30 s allowed at the 40 messages a second asked for; "
        "whatever builds on it does without news"
    )
    assert (left.kind, left.subject, left.text) == ("stale", "scan", "scan is up to date again")


@pytest.mark.parametrize(
    ("freshness", "words"),
    [
        (Freshness("stale", None, 0.3, 15.0), "nothing has come yet"),
        (Freshness("stale", 4.0, None, None), "the module behind it does not run"),
    ],
)
def test_silent_and_rare_channels_are_distinguished(timeline: Timeline, freshness: Freshness, words: str) -> None:
    feed = TimelineFeed(timeline, {})
    for _ in range(STALE_LOOKS):
        feed.freshness({"kinect": freshness})
    (event,) = timeline.query()
    assert words in event.text


def test_a_stale_channel_that_is_closed_is_no_alarm(timeline: Timeline) -> None:
    feed = TimelineFeed(timeline, {})
    for age in (3.0, 4.0):
        feed.freshness({"kinect": Freshness("stale", age, 0.3, 15.0)})
    feed.freshness({"kinect": Freshness("closed", 5.0, None, 0.0)})
    assert "no subscription is open" in timeline.query()[-1].text


@given(st.lists(st.sampled_from(("live", "waiting", "stale", "closed"))))
def test_entering_and_leaving_take_turns(states: list[FreshnessState]) -> None:
    timeline = Timeline(1000, lambda: 7.0)
    feed = TimelineFeed(timeline, {})
    for state in states:
        feed.freshness({"scan": Freshness(state, 1.0, 0.3, 40.0)})
    noted = [event.data["state"] == "stale" for event in timeline.query(kinds={"stale"})]
    assert noted == [number % 2 == 0 for number in range(len(noted))]
    spells = [len(list(spell)) for stale, spell in groupby(states, lambda state: state == "stale") if stale]
    assert noted.count(True) == sum(looks >= STALE_LOOKS for looks in spells)
    assert noted.count(True) - noted.count(False) == (states[-STALE_LOOKS:] == ["stale"] * STALE_LOOKS)


def test_whatever_comes_after_forgetting_is_news(feed: TimelineFeed, timeline: Timeline) -> None:
    def tell() -> None:
        feed.guard(STATUS)
        for _ in range(STALE_LOOKS):
            feed.freshness({"scan": replace(LIVE, state="stale")})
        for _ in range(OVERLOAD_WINDOWS):
            feed.load(CpuLoad(1.0, 1.0, {"Eye": 50.0}, 60.0))

    tell()
    once = entries(timeline)
    tell()
    assert entries(timeline) == once
    feed.reset()
    tell()
    assert entries(timeline) == once * 2
