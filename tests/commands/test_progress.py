"""Progress: a bar on a terminal, now and then a line elsewhere."""

from __future__ import annotations

import io

import pytest

from app.commands.progress import shown


class Clock:
    """A clock that is set by the test."""

    def __init__(self) -> None:
        self.now = 100.0

    def monotonic(self) -> float:
        return self.now


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    made = Clock()
    monkeypatch.setattr("app.commands.progress.time.monotonic", made.monotonic)
    return made


def test_without_a_terminal_a_line_now_and_then(clock: Clock, capsys: pytest.CaptureFixture[str]) -> None:
    with shown("cut tour.mcap") as progress:
        for done in range(101):
            progress(done, 100)
            clock.now += 0.11
    assert capsys.readouterr().err.splitlines() == ["cut tour.mcap: 46 %", "cut tour.mcap: 92 %"]


def test_what_takes_minutes_says_how_many_are_left_at_the_pace_so_far(
    clock: Clock, capsys: pytest.CaptureFixture[str]
) -> None:
    with shown("measuring") as progress:
        for done in range(50, 54):  # half was done before
            progress(done, 100, "codes")
            clock.now += 6.0
    said = capsys.readouterr().err.splitlines()
    assert said == [
        "measuring: 51 %, about 5 min left  codes",
        "measuring: 52 %, about 5 min left  codes",
        "measuring: 53 %, about 5 min left  codes",
    ]


def test_what_went_before_the_first_of_many_says_nothing_of_the_pace(
    clock: Clock, capsys: pytest.CaptureFixture[str]
) -> None:
    with shown("goals") as progress:
        for done in (0, 0, 1):  # a minute and a half of mapping, then the first
            progress(done, 3, "codes")
            clock.now += 90.0 if done == 0 else 6.0
    said = capsys.readouterr().err.splitlines()
    assert said == ["goals: 0 %  codes", "goals: 33 %, about 3 min left  codes"]


def test_what_is_quick_says_nothing(clock: Clock, capsys: pytest.CaptureFixture[str]) -> None:
    with shown("cut tour.mcap") as progress:
        progress(1, 1)
    assert capsys.readouterr().err == ""


def test_on_a_terminal_a_bar_that_goes_away(monkeypatch: pytest.MonkeyPatch) -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    terminal = Terminal()
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr("sys.stderr", terminal)
    with shown("cut tour.mcap") as progress:
        progress(30, 100)
        progress(100, 100)
    text = terminal.getvalue()
    assert "cut tour.mcap" in text
    assert "100%" in text
    assert text.endswith("\x1b[2K")  # the line is cleared
