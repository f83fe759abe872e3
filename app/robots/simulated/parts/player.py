"""A robot of parts without its hardware: a base on a pseudo-terminal, a laser on a TCP port, a gamepad on a named pipe,
in a process of its own, driving in a room.

``python -m app.robots.simulated.parts.player --robot ROBOT.yaml [options]``, where ROBOT is of kind ``drivers``: its
ports are made, so they must be paths that this computer lets be made, as ``/tmp/base``. Without ``--map MAP.yaml`` it
is a room of 6 m by 4 m with a pillar, 3 m ahead.

It prints ``ready`` once all is plugged in. With ``--faults``, lines on its standard input make it go wrong, and it ends
where they end: ``PART unplug``, ``plug``, ``mute``, ``talk``, ``deaf``, ``hear``, ``noise SHARE``, ``wrong TEXT``
(another device speaks there), for PART ``base`` or ``hokuyo``; ``base reset``, ``base faults BITS``; ``gamepad
unplug``, ``plug``, and ``gamepad NAME VALUE`` for a button or an axis. With ``--log FILE`` each step is a line
``MONOTONIC LINEAR ANGULAR X Y DEGREES`` of the truth.
"""

from __future__ import annotations

import argparse
import math
import os
import select
import signal
import sys
import time
from pathlib import Path
from typing import IO

from app.base.child_processes import end_with_parent
from app.base.geometry import Pose2
from app.maps.map_file import read_map
from app.robots.drivers import input_events
from app.robots.drivers.base_firmware import BaseFirmware, FirmwareSetting
from app.robots.drivers.base_protocol import Fault
from app.robots.drivers.config import DriversConfig, load_drivers_config
from app.robots.drivers.input_events import AXES, BUTTONS, InputEvent
from app.robots.simulated.parts.hokuyo_laser import HokuyoLaser
from app.robots.simulated.parts.plugs import Noise, Pipe, Plug, plug_at
from app.robots.simulated.parts.world import PartsWorld, room

STEP_S = 0.01
_CATCH_UP_S = 0.5


class Part:
    """A part at its plug, and what is wrong with it."""

    def __init__(self, plug: Plug, seed: int) -> None:
        self.plug = plug
        self.noise = Noise(seed)
        self.mute = self.deaf = False
        #: What another device in its place says again and again.
        self.other = b""

    def heard(self) -> bytes:
        """What has come, as far as it is heard."""
        data = self.plug.read()
        return b"" if self.deaf or self.other else self.noise.damaged(data)

    def say(self, data: bytes) -> None:
        """Send what a part says, as far as it does."""
        if data and not self.mute:
            self.plug.write(self.other or self.noise.damaged(data))

    def fault(self, words: list[str]) -> bool:
        """Go wrong; whether ``words`` say how."""
        match words:
            case ["unplug"]:
                self.plug.unplug()
            case ["plug"]:
                self.plug.plug()
            case [("mute" | "talk") as word]:
                self.mute = word == "mute"
            case [("deaf" | "hear") as word]:
                self.deaf = word == "deaf"
            case ["noise", share]:
                self.noise.share = float(share)
            case ["wrong", *text]:
                self.other = " ".join(text).encode() + b"\r\n" if text else b""
            case _:
                return False
        return True


