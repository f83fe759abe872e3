"""The lease, by stepping time."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.console.drive.drive_lease import (
    HOLD_GAP_S,
    IDLE_AFTER_S,
    LOST_AFTER_S,
    Action,
    Command,
    Connected,
    Disconnected,
    Drive,
    EmergencyStop,
    Event,
    Garbled,
    KeepAlive,
    Lease,
    PageNotice,
    ReleaseControl,
    TakeControl,
    Tick,
    deadline,
    step,
)

STOP_ANN = Command("Ann", False, 0.0, 0.0)


class Story:
    """Two pages, Ann's and Bob's, and what happened."""

    def __init__(self) -> None:
        self.lease = Lease()
        self.now = 100.0
        self.sequence = 0
        self.do(Connected("a", "Ann"))
        self.do(Connected("b", "Bob"))

    def do(self, event: Event, after: float = 0.0) -> tuple[Action, ...]:
        self.now += after
        self.lease, actions = step(self.lease, self.now, event)
        return actions

    def hold(self, session: str = "a", linear: float = 0.5, angular: float = 0.0, after: float = 0.05) -> list[Action]:
        self.sequence += 1
        return list(self.do(Drive(session, self.sequence, True, linear, angular), after))

    def release(self, session: str = "a") -> list[Action]:
        self.sequence += 1
        return list(self.do(Drive(session, self.sequence, False, 0.0, 0.0), 0.05))


def commands(actions: tuple[Action, ...] | list[Action]) -> list[Command]:
    return [action for action in actions if isinstance(action, Command)]


def notified(actions: tuple[Action, ...] | list[Action]) -> list[str]:
    return [action.session for action in actions if isinstance(action, PageNotice)]


def test_the_first_held_drive_takes_the_wheel() -> None:
    story = Story()
    assert story.release() == []
    assert story.lease.driver is None
    assert story.hold() == [Command("Ann", True, 0.5, 0.0)]
    assert story.lease.driver == "a"
    assert story.release() == [STOP_ANN]
    assert story.release() == []
    assert story.lease.driver == "a"


def test_another_is_refused_with_one_notice_for_each_hold() -> None:
    story = Story()
    story.hold()
    first = story.hold("b")
    assert commands(first) == []
    assert notified(first) == ["b"]
    assert story.hold("b") == []
    story.release("b")
    assert notified(story.hold("b")) == ["b"]
    assert story.hold() == [Command("Ann", True, 0.5, 0.0)]


def test_a_refused_hold_does_not_drive_off_when_the_wheel_falls_free() -> None:
    story = Story()
    story.hold()
    story.hold("b")
    assert commands(story.do(ReleaseControl("a"))) == [STOP_ANN]
    assert story.hold("b") == []
    story.release("b")
    assert commands(story.hold("b")) == [Command("Bob", True, 0.5, 0.0)]


def test_taking_control_stops_first_then_notifies() -> None:
    story = Story()
    story.hold()
    actions = story.do(TakeControl("b"))
    assert actions[0] == STOP_ANN
    assert notified(actions) == ["a", "b"]
    assert story.lease.driver == "b"
    assert commands(story.hold("a")) == []
    assert story.hold("b") == [Command("Bob", True, 0.5, 0.0)]


def test_the_end_of_the_connection_stops_at_once() -> None:
    story = Story()
    story.hold()
    assert story.do(Disconnected("a")) == (STOP_ANN,)
    assert story.lease.driver is None
    assert "a" not in story.lease.operators


def test_a_spectator_who_leaves_stops_no_driver() -> None:
    story = Story()
    story.hold()
    assert story.do(Disconnected("b")) == ()
    assert story.lease.driver == "a"


def test_silence_while_held_stops_and_words_go_on() -> None:
    story = Story()
    story.hold()
    assert deadline(story.lease) == pytest.approx(story.now + HOLD_GAP_S)
    assert story.do(Tick(), HOLD_GAP_S - 0.01) == ()
    assert story.do(Tick(), 0.01) == (STOP_ANN,)
    assert story.lease.driver == "a"
    assert story.hold() == [Command("Ann", True, 0.5, 0.0)]


def test_a_driver_who_says_nothing_at_all_is_lost() -> None:
    story = Story()
    story.hold()
    story.release()
    assert deadline(story.lease) == pytest.approx(story.now + LOST_AFTER_S)
    story.do(KeepAlive("a"), 0.9)
    story.do(Tick(), 0.9)
    assert story.lease.driver == "a"
    story.do(Tick(), 0.1)
    assert story.lease.driver is None


def test_a_driver_who_holds_nothing_for_long_gives_up_the_wheel() -> None:
    story = Story()
    story.hold()
    story.release()
    held = story.lease.last_held
    while story.now + 0.5 < held + IDLE_AFTER_S:
        story.do(KeepAlive("a"), 0.5)
        story.do(Tick())
        assert story.lease.driver == "a"
    story.do(KeepAlive("a"), 0.5)
    story.do(Tick(), 0.2)
    assert story.lease.driver is None
    assert deadline(story.lease) == math.inf


@pytest.mark.parametrize(("linear", "angular"), [(1.01, 0), (0, -2), (math.nan, 0), (0, math.inf)])
def test_what_is_out_of_range_is_refused_and_stops(linear: float, angular: float) -> None:
    story = Story()
    assert commands(story.hold(linear=linear, angular=angular)) == []
    assert story.lease.driver is None
    story.release()
    story.hold()
    actions = story.hold(linear=linear, angular=angular)
    assert commands(actions) == [STOP_ANN]
    assert notified(actions) == ["a"]
    # That hold is over.
    assert story.hold() == []


def test_what_cannot_be_read_stops_who_drives() -> None:
    story = Story()
    story.hold()
    assert commands(story.do(Garbled("b"))) == []
    actions = story.do(Garbled("a"))
    assert commands(actions) == [STOP_ANN]
    assert notified(actions) == ["a"]


def test_the_emergency_stop_ends_the_hold_until_pressed_again() -> None:
    story = Story()
    story.hold()
    actions = story.do(EmergencyStop(True))
    assert commands(actions) == [STOP_ANN]
    assert notified(actions) == ["a"]
    assert story.hold() == []
    assert notified(story.hold("b")) == ["b"]
    assert story.do(EmergencyStop(True)) == ()
    assert story.do(EmergencyStop(False)) == ()
    assert story.hold() == []
    story.release()
    assert story.hold() == [Command("Ann", True, 0.5, 0.0)]


def test_an_older_command_does_not_come_back() -> None:
    story = Story()
    story.hold(linear=1.0)
    assert story.do(Drive("a", 0, True, -1.0, 0.0)) == ()


sessions = st.sampled_from(["a", "b", "c"])
axis = st.one_of(st.floats(-1, 1), st.sampled_from([math.nan, 1.5, -math.inf]))
events = st.one_of(
    st.builds(Connected, sessions, st.just("Cleo")),
    st.builds(Disconnected, sessions),
    st.builds(KeepAlive, sessions),
    st.builds(Drive, sessions, st.integers(0, 50), st.booleans(), axis, axis),
    st.builds(Garbled, sessions),
    st.builds(TakeControl, sessions),
    st.builds(ReleaseControl, sessions),
    st.builds(EmergencyStop, st.booleans()),
    st.just(Tick()),
)


@given(st.lists(st.tuples(events, st.floats(0, 2)), max_size=60))
def test_whatever_happens_nothing_moves_without_a_fresh_hold(story: list[tuple[Event, float]]) -> None:
    """Commands to move come from the driver alone, in range; each deadline and each change stops the robot."""
    lease, now = Lease(), 0.0
    moving = False
    for event, wait in story:
        # Ticks come when they are due, as the shell's timer has it.
        while (due := deadline(lease)) <= now + wait:
            now = max(now, due)
            lease, actions = step(lease, now, Tick())
            moving = commands(actions)[-1].held if commands(actions) else moving
            assert deadline(lease) > now
        now += wait
        if not isinstance(event, Connected | EmergencyStop | Tick) and event.session not in lease.operators:
            continue
        before = lease
        lease, actions = step(lease, now, event)
        for command in commands(actions):
            moving = command.held
            assert abs(command.linear) <= 1
            assert abs(command.angular) <= 1
            if command.held:
                assert isinstance(event, Drive)
                assert event.held
                assert lease.driver == event.session
                assert not lease.e_stopped
        assert moving == lease.moving
        assert not (lease.moving and lease.e_stopped)
        assert lease.driver is None or lease.driver in lease.operators
        if before.driver != lease.driver and before.moving:
            assert any(not command.held for command in commands(actions))


def test_a_sideways_command_goes_through_and_is_bounded_like_the_others() -> None:
    story = Story()
    assert story.do(Drive("a", 1, True, 0.0, 0.0, lateral=-0.5)) == (Command("Ann", True, 0.0, 0.0, lateral=-0.5),)
    stop, notice = story.do(Drive("a", 2, True, 0.0, 0.0, lateral=1.5))
    assert stop == Command("Ann", False, 0.0, 0.0)
    assert isinstance(notice, PageNotice)
    assert notice.text == "Drive commands go from -1 to 1, not 1.5: refused."


def hold_head(story: Story, pan: float, session: str = "a", held: bool = False, linear: float = 0.0) -> list[Action]:
    story.sequence += 1
    drive = Drive(session, story.sequence, held, linear, 0.0, head_held=True, pan=pan, tilt=-0.5)
    return list(story.do(drive, 0.05))


def test_holding_the_head_takes_the_wheel_and_moves_the_head_alone() -> None:
    story = Story()
    assert hold_head(story, 0.5) == [Command("Ann", False, 0.0, 0.0, head_held=True, pan=0.5, tilt=-0.5)]
    assert story.lease.driver == "a"
    refused = hold_head(story, 0.5, "b")
    assert [type(action) for action in refused] == [PageNotice]
    both = hold_head(story, 1.0, held=True, linear=0.7)
    assert both == [Command("Ann", True, 0.7, 0.0, head_held=True, pan=1.0, tilt=-0.5)]
    assert story.hold(linear=0.7) == [Command("Ann", True, 0.7, 0.0)], "the head is let go of, the base goes on"


@pytest.mark.parametrize("end", [Disconnected("a"), TakeControl("b"), EmergencyStop(True), Garbled("a")])
def test_whatever_ends_a_hold_ends_that_of_the_head(end: Event) -> None:
    story = Story()
    hold_head(story, 0.5)
    assert commands(story.do(end)) == [STOP_ANN]


def test_a_hold_of_the_head_that_is_not_renewed_ends() -> None:
    story = Story()
    hold_head(story, 0.5)
    assert deadline(story.lease) == pytest.approx(story.now + HOLD_GAP_S)
    assert commands(story.do(Tick(), HOLD_GAP_S)) == [STOP_ANN]


def test_what_is_not_held_moves_nothing_whatever_it_says_and_what_is_beyond_the_stick_is_refused() -> None:
    story = Story()
    (command,) = commands(story.do(Drive("a", 1, True, 0.5, 0.0, head_held=False, pan=1.0)))
    assert command == Command("Ann", True, 0.5, 0.0)
    actions = story.do(Drive("a", 2, False, 0.0, 0.0, head_held=True, pan=math.nan))
    assert commands(actions) == [STOP_ANN]
    assert any(isinstance(each, PageNotice) and "from -1 to 1, not nan" in each.text for each in actions)
