"""A gamepad's own bytes become sticks and dead-man."""

from __future__ import annotations

import os
import struct
from pathlib import Path

import pytest

from app.messages import GamepadState
from app.robots.drivers import input_events
from app.robots.drivers.gamepad import Gamepad, GamepadSetting
from app.robots.drivers.input_events import ABS, AXES, BUTTONS, DROPPED, KEY, REPORT, SYN, InputEvent

#: As recorded of one on x86-64: two longs, then type, code and value; here a press of BTN_TL and its report.
RECORDED = bytes.fromhex(
    "a1b2c36500000000 10270000 00000000 0100 3601 01000000"
    "a1b2c36500000000 10270000 00000000 0000 0000 00000000"
)  # fmt: skip
END = InputEvent(SYN, REPORT, 0)


def events(*found: InputEvent) -> bytes:
    return b"".join(map(input_events.encode, found))


def axis(name: str, value: int) -> InputEvent:
    return InputEvent(ABS, AXES[name], value)


def button(name: str, value: int) -> InputEvent:
    return InputEvent(KEY, BUTTONS[name], value)


def newest(gamepad: Gamepad, data: bytes, now: float = 1.0) -> GamepadState:
    """The state after ``data``."""
    *_, (_, state) = gamepad.received(data, now)
    assert isinstance(state, GamepadState)
    return state


def test_the_kernels_record_is_read_in_pieces() -> None:
    if struct.calcsize("@l") != 8:
        pytest.skip("recorded on a computer with longs of 8 bytes")
    assert len(RECORDED) == 2 * input_events.EVENT.size
    reader, found = input_events.EventReader(), []
    for start in range(0, len(RECORDED), 7):
        found += reader.feed(RECORDED[start : start + 7])
    assert found == [button("BTN_TL", 1), END]


def test_sticks_are_forward_and_left_beyond_their_rest() -> None:
    gamepad = Gamepad("gamepad", GamepadSetting(lateral="ABS_X"))
    gamepad.opened(0.0)
    state = newest(gamepad, events(button("BTN_TL", 1), axis("ABS_Y", -32768), axis("ABS_RX", 16384), END))
    assert (state.held, state.stop, state.connected) == (True, False, True)
    assert state.linear == pytest.approx(1.0)
    assert state.angular == pytest.approx(-0.444, abs=0.001)
    assert newest(gamepad, events(axis("ABS_X", -32768), END)).lateral == pytest.approx(1.0)
    assert newest(gamepad, events(axis("ABS_Y", -1500), END)).linear == 0.0
    assert not newest(gamepad, events(button("BTN_TL", 0), END)).held


def test_an_inverted_axis_with_a_range_of_its_own() -> None:
    gamepad = Gamepad("gamepad", GamepadSetting(invert=("ABS_Y",), rest=0.0))
    gamepad.ranges = {"ABS_Y": (0, 255)}
    assert newest(gamepad, events(axis("ABS_Y", 255), END)).linear == pytest.approx(1.0)
    assert newest(gamepad, events(axis("ABS_Y", 0), END)).linear == pytest.approx(-1.0)


def test_lost_events_let_go_until_it_is_pressed_again() -> None:
    gamepad = Gamepad("gamepad", GamepadSetting())
    assert newest(gamepad, events(button("BTN_TL", 1), axis("ABS_Y", -32768), END)).held
    lost = InputEvent(SYN, DROPPED, 0)
    state = newest(gamepad, events(lost, button("BTN_TL", 1), axis("ABS_Y", -32768), END))
    assert (state.held, state.linear) == (False, 0.0)
    assert newest(gamepad, events(button("BTN_TL", 1), END)).held


def test_it_says_its_state_again_while_it_is_held_still_and_its_last_word_when_unplugged() -> None:
    gamepad = Gamepad("gamepad", GamepadSetting())
    newest(gamepad, events(button("BTN_TL", 1), button("BTN_EAST", 1), END), now=1.0)
    assert gamepad.step(1.01) == (b"", ())
    _, ((stream, state),) = gamepad.step(1.06)
    assert stream == "gamepad"
    assert isinstance(state, GamepadState)
    assert (state.held, state.stop, state.stamp) == (True, True, 1.06)
    ((_, last),) = gamepad.closed(2.0)
    assert last == GamepadState(2.0, connected=False, held=False, stop=False)
    gamepad.opened(3.0)
    assert not newest(gamepad, events(END), now=3.0).held


def test_a_device_that_does_not_say_its_range_has_the_usual_one(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "events")
    descriptor = os.open(tmp_path / "events", os.O_RDWR | os.O_NONBLOCK)
    try:
        assert input_events.axis_range(descriptor, AXES["ABS_X"]) == input_events.USUAL_RANGE
    finally:
        os.close(descriptor)
