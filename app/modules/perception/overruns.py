"""Sound that came faster than it could be heard: said once when it begins, once when it is over."""

from __future__ import annotations

import logging

from app.messages import Audio
from app.runtime.clock import Clock
from app.runtime.errors import InboxOverflow
from app.runtime.module import Input

#: Without a loss for this long (s), the computer keeps up again.
QUIET_S = 5.0


class Overruns:
    """The losses of one lossless input for sound.

    A backlog would be heard ever later, and lose again with each frame: after a loss it is thrown away as a whole, so
    that what is heard next is what sounds now.
    """

    def __init__(self, log: logging.Logger, clock: Clock) -> None:
        self._log = log
        self._clock = clock
        self._last: float | None = None

    def lost(self, port: Input[Audio], loss: InboxOverflow) -> None:
        """``port`` lost messages: begin with the next that comes."""
        port.subscription.discard()
        if self._last is None:
            self._log.warning("sound comes faster than it can be heard, listening begins afresh: %s", loss)
        self._last = self._clock.now()

    def heard(self) -> None:
        """A frame was taken."""
        if self._last is not None and self._clock.now() - self._last > QUIET_S:
            self._last = None
            self._log.info("hears all sound again")
