"""Overruns: sound that arrives faster than it is processed, logged once at the begin and once at the end."""

from __future__ import annotations

import logging

from app.messages import Audio
from app.runtime.clock import Clock
from app.runtime.errors import InboxOverflow
from app.runtime.module import Input

#: Time (s) without a loss after which the overrun is over.
QUIET_S = 5.0


class Overruns:
    """Losses of one lossless input for sound.

    A backlog would add latency and lose again with each frame: after a loss it is dropped as a whole, so that
    processing resumes with current sound.
    """

    def __init__(self, log: logging.Logger, clock: Clock) -> None:
        self._log = log
        self._clock = clock
        self._last: float | None = None

    def lost(self, port: Input[Audio], loss: InboxOverflow) -> None:
        """``port`` lost messages: log the begin of an overrun."""
        port.subscription.discard()
        if self._last is None:
            self._log.warning("sound comes faster than it can be heard, listening begins afresh: %s", loss)
        self._last = self._clock.now()

    def heard(self) -> None:
        """A frame was processed."""
        if self._last is not None and self._clock.now() - self._last > QUIET_S:
            self._last = None
            self._log.info("hears all sound again")
