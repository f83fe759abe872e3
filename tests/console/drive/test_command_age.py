"""How old a command is at most, under any delays: the estimate alone, and the gate on stepped time."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.console.drive import drive_lease
from app.console.drive.command_age import (
    DRIFT,
    FULL_VIEW_ALLOWANCE_S,
    FUTURE,
    LASTING_S,
    LEAST_LIMIT,
    UNTIMED,
    VIEW_ALLOWANCE_S,
    WINDOW_S,
    CommandAge,
    Judgement,
    Times,
)

VALIDITY_S = 0.4
FULL_SPEED_S = 0.2
delays = st.floats(0.0, 30.0)


class Link:
    """A page's clock, ``offset`` behind the robot's and ``drift`` too fast, and a link of given delays (s)."""

    def __init__(self, offset: float = 1e6, drift: float = 0.0, validity_s: float = VALIDITY_S) -> None:
        self.offset = offset
        self.drift = drift
        self.age = CommandAge(validity_s, FULL_SPEED_S)
        self.heard = 0.0

    def page_time(self, robot: float) -> float:
        """The page's clock when the robot's says ``robot``."""
        return (robot - self.offset) * (1 + self.drift)

    def send(self, at: float, *, down: float, up: float, think: float = 0.0) -> Judgement:
        """The robot says something at ``at``; the page hears it ``down`` later, waits ``think`` and sends; that takes
        ``up``."""
        heard_at, sent = at + down, at + down + think
        return self.age.judge(sent + up, Times(self.page_time(sent), at, self.page_time(heard_at)))


@given(
    st.lists(st.tuples(st.floats(0.0, 20.0), delays, delays, delays), min_size=1, max_size=40),
    st.floats(-1e9, 1e9),
    st.floats(-0.9 * DRIFT, 0.9 * DRIFT),
)
def test_no_delay_makes_a_command_younger_than_it_is(
    messages: list[tuple[float, float, float, float]], offset: float, drift: float
) -> None:
    link, at, arrival = Link(offset, drift), 1e6, 0.0
    for pause, down, up, think in messages:
        at += pause
        # In order, as TCP gives them.
        up = max(up, arrival - (at + down + think))
        arrival = at + down + think + up
        judged = link.send(at, down=down, up=up, think=think)
        assert judged.cause != FUTURE
        assert judged.age_s is not None
        assert judged.age_s >= up
        if up > VALIDITY_S:
            assert judged.cause


@given(st.floats(0.0, 0.1), st.floats(0.0, 0.1), st.floats(-0.9 * DRIFT, 0.9 * DRIFT))
def test_on_a_quick_link_commands_are_valid(down: float, up: float, drift: float) -> None:
    link = Link(drift=drift)
    for beat in range(100):
        judged = link.send(1e6 + beat * WINDOW_S / 10, down=down, up=up, think=0.05)
        assert judged.cause == ""
        assert judged.age_s == pytest.approx(up, abs=down + 0.02 + 2 * DRIFT * WINDOW_S + 0.001)


def test_one_quick_answer_counts_and_expires() -> None:
    link = Link()
    assert link.send(0.0, down=0.0, up=0.1).cause == ""
    # The robot's words take longer now; the page's do not.
    assert link.send(10.0, down=0.3, up=0.3).cause == ""
    assert link.send(10.0 + WINDOW_S + 1, down=0.3, up=0.3).cause != ""


@pytest.mark.parametrize(
    ("down", "up", "words"),
    [
        (0.0, 0.5, "Commands arrive up to 0.5 s late"),
        (0.0, 3.0, "Commands arrive up to 3.0 s late"),
        (3.0, 0.0, "Commands arrive up to 3.0 s late"),
        (3.0, 3.0, "Commands arrive up to 6.0 s late"),
        (0.0, 3000.0, "Commands arrive up to many minutes late"),
    ],
)
def test_a_slow_link_is_described_in_words(down: float, up: float, words: str) -> None:
    judged = Link().send(1e6, down=down, up=up)
    assert judged.cause == words


def test_who_sees_an_old_robot_does_not_drive_it() -> None:
    """The way to the page alone has become slow: its commands are in time, but what its operator sees is not."""
    link = Link()
    assert link.send(1e6, down=0.0, up=0.0).cause == ""
    assert link.send(1e6 + 1, down=VIEW_ALLOWANCE_S, up=0.1).cause == ""
    assert link.send(1e6 + 2, down=3.0, up=0.1).cause == "What you see is 3.1 s old"


def test_what_lasts_is_distinguished_from_a_hitch() -> None:
    link = Link()
    assert not link.send(0.0, down=0.0, up=0.01).lasting
    late = link.send(1.0, down=0.0, up=1.0)
    assert late.cause
    assert not late.lasting
    assert link.age.last == late
    assert link.send(2.1, down=0.0, up=0.01).cause == ""
    assert not link.send(3.0, down=0.0, up=1.0).lasting
    assert link.send(3.0 + LASTING_S, down=0.0, up=1.0).lasting


def test_who_says_no_time_is_refused() -> None:
    assert CommandAge(VALIDITY_S).judge(1.0, None) == Judgement(UNTIMED, lasting=True)


@pytest.mark.parametrize(
    "times",
    [
        Times(20.0, 99.0, 9.0),  # sent ten seconds from now
        Times(10.0, 109.0, 9.0),  # has heard what the robot has not said yet
        Times(10.0, 99.0, -1e300),
        Times(1e308, 99.0, 9.0),
    ],
)
def test_a_time_that_cannot_be_is_refused_and_not_remembered(times: Times) -> None:
    age = CommandAge(VALIDITY_S)
    assert age.judge(100.0, Times(10.0, 99.95, 9.95)).cause == ""
    assert age.judge(100.0, times).cause == FUTURE
    assert age.judge(100.0, times).cause == FUTURE
    assert age.judge(100.1, Times(10.1, 100.0, 10.0)).cause == ""


def test_a_page_whose_clock_stood_still_is_understood_again_at_once() -> None:
    """As browsers' do while the computer sleeps."""
    age = CommandAge(VALIDITY_S)
    assert age.judge(100.0, Times(10.0, 99.9, 9.9)).cause == ""
    assert age.judge(160.0, Times(10.1, 159.9, 10.0)).cause == ""


