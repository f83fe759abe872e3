"""Receivers of a body's streams: one table for every kind of link."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable, Set
from typing import Any

from app.link import RobotDescription

ALWAYS_ON = ("odometry", "joints", "status")
"""Streams that run independent of demand."""


class Receivers:
    """The receivers of each stream of ``description``, and the rates (Hz) at which streams are wanted."""

    def __init__(self, description: RobotDescription) -> None:
        self._robot = description.name
        self._receivers: dict[str, list[Callable[[Any], None]]] = {name: [] for name in description.streams}
        self.rates: dict[str, float] = {}
        self._periods: dict[str, int] = {}

    @property
    def wanted(self) -> Set[str]:
        """The streams that are wanted at any rate."""
        return self.rates.keys()

    def attach(self, stream: str, receive: Callable[[Any], None]) -> Callable[[], None]:
        """As ``RobotLink.attach``. Raises KeyError naming the streams there are."""
        receivers = self._of(stream)
        receivers.append(receive)

        def detach() -> None:
            with contextlib.suppress(ValueError):
                receivers.remove(receive)

        return detach

    def demand(self, stream: str, rate_hz: float) -> bool:
        """Note the rate at which ``stream`` is wanted; True where that changes anything. Raises KeyError as
        :meth:`attach`.
        """
        self._of(stream)
        if stream in ALWAYS_ON or rate_hz == self.rates.get(stream, 0.0):
            return False
        if rate_hz > 0:
            self.rates[stream] = rate_hz
        else:
            del self.rates[stream]
        return True

    def periods(self, stream: str) -> int:
        """As ``RobotLink.periods``."""
        return self._periods.get(stream, 1)

    def listened(self, stream: str) -> bool:
        """Whether ``stream`` has a receiver."""
        return bool(self._receivers[stream])

    def deliver(self, stream: str, message: Any, periods: int = 1) -> None:
        """Pass ``message``, which ends so many periods of the stream, to all receivers; an exception of one goes to the
        loop's handler and does not affect the others."""
        self._periods[stream] = periods
        for receive in tuple(self._receivers[stream]):
            try:
                receive(message)
            except Exception as failure:  # noqa: BLE001  # must neither affect the others nor pass in silence
                asyncio.get_running_loop().call_exception_handler(
                    {"message": f"a receiver of {stream} raised", "exception": failure}
                )

    def _of(self, stream: str) -> list[Callable[[Any], None]]:
        if stream not in self._receivers:
            raise KeyError(f"{self._robot} has no stream {stream!r}; it has {', '.join(self._receivers)}")
        return self._receivers[stream]
