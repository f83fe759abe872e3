"""What is plugged in is named as a body's file names it."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.commands import doctor
from app.commands.doctor_devices import cameras, gamepads, serial_ports


@pytest.fixture
def dev(tmp_path: Path) -> Path:
    """A folder as /dev: two serial ports, of which one has a name, a gamepad, a camera."""
    for name in ("ttyUSB0", "ttyACM0", "ttyS0", "video0", "input/event7"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    for link, target in (
        ("serial/by-id/usb-Arduino-if00", "../../ttyACM0"),
        ("input/by-id/usb-Pad-event-joystick", "../event7"),
        ("input/by-id/usb-Keys-event-kbd", "../event7"),
    ):
        (tmp_path / link).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / link).symlink_to(target)
    return tmp_path


def test_what_is_plugged_in_is_named(dev: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    sys = tmp_path_factory.mktemp("sys")
    (sys / "class" / "video4linux" / "video0").mkdir(parents=True)
    (sys / "class" / "video4linux" / "video0" / "name").write_text("HD Webcam\n")
    assert serial_ports(dev) == [f"{dev}/serial/by-id/usb-Arduino-if00 ({dev}/ttyACM0)", f"{dev}/ttyUSB0"]
    assert gamepads(dev) == [f"{dev}/input/by-id/usb-Pad-event-joystick"]
    assert cameras(dev, sys) == [f"{dev}/video0 (HD Webcam)"]


def test_what_may_not_be_read_says_the_group(dev: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.commands.doctor_devices.os.access", lambda *_: False)
    group = (dev / "ttyUSB0").group()
    assert serial_ports(dev)[1] == (f"{dev}/ttyUSB0, not readable: add the user to the group {group}, and log in again")


def test_nothing_is_plugged_in(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert (serial_ports(tmp_path), gamepads(tmp_path), cameras(tmp_path)) == ([], [], [])
    monkeypatch.setattr("app.commands.doctor_devices.DEV", tmp_path)
    for finding in (doctor.serial_ports(), doctor.gamepads()):
        assert not finding.required
        assert finding.remedy
