"""A device at its port: opened, read, written, lost and opened again; what of it forbids driving."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from app.robots.drivers.device import Device, DeviceLost, Reading, WrongDevice
from app.robots.drivers.port import CONNECTING, Port


@dataclass(slots=True)
class Attached:
    """``device`` at ``port``. ``wrong``: why it is another device than it should be, "" while it may be the right one;
    ``last``: when (s) each of its streams gave its newest message."""

    device: Device
    port: Port
    wrong: str = ""
    last: dict[str, float] = field(default_factory=dict)
    cautions: list[str] = field(default_factory=list)
    #: Why it was lost, until it answers again; and whether that was said.
    _why: str = ""
    _lost: bool = False

    @property
    def where(self) -> str:
        """Name and port, for people."""
        return f"{self.device.name} ({self.port.address})"

    def step(self, now: float) -> list[Reading]:
        """Open the port if it is lost; read and write; the messages that came."""
        readings: list[Reading] = []
        if self.port.tend(now):
            self.device.opened(now)
        was_open = self.port.is_open
        why = ""
        try:
            if data := self.port.read():
                readings += self.device.received(data, now)
            if self.port.is_open:
                outgoing, more = self.device.step(now)
                self.port.write(outgoing)
                readings += more
        except DeviceLost as failure:
            why = str(failure)
            self.port.lose(why)
        except WrongDevice as failure:
            why = self.wrong = str(failure)
            self.port.lose(why)
        if was_open and not self.port.is_open:
            # An attempt that comes to nothing says less than what began it.
            self._why = why or self._why or self.port.problem
            readings += self.device.closed(now)
        for stream, _ in readings:
            self.last[stream] = now
        if self.port.is_open and self.device.ready:
            self._why = self.wrong = ""
        self._caution()
        return readings

    def problem(self, now: float) -> str:
        """Why the robot must not drive, by the state of this device; "" if it may. Once it was lost, what lost it is
        said until it is back, and not that it cannot be opened."""
        problem = self._why or self.port.problem or self.device.problem(now)
        return f"{self.where}: {problem}" if problem else ""

    def silence(self, stream: str, now: float, timeout_s: float) -> str:
        """Why ``stream``, which driving requires, forbids it; "" while it is fresh."""
        if problem := self.problem(now):
            return problem
        last = self.last.get(stream)
        if last is None:
            return f"{stream} has given nothing yet: {self.where} is silent"
        return "" if now - last <= timeout_s else f"{stream} has given nothing for {now - last:.1f} s: {self.where}"

    def close(self) -> None:
        """Release the port."""
        self.port.flush()
        self.port.close()

    def _caution(self) -> None:
        self.cautions += (f"{self.where}: {sentence}" for sentence in self.device.cautions)
        self.device.cautions.clear()
        problem = self._why or self.port.problem
        if problem and problem != CONNECTING and not self._lost:
            self._lost = True
            self.cautions.append(f"{self.where}: {problem}; it is looked for again")
        elif not problem and self._lost:
            self._lost = False
            self.cautions.append(f"{self.where}: it is there again")


def cautions(attached: Iterable[Attached]) -> list[str]:
    """What is to be logged, and forget it."""
    said: list[str] = []
    for each in attached:
        said += each.cautions
        each.cautions.clear()
    return said
