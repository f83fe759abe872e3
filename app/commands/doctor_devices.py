"""What is plugged in at this computer, as ``hbba doctor`` names it: serial ports, gamepads, cameras, sound cards."""

from __future__ import annotations

import os
from pathlib import Path

DEV, SYS = Path("/dev"), Path("/sys")
#: Serial lines that are plugged in; those of the board itself (ttyS) are there whether or not anything is at them.
_SERIAL = ("ttyUSB*", "ttyACM*", "ttyAMA*")


def serial_ports(dev: Path = DEV) -> list[str]:
    """The serial ports, each by its name by id where it has one, which stays whatever is plugged in first."""
    return _named(dev, dev / "serial" / "by-id", [path for pattern in _SERIAL for path in dev.glob(pattern)])


def gamepads(dev: Path = DEV) -> list[str]:
    """The files of events of gamepads and joysticks."""
    folder = dev / "input" / "by-id"
    return [_said(dev, path) for path in sorted(folder.glob("*-event-joystick"))] if folder.is_dir() else []


def cameras(dev: Path = DEV, sys: Path = SYS) -> list[str]:
    """The video devices with what they call themselves."""
    found = []
    for path in sorted(dev.glob("video*")):
        name = _text(sys / "class" / "video4linux" / path.name / "name")
        found.append(f"{path} ({name}){_refusal(path)}" if name else f"{path}{_refusal(path)}")
    return found


def _named(dev: Path, by_id: Path, paths: list[Path]) -> list[str]:
    links = {link.resolve(): link for link in sorted(by_id.glob("*"))} if by_id.is_dir() else {}
    return [_said(dev, links.get(path.resolve(), path)) for path in sorted(paths)]


def _said(dev: Path, path: Path) -> str:
    target = path.resolve()
    where = f" ({dev / target.name})" if path.is_symlink() and target.parent == dev.resolve() else ""
    return f"{path}{where}{_refusal(path)}"


def _refusal(path: Path) -> str:
    """Whether this user may read it, in words where not."""
    if os.access(path, os.R_OK):
        return ""
    try:
        group = path.group()
    except (OSError, KeyError):
        return ", not readable"
    return f", not readable: add the user to the group {group}, and log in again"


def _text(path: Path) -> str:
    try:
        return path.read_text("utf-8", "replace").strip()
    except OSError:
        return ""
