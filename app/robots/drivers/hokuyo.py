"""A Hokuyo laser at a port: asked what it is, switched on, and read, by SCIP 2."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from app.base.geometry import Pose3
from app.messages import LaserScan, read_only
from app.robots.drivers import scip
from app.robots.drivers.device import DeviceLost, Reading, WrongDevice, shown
from app.robots.drivers.device_clock import DeviceClock

#: Time (s) that a laser has for an answer; one that is not lit yet takes its time.
ANSWER_S = 2.0
#: Without a scan for so long (s) its port is opened again.
SILENT_S = 1.0
#: Times that a question is asked.
_ATTEMPTS = 3
_TAKEN = {"VV": ("00",), "PP": ("00",), "II": ("00",), "BM": ("00", "02")}
_MOST_HEARD = 256


@dataclass(frozen=True, slots=True)
class LaserSetting:
    """``fov_rad``: field of view about the front, None for all; ``characters`` of a distance (2 or 3), ``intensities``
    whether they are asked for, ``latency_s`` from the end of a sweep to the first byte of it."""

    link: str
    fov_rad: float | None = None
    characters: int = 3
    intensities: bool = False
    latency_s: float = 0.0


class Hokuyo:
    """A laser at ``X_BL`` in ``base_link``; ``wanted``: whether it is to measure."""

    def __init__(self, name: str, setting: LaserSetting, X_BL: Pose3) -> None:
        self.name = name
        self.cautions: list[str] = []
        self.wanted = True
        self.geometry: scip.LaserGeometry | None = None
        self._setting = setting
        self._X_BL = Pose3(read_only(X_BL.rotation), read_only(X_BL.translation))
        self._begin(0.0)

    def _begin(self, now: float) -> None:
        self._reader = scip.ReplyReader()
        self._clock = DeviceClock(1000.0, 2**24)
        self._asked = ""
        self._sent = now
        self._attempts = 0
        self._heard = b""
        self._answered = self._known = False
        self._state = ""
        self._scanning = False
        self._last_scan = now
        self._said_garbled = 0

    @property
    def ready(self) -> bool:
        return self._known

    def opened(self, now: float) -> None:
        """Ask for silence first: it may still measure for an earlier program. A laser of SCIP 1 is moved to SCIP 2."""
        self._begin(now)
        self._asked = "QT"

    def closed(self, now: float) -> Iterable[Reading]:
        return ()

    def received(self, data: bytes, now: float) -> Iterable[Reading]:
        """The scans in ``data``."""
        if not self._answered:
            self._heard = (self._heard + data)[:_MOST_HEARD]
        readings: list[Reading] = []
        for reply in self._reader.feed(data, now):
            try:
                scan = self._take(reply, now)
            except scip.Garbled:
                self._reader.garbled += 1
                continue
            if scan is not None:
                readings.append(("hokuyo", scan))
        if self._reader.garbled and not self._said_garbled and self._answered:
            self.cautions.append("replies with a wrong sum are dropped: look at its cable")
            self._said_garbled = self._reader.garbled
        return readings

    def step(self, now: float) -> tuple[bytes, Iterable[Reading]]:
        """The command that is due, if any."""
        if self._scanning:
            if not self.wanted:
                self._scanning, self._asked, self._attempts = False, "", 0
                return b"QT\n", ()
            if now - self._last_scan > SILENT_S:
                raise DeviceLost(f"it has given no scan for {SILENT_S:g} s")
            return b"", ()
        if self._asked == "":
            if not self.wanted:
                return b"", ()
            self._ask("BM", now)
        elif self._attempts == 0:
            self._attempts, self._sent = 1, now
        elif now - self._sent < ANSWER_S / _ATTEMPTS:
            return b"", ()
        elif self._attempts < _ATTEMPTS:
            self._attempts, self._sent = self._attempts + 1, now
        elif not self._answered:
            raise WrongDevice(f"no Hokuyo laser (SCIP 2) answers: {shown(self._heard)}")
        else:
            raise DeviceLost(f"it does not answer to {self._asked[:2]}")
        prefix = b"SCIP2.0\n" if self._asked == "QT" else b""
        return prefix + self._asked.encode() + b"\n", ()

    def problem(self, now: float) -> str:
        """Nothing that its silence does not say."""
        return ""

    def _ask(self, command: str, now: float) -> None:
        self._asked, self._attempts, self._sent = command, 1, now

    def _next(self, command: str) -> None:
        self._asked, self._attempts = command, 0

    def _take(self, reply: scip.Reply, now: float) -> LaserScan | None:
        """What a reply brings. Raises Garbled, WrongDevice, DeviceLost."""
        if reply.status == scip.SCAN and self._scanning and reply.command[:10] == self._asked[:10]:
            self._last_scan = now
            return self._scan(reply)
        if reply.code != self._asked[:2]:
            return None  # of an earlier program, or to SCIP2.0
        if reply.code in _TAKEN and reply.status not in _TAKEN[reply.code]:
            said = f"; it says of itself: {self._state}" if self._state else ""
            raise DeviceLost(f"it refuses {reply.code} with status {reply.status}{said}")
        match reply.code:
            case "QT":
                self._answered = True
                self._next("VV")
            case "VV":
                known = scip.table(reply)
                if "PROD" not in known:
                    raise WrongDevice(f"what answers is no laser: it says {known}")
                self._next("PP")
            case "PP":
                self.geometry = scip.geometry(scip.table(reply))
                self._next("II")
            case "II":
                self._state = scip.table(reply).get("STAT", "")
                self._known = True
                self._next("")
            case "BM":
                self._next(self._measure())
            case _ if reply.command == self._asked:
                if reply.status != scip.TAKEN:
                    raise DeviceLost(f"it refuses {self._asked} with status {reply.status}")
                self._scanning, self._last_scan = True, now
        return None

    def _measure(self) -> str:
        first, last = self._steps()
        return scip.scan_command(
            first, last, characters=self._setting.characters, intensities=self._setting.intensities
        )

    def _steps(self) -> tuple[int, int]:
        assert self.geometry is not None
        if self._setting.fov_rad is None:
            return self.geometry.first, self.geometry.last
        return self.geometry.within(self._setting.fov_rad)

    def _scan(self, reply: scip.Reply) -> LaserScan:
        assert self.geometry is not None
        laser, taken = self.geometry, scip.measurement(reply)
        first, last = self._steps()
        step_rad = 2 * math.pi / laser.turn
        duration_s = (last - first) / laser.turn * laser.turn_s
        ended = self._clock.placed(taken.milliseconds, reply.began) - self._setting.latency_s
        # Distances below the least are codes of errors: nothing is known there.
        ranges = np.where(
            taken.distances < laser.least_mm,
            np.nan,
            np.where(taken.distances > laser.most_mm, np.inf, taken.distances / 1000.0),
        )
        return LaserScan(
            stamp=ended - duration_s,
            frame=self._setting.link,
            ranges=read_only(ranges.astype(np.float32)),
            intensities=read_only(taken.intensities.astype(np.float32)),
            angle_min=(first - laser.front) * step_rad,
            angle_increment=step_rad,
            range_min=laser.least_mm / 1000.0,
            range_max=laser.most_mm / 1000.0,
            duration_s=duration_s,
            X_BL=self._X_BL,
        )
