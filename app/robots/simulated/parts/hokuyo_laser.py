"""A Hokuyo laser as it is on its wire: answers SCIP 2 as a UST-10LX does, and gives the distances that it is set."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from app.robots.drivers import scip

#: What a UST-10LX says of itself.
VERSION = {
    "VEND": "Hokuyo Automatic Co., Ltd.",
    "PROD": "UST-10LX",
    "FIRM": "CC3A01",
    "PROT": "SCIP 2.2",
    "SERI": "H1500000",
}
FIRST, LAST, FRONT, TURN, RPM = 0, 1080, 540, 1440, 2400
LEAST_MM, MOST_MM = 20, 30000
SIZES = {
    "MODL": "UST-10LX",
    "DMIN": str(LEAST_MM),
    "DMAX": str(MOST_MM),
    "ARES": str(TURN),
    "AMIN": str(FIRST),
    "AMAX": str(LAST),
    "AFRT": str(FRONT),
    "SCAN": str(RPM),
}
#: What it gives where nothing is within reach.
NOTHING_MM = 65533


class HokuyoLaser:
    """The laser; ``distances`` (1081,) in mm are what its next scan has. Its clock is in s, from 0."""

    def __init__(self) -> None:
        self.distances: NDArray[np.int64] = np.full(LAST - FIRST + 1, NOTHING_MM, np.int64)
        self._state = "no error."
        #: A status that it refuses to be lit with, "" for none.
        self.broken = ""
        self.lit = False
        self._measuring = ""
        self._left = 0
        self._buffer = b""

    def receive(self, data: bytes, now: float) -> bytes:
        """The replies to the commands in ``data``, which came at ``now`` of its clock."""
        *lines, self._buffer = (self._buffer + data).replace(b"\r", b"\n").split(b"\n")
        return b"".join(self._answer(line.decode("ascii", "replace"), now) for line in lines if line)

    def scan(self, now: float) -> bytes:
        """A sweep has ended at ``now``: its scan, if it was asked for."""
        if not self._measuring:
            return b""
        command = self._measuring
        if self._left:
            self._left -= 1
            command = f"{command[:-2]}{self._left:02d}"
            if not self._left:
                self._measuring = ""
        return self._scan(command, scip.SCAN, now)

    @property
    def measuring(self) -> bool:
        return bool(self._measuring)

    def _answer(self, line: str, now: float) -> bytes:
        command = line.partition(";")[0]
        match command[:2]:
            case "VV":
                return _table(line, VERSION)
            case "PP":
                return _table(line, SIZES)
            case "II":
                return _table(
                    line,
                    {
                        "MODL": "UST-10LX", "LASR": "ON" if self.lit else "OFF", "SCSP": str(RPM), "MESM": "IDLE",
                        "SBPS": "Ethernet 100 [Mbps]", "TIME": f"{int(now * 1000) % 2**24:06X}", "STAT": self._state,
                    },
                )  # fmt: skip
            case "BM":
                status = self.broken or ("02" if self.lit else "00")
                self.lit = not self.broken
                return scip.reply_bytes(line, status)
            case "QT" | "RS":
                self.lit, self._measuring = False, ""
                return scip.reply_bytes(line, "00")
            case "GD" | "GS" | "GE" if self._is_request(command, 12):
                return self._scan(line, "00", now) if self.lit else scip.reply_bytes(line, "10")
            case "MD" | "MS" | "ME" if self._is_request(command, 15):
                self.lit = True
                self._measuring, self._left = line, int(command[13:15])
                return scip.reply_bytes(line, "00")
            case _:
                return scip.reply_bytes(line, "0E")

    @staticmethod
    def _is_request(command: str, length: int) -> bool:
        numbers = command[2:]
        if len(command) != length or not numbers.isdecimal():
            return False
        return FIRST <= int(numbers[:4]) <= int(numbers[4:8]) <= LAST

    def _scan(self, command: str, status: str, now: float) -> bytes:
        first, last = int(command[2:6]), int(command[6:10])
        values = self.distances[first : last + 1]
        match command[1]:
            case "E":
                data = scip.encode(np.stack((values, np.full_like(values, 1000)), axis=1).reshape(-1), 3)
            case "S":
                data = scip.encode(np.minimum(values, 4095), 2)
            case _:
                data = scip.encode(values, 3)
        return scip.reply_bytes(command, status, scip.data_lines(int(now * 1000), data))


def _table(line: str, values: dict[str, str]) -> bytes:
    rows = [f"{name}:{value}".encode() for name, value in values.items()]
    return scip.reply_bytes(line, "00", rows, table=True)