@given(st.lists(st.tuples(st.floats(-1e9, 1e9), st.floats(-1e9, 1e9), st.floats(-1e9, 1e9)), max_size=30))
def test_nothing_that_a_client_says_breaks_it(said: list[tuple[float, float, float]]) -> None:
    age = CommandAge(VALIDITY_S)
    for number, (sent, heard, heard_at) in enumerate(said):
        judged = age.judge(100.0 + number, Times(sent, heard, heard_at))
        assert judged.cause or (heard <= 100.1 + number and heard >= number + 99.0)


# --- The gate: late holds drive nothing ------------------------------------------------------------------------------


def drive(lease: drive_lease.Lease, judged: Judgement, now: float, seq: int, *, held: bool = True) -> drive_lease.Step:
    speed = 1.0 if held else 0.0
    return drive_lease.step(
        lease, now, drive_lease.Drive("a", seq, held, speed, 0.0, False, judged.cause, judged.lasting)
    )


@given(
    st.lists(st.tuples(st.floats(0.01, 0.3), st.booleans(), delays), min_size=2, max_size=60),
    st.floats(0.0, 3.0),
)
def test_whatever_the_link_does_no_wheel_turns_on_an_old_command(
    beats: list[tuple[float, bool, float]], down: float
) -> None:
    """Every held command that comes out was given within its validity, and each release stops at once, however late."""
    link = Link()
    lease, _ = drive_lease.step(drive_lease.Lease(), 1e6, drive_lease.Connected("a", "Ann"))
    at = arrival = 1e6
    for seq, (pause, held, up) in enumerate(beats):
        at += pause
        arrival = max(arrival, at + up)
        heard = at - down
        judged = link.age.judge(arrival, Times(link.page_time(at), heard, link.page_time(at)))
        lease, actions = drive(lease, judged, arrival, seq, held=held)
        for action in actions:
            if isinstance(action, drive_lease.Command) and action.held:
                assert held
                assert arrival - at <= VALIDITY_S
        if not held or judged.cause:
            assert not lease.moving