class Player:
    """The robot of ``config``."""

    def __init__(self, config: DriversConfig, world: PartsWorld, *, log: IO[str] | None, scan_hz: float) -> None:
        self._world = world
        self._log = log
        self._scan_s = 1.0 / scan_hz
        self._boots = 1
        self._setting = FirmwareSetting(
            linear_mps=config.limits.linear_mps, angular_radps=config.limits.angular_radps,
            brake_mps2=config.limits.emergency_mps2,
        )  # fmt: skip
        self._firmware = BaseFirmware(self._setting, self._boots)
        self._laser = HokuyoLaser()
        self._base = Part(plug_at(str(config.base.address)), seed=1)
        self._parts = {"base": self._base}
        if config.hokuyo is not None:
            self._parts["hokuyo"] = Part(plug_at(str(config.hokuyo.address)), seed=2)
        self._pipe = None if config.gamepad is None else Pipe(Path(config.gamepad.port))
        self._began = self._swept = time.monotonic()
        self.ended = False
        self._half_line = b""

    def run(self, faults: int | None) -> None:
        """Drive until the end; ``faults``: a file descriptor whose lines make it go wrong."""
        for part in self._parts.values():
            part.plug.plug()
        if self._pipe is not None:
            self._pipe.plug()
        print("ready", flush=True)
        due = time.monotonic()
        try:
            while not self.ended:
                now = time.monotonic()
                due = max(due, now - _CATCH_UP_S)
                while due <= now:
                    self._step(due)
                    due += STEP_S
                self._wait(max(due - time.monotonic(), 0.0), faults)
        finally:
            for part in self._parts.values():
                part.plug.unplug()
            if self._pipe is not None:
                self._pipe.unplug()

    def fault(self, line: str) -> None:
        """Do what a line of standard input says. Raises ValueError for an unknown one."""
        match line.split():
            case ["base", "reset"]:
                self._boots += 1
                self._firmware = BaseFirmware(self._setting, self._boots)
            case ["base", "faults", bits]:
                self._firmware.faults = Fault(int(bits))
            case ["gamepad", ("plug" | "unplug") as word] if self._pipe is not None:
                (self._pipe.plug if word == "plug" else self._pipe.unplug)()
            case ["gamepad", name, value] if self._pipe is not None and (name in AXES or name in BUTTONS):
                kind, code = (input_events.ABS, AXES[name]) if name in AXES else (input_events.KEY, BUTTONS[name])
                report = InputEvent(input_events.SYN, input_events.REPORT, 0)
                events = (InputEvent(kind, code, int(value)), report)
                self._pipe.write(b"".join(map(input_events.encode, events)))
            case [part, *words] if part in self._parts and self._parts[part].fault(words):
                pass
            case _:
                raise ValueError(f"no such fault: {line!r}")

    def _step(self, now: float) -> None:
        self._firmware.receive(self._base.heard())
        self._firmware.step(STEP_S)
        self._world.step(self._firmware, STEP_S)
        self._base.say(self._firmware.outgoing())
        if (laser := self._parts.get("hokuyo")) is not None:
            own = now - self._began
            laser.say(self._laser.receive(laser.heard(), own))
            if now - self._swept >= self._scan_s:
                self._swept = max(self._swept + self._scan_s, now - self._scan_s)
                if laser.other:
                    laser.say(b" ")
                elif self._laser.measuring:
                    self._laser.distances = self._world.distances()
                    laser.say(self._laser.scan(own))
        if self._log is not None:
            self._log.write(self._world.row(time.monotonic()))
            self._log.flush()

    def _wait(self, seconds: float, faults: int | None) -> None:
        ready, _, _ = select.select([] if faults is None else [faults], [], [], seconds)
        if faults is None or not ready:
            return
        data = os.read(faults, 4096)
        self.ended = self.ended or not data
        *lines, self._half_line = (self._half_line + data).split(b"\n")
        for line in lines:
            self.fault(line.decode())


def main() -> int:
    """Play the robot of the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot", type=Path, required=True, help="its file, of kind drivers")
    parser.add_argument("--map", type=Path, default=None, help="YAML file of a kept map")
    parser.add_argument("--start", type=float, nargs=3, default=(0.0, 0.0, 0.0), metavar=("X", "Y", "DEGREES"))
    parser.add_argument("--scan-hz", type=float, default=40.0, help="scans a second")
    parser.add_argument("--log", type=Path, default=None, help="file for the truth")
    parser.add_argument("--faults", action="store_true", help="read faults from standard input, and end with it")
    options = parser.parse_args()
    if options.faults:
        end_with_parent()
    config = load_drivers_config(options.robot)
    x, y, heading = options.start
    grid = room() if options.map is None else read_map(options.map)
    pose = Pose2(x, y, math.radians(heading))
    log = None if options.log is None else options.log.open("w", encoding="utf-8")
    player = Player(config, PartsWorld(config, grid, pose), log=log, scan_hz=options.scan_hz)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: setattr(player, "ended", True))
    player.run(sys.stdin.fileno() if options.faults else None)
    return 0


if __name__ == "__main__":
    sys.exit(main())
