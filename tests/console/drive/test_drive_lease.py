"""The lease, by stepping time."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.console.drive.drive_lease import (
    ANSWER_WITHIN_S,
    HOLD_GAP_S,
    IDLE_AFTER_S,
    LOST_AFTER_S,
    Action,
    AnswerControl,
    AskControl,
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
    st.builds(AskControl, sessions),
    st.builds(AnswerControl, sessions, st.booleans()),
    st.builds(ReleaseControl, sessions),
    st.builds(EmergencyStop, st.booleans()),
    st.just(Tick()),
)


def assert_one_asks_another(lease: Lease) -> None:
    """Who asks for the wheel is connected, and asks one who drives; and never for longer than an answer may take."""
    if lease.asker is not None:
        assert lease.asker in lease.operators
        assert lease.driver is not None
        assert lease.asker != lease.driver


@given(st.lists(st.tuples(events, st.floats(0, 2)), max_size=60))
def test_between_two_holders_there_is_always_a_zero(story: list[tuple[Event, float]]) -> None:
    """Of all commands in their order: one person's never follows another's that moves."""
    lease, now = Lease(), 0.0
    #: The session whose command moves the robot, as the channel has it.
    mover: str | None = None
    for event, wait in story:
        while (due := deadline(lease)) <= now + wait:
            now = max(now, due)
            lease, actions = step(lease, now, Tick())
            assert not any(command.held or command.head_held for command in commands(actions))
            mover = None if commands(actions) else mover
        now += wait
        if not isinstance(event, Connected | EmergencyStop | Tick) and event.session not in lease.operators:
            continue
        lease, actions = step(lease, now, event)
        for command in commands(actions):
            if command.held:
                assert isinstance(event, Drive)
                assert mover in (None, event.session)
                assert lease.driver == event.session
                mover = event.session
            else:
                mover = None
        assert mover is None or mover == lease.driver


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
            assert_one_asks_another(lease)
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
        assert_one_asks_another(lease)
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


def idle_driver(story: Story, for_s: float = 0.0) -> None:
    """Ann has the wheel and holds nothing, but says that she is there."""
    story.hold()
    story.release()
    story.do(KeepAlive("a"), for_s)


def stay(story: Story, until: float) -> list[Action]:
    """Ann's page stays connected; ticks come when they are due."""
    done: list[Action] = []
    while story.now < until:
        story.do(KeepAlive("a"))
        story.do(KeepAlive("b"))
        done += story.do(Tick(), min(0.5, until - story.now))
    return done


def test_who_is_asked_gives_the_wheel_and_the_robot_stops_first() -> None:
    story = Story()
    story.hold()
    assert story.do(AskControl("b")) == ()
    assert (story.lease.driver, story.lease.asker) == ("a", "b")
    assert commands(story.hold()) == [Command("Ann", True, 0.5, 0.0)], "she drives on until she answers"
    actions = story.do(AnswerControl("a", True))
    assert actions[0] == STOP_ANN
    assert notified(actions) == ["b", "a"]
    assert (story.lease.driver, story.lease.asker) == ("b", None)
    assert commands(story.hold("a")) == [], "her key is still down, which counts for nothing"
    assert story.hold("b") == [Command("Bob", True, 0.5, 0.0)]


def test_who_is_asked_may_keep_it_and_is_asked_again() -> None:
    story = Story()
    story.hold()
    story.do(AskControl("b"))
    (notice,) = story.do(AnswerControl("a", False))
    assert notice == PageNotice("b", "warning", "Ann keeps the wheel.")
    assert (story.lease.driver, story.lease.asker) == ("a", None)
    story.do(AskControl("b"))
    assert story.lease.asker == "b"


def test_without_an_answer_a_driver_who_holds_nothing_gives_the_wheel_after_5_s() -> None:
    story = Story()
    idle_driver(story)
    story.do(AskControl("b"))
    asked = story.now
    stay(story, asked + ANSWER_WITHIN_S - 0.01)
    assert story.lease.driver == "a"
    actions = stay(story, asked + ANSWER_WITHIN_S)
    assert story.lease.driver == "b"
    assert commands(actions) == [], "zero was the last command already"
    assert notified(actions) == ["b", "a"]


def test_without_an_answer_a_driver_who_drives_keeps_the_wheel() -> None:
    story = Story()
    story.hold()
    story.do(AskControl("b"))
    asked = story.now
    while story.now < asked + ANSWER_WITHIN_S:
        story.hold(after=0.1)
    (notice,) = story.do(Tick())
    assert isinstance(notice, PageNotice)
    assert (notice.session, notice.text) == ("b", "Ann drives and does not answer: ask again in a moment.")
    assert (story.lease.driver, story.lease.asker) == ("a", None)


def test_a_driver_who_drove_since_the_question_keeps_the_wheel_though_it_stands_just_now() -> None:
    story = Story()
    idle_driver(story)
    story.do(AskControl("b"))
    asked = story.now
    story.hold()
    story.release()
    actions = stay(story, asked + ANSWER_WITHIN_S)
    assert notified(actions) == ["b"]
    assert story.lease.driver == "a"


@pytest.mark.parametrize("end", [Disconnected("a"), ReleaseControl("a")])
def test_a_wheel_that_falls_free_is_who_asked_s_once_the_robot_is_stopped(end: Event) -> None:
    story = Story()
    story.hold()
    story.do(AskControl("b"))
    actions = story.do(end)
    assert actions == (STOP_ANN, PageNotice("b", "info", "You have control."))
    assert story.lease.driver == "b"


def test_the_wheel_of_a_driver_whose_link_is_dead_is_who_asked_s_before_the_5_s() -> None:
    story = Story()
    story.hold()
    story.do(AskControl("b"), 0.1)
    story.do(Tick(), HOLD_GAP_S)
    assert story.lease.driver == "a"
    story.do(Tick(), LOST_AFTER_S)
    assert story.lease.driver == "b"


def test_a_free_wheel_is_given_to_who_asks_and_one_asks_at_a_time() -> None:
    story = Story()
    story.do(Connected("c", "Cleo"))
    story.do(AskControl("a"))
    assert story.lease.driver == "a"
    story.do(AskControl("b"))
    asked = story.lease.asked_at
    assert story.do(AskControl("b"), 1.0) == (), "asking again does not make the answer later"
    assert story.lease.asked_at == asked
    (notice,) = story.do(AskControl("c"))
    assert notice == PageNotice("c", "warning", "Bob asks for the wheel already: wait for the answer.")
    story.do(Disconnected("b"))
    assert story.lease.asker is None
    story.do(AskControl("c"))
    assert story.lease.asker == "c"


def test_an_answer_counts_of_the_driver_alone_and_to_a_question() -> None:
    story = Story()
    story.hold()
    assert story.do(AnswerControl("a", True)) == ()
    story.do(AskControl("b"))
    assert story.do(AnswerControl("b", True)) == ()
    assert story.lease.driver == "a"


def test_a_supervisor_takes_over_at_once_also_before_who_asked() -> None:
    story = Story()
    story.do(Connected("c", "Cleo"))
    story.hold()
    story.do(AskControl("b"))
    actions = story.do(TakeControl("c"))
    assert actions[0] == STOP_ANN
    assert notified(actions) == ["a", "b", "c"]
    assert (story.lease.driver, story.lease.asker) == ("c", None)