def test_a_hitch_stops_and_goes_on_but_what_lasts_must_be_pressed_again() -> None:
    lease, _ = drive_lease.step(drive_lease.Lease(), 0.0, drive_lease.Connected("a", "Ann"))
    fresh, late = Judgement(age_s=0.1), Judgement("Commands arrive up to 3.0 s late", 3.0)
    lasting = Judgement(late.cause, 3.0, lasting=True)
    stop = drive_lease.Command("Ann", False, 0.0, 0.0)
    go = drive_lease.Command("Ann", True, 1.0, 0.0)
    notices = []
    for seq, (judged, expected) in enumerate(
        [(fresh, [go]), (late, [stop]), (fresh, [go]), (lasting, [stop]), (lasting, []), (fresh, [])]
    ):
        lease, actions = drive(lease, judged, 0.05 * seq, seq)
        assert [a for a in actions if isinstance(a, drive_lease.Command)] == expected
        notices += [a for a in actions if isinstance(a, drive_lease.PageNotice)]
    assert [notice.text for notice in notices] == ["Commands arrive up to 3.0 s late: driving waits."]
    lease, _ = drive(lease, late, 1.0, 10, held=False)
    assert drive(lease, fresh, 1.1, 11)[1] == (go,)


def test_who_comes_late_takes_no_wheel() -> None:
    lease, _ = drive_lease.step(drive_lease.Lease(), 0.0, drive_lease.Connected("a", "Ann"))
    for seq in range(3):
        lease, actions = drive(lease, Judgement("Late", 1.0, lasting=seq > 0), 0.05 * seq, seq)
        assert not any(isinstance(action, drive_lease.Command) for action in actions)
    assert lease.driver is None


def test_samples_are_bounded_whatever_comes() -> None:
    age = CommandAge(VALIDITY_S)
    for number in range(5000):
        age.judge(1000.0, Times(0.0, 999.0 - 1e-3 * number, 0.0))
    assert len(age._offset._samples) <= 1000
    assert all(a >= b for (a, _), (b, _) in pairwise(age._offset._samples))


@given(delays, delays)
def test_a_later_command_is_never_faster(down: float, up: float) -> None:
    """What is driven until a release arrives is no further than at full speed with the delay that is allowed then."""
    judged = Link().send(1e6, down=down, up=up)
    if judged.cause:
        return
    assert judged.age_s is not None
    assert judged.share * judged.age_s <= FULL_SPEED_S / (1 - LEAST_LIMIT) + 1e-9
    assert (judged.share == 1.0) == (judged.slowed == "")
    assert 0.0 < judged.share <= 1.0


def test_speed_is_limited_first_and_driving_waits_later() -> None:
    assert Link().send(1e6, down=0.02, up=0.1).share == 1.0
    slowed = Link().send(1e6, down=0.02, up=0.26)
    assert slowed.share == pytest.approx(FULL_SPEED_S / 0.3, rel=0.01)
    assert slowed.slowed == "commands arrive up to 0.30 s late"
    assert Link().send(1e6, down=0.02, up=0.5).cause == "Commands arrive up to 0.5 s late"


def test_an_old_picture_of_the_robot_limits_the_speed_too() -> None:
    slowed = Link().send(1e6, down=0.01, up=0.05, think=0.6)
    assert slowed.slowed == "what you see is 0.66 s old"
    assert slowed.share == pytest.approx((FULL_SPEED_S + FULL_VIEW_ALLOWANCE_S) / 0.66, rel=0.01)


def test_jitter_does_not_make_the_speed_waver() -> None:
    link = Link()
    shares = [link.send(1e6 + 0.05 * k, down=0.02, up=0.25 if k % 4 else 0.1).share for k in range(1, 40)]
    assert max(shares) - min(shares) < 0.03


def test_full_speed_comes_back_with_the_link() -> None:
    link = Link()
    assert link.send(1e6, down=0.02, up=0.3).share < 1.0
    assert link.send(1e6 + 10.0, down=0.02, up=0.05).share == 1.0
