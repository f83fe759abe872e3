"""Back-off: when a solver that failed is called again."""

from __future__ import annotations

import logging
from typing import Final

from app.attention.timeline import Timeline

_log = logging.getLogger(__name__)

_FIRST_S: Final = 1.0
_MOST_S: Final = 30.0
"""The solver is called again after ``_FIRST_S``, then after twice the time each, at most ``_MOST_S``."""


class Retry:
    """Notes failures of the solver on the timeline, the first in a row in the log too, and when to ask again."""

    def __init__(self, timeline: Timeline) -> None:
        self._timeline = timeline
        self._wait_s = _FIRST_S
        self._failing = False
        #: Time of the next call; None while the solver answers, or is running.
        self.at: float | None = None

    def begin(self) -> None:
        """The solver is called."""
        self.at = None

    def failed(self, why: str, now: float) -> None:
        """The solver failed at ``now`` (s) for the reason ``why``: set when it is called again."""
        self.at = now + self._wait_s
        self._wait_s = min(2 * self._wait_s, _MOST_S)
        text = f"the solver failed ({why}); the last intention stays"
        if not self._failing:
            _log.error("%s", text)
        self._failing = True
        self._timeline.add("solver", "solver", text, {"error": why})

    def succeeded(self) -> None:
        """It answered."""
        self._wait_s = _FIRST_S
        if self._failing:
            self._failing = False
            self._timeline.add("solver", "solver", "the solver answers again")
