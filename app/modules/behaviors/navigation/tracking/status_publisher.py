"""Telling where one is on the way to a goal: at once what is news, else now and then."""

from __future__ import annotations

import logging
from collections.abc import Callable

from app.messages import NavigationStatus

#: A status that says nothing new is told again after so long, s.
_AGAIN_S = 0.5


class StatusPublisher:
    """Publishes statuses, at most as often as there is something to tell; logs a state on entering it, and then each
    new reason once."""

    def __init__(self, publish: Callable[[NavigationStatus], None], log: logging.Logger) -> None:
        self._publish = publish
        self._log = log
        self.told: NavigationStatus | None = None
        #: Reasons logged since the state was entered.
        self._logged: set[str] = set()

    @property
    def idle(self) -> bool:
        """Whether the last thing told, if any, was that there is no goal."""
        return self.told is None or self.told.state == "idle"

    def tell(self, status: NavigationStatus) -> None:
        """Publish ``status`` if it is news; one of being idle is told once."""
        told = self.told
        if told is not None and not _is_news(told, status):
            again = status.state != "idle" and status.stamp - told.stamp >= _AGAIN_S - 1e-6
            if not again:
                return
        if told is None or told.state != status.state:
            self._logged.clear()
        if told is not None and (told.state, told.reason) != (status.state, status.reason):
            self._log_once(status)
        self.told = status
        self._publish(status)

    def _log_once(self, status: NavigationStatus) -> None:
        if status.reason not in self._logged:
            self._logged.add(status.reason)
            self._log.info("%s%s", status.state, f": {status.reason}" if status.reason else "")


def _is_news(told: NavigationStatus, status: NavigationStatus) -> bool:
    # By their words, for a heading may not be a number.
    return (told.state, told.reason, repr(told.goal), repr(told.target), told.recoveries) != (
        status.state, status.reason, repr(status.goal), repr(status.target), status.recoveries,
    )  # fmt: skip
