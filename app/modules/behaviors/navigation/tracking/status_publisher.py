"""Publication of a behavior's NavigationStatus: at once on a change, else at a fixed period."""

from __future__ import annotations

import logging
from collections.abc import Callable

from app.messages import NavigationStatus

#: Period of an unchanged status, s.
_REPEAT_S = 0.5


class StatusPublisher:
    """Publishes a status when it changes, and an unchanged one every 0.5 s unless it is ``idle``. The log gets a line
    when the state changes, and one for each new reason within a state."""

    def __init__(self, publish: Callable[[NavigationStatus], None], log: logging.Logger) -> None:
        self._publish = publish
        self._log = log
        self.last: NavigationStatus | None = None
        #: Reasons logged since the state was entered.
        self._logged: set[str] = set()

    @property
    def idle(self) -> bool:
        """Whether the last published status is ``idle``, or there is none."""
        return self.last is None or self.last.state == "idle"

    def update(self, status: NavigationStatus) -> None:
        """Publish ``status`` if it differs from the last one or 0.5 s have passed; ``idle`` is published once."""
        last = self.last
        if last is not None and not _differs(last, status):
            due = status.state != "idle" and status.stamp - last.stamp >= _REPEAT_S - 1e-6
            if not due:
                return
        if last is None or last.state != status.state:
            self._logged.clear()
        if last is not None and (last.state, last.reason) != (status.state, status.reason):
            self._log_once(status)
        self.last = status
        self._publish(status)

    def _log_once(self, status: NavigationStatus) -> None:
        if status.reason not in self._logged:
            self._logged.add(status.reason)
            self._log.info("%s%s", status.state, f": {status.reason}" if status.reason else "")


def _differs(last: NavigationStatus, status: NavigationStatus) -> bool:
    # Compared as text: a heading may be NaN, which never equals itself.
    return (last.state, last.reason, repr(last.goal), repr(last.target), last.recoveries) != (
        status.state, status.reason, repr(status.goal), repr(status.target), status.recoveries,
    )  # fmt: skip
