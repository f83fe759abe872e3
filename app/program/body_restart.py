"""Restarts a body whose process died, while program and console keep running.

The odometry of the new body begins at another origin, which invalidates everything computed from the old one: all
modules stop first and start again with it, as when a recording jumps. After ``MOST_IN_A_ROW`` failures in a row (died,
or did not start) the program ends.
"""

from __future__ import annotations

import logging
from collections.abc import Callable

from app.attention.timeline import Timeline
from app.base.observers import Observers
from app.link import LinkFailed, RobotLink
from app.runtime.clock import Clock
from app.runtime.supervisor import Supervisor

log = logging.getLogger("hbba.body")

MOST_IN_A_ROW = 5
FIRST_DELAY_S = 0.5
LONGEST_DELAY_S = 8.0
#: Up-time (s) after which the count of failures is reset.
TRUSTED_AFTER_S = 60.0


class RestartBackoff:
    """When to start a body again: after 0.5 s, 1 s, 2 s ... 8 s, at most ``MOST_IN_A_ROW - 1`` times in a row."""

    def __init__(self) -> None:
        self._failures = 0
        self._up_since: float | None = None

    def up(self, now: float) -> None:
        """The body was up at ``now`` (s)."""
        self._up_since = now

    def failed(self, now: float) -> float | None:
        """The body died, or did not come up, at ``now``: how long to wait (s) before the next start; None: give up."""
        if self._up_since is not None and now - self._up_since >= TRUSTED_AFTER_S:
            self._failures = 0
        self._up_since = None
        self._failures += 1
        if self._failures >= MOST_IN_A_ROW:
            return None
        return min(FIRST_DELAY_S * 2.0 ** (self._failures - 1), LONGEST_DELAY_S)


class BodyRestarter:
    """Starts ``link`` again after it has failed. ``problem`` says why the body does not answer; "" while it does."""

    def __init__(
        self, link: RobotLink, supervisor: Supervisor, clear_state: Callable[[], None], timeline: Timeline, clock: Clock
    ) -> None:
        """``clear_state`` clears every message that the program keeps."""
        self._link = link
        self._supervisor = supervisor
        self._clear_state = clear_state
        self._timeline = timeline
        self._clock = clock
        self._restarts = RestartBackoff()
        self._observers: Observers[[str]] = Observers("the body's state")
        self.problem = ""

    def up(self) -> None:
        """Note that the body runs."""
        self._restarts.up(self._clock.now())

    def observe(self, callback: Callable[[str], None]) -> Callable[[], None]:
        """Call ``callback(problem)`` when the body is lost and when it is back (""); returns a function that ends
        this."""
        return self._observers.add(callback)

    async def restart(self, failure: LinkFailed) -> LinkFailed | None:
        """Bring the body up after ``failure``; returns None once it and the modules run again, else why it never will.

        Meanwhile no module runs, so nothing drives.
        """
        delay_s = self._restarts.failed(self._clock.now())
        if delay_s is None:
            return _final(failure)
        self._report(failure)
        await self._supervisor.stop_modules()
        while True:
            await self._clock.sleep(delay_s)
            try:
                await self._link.start()
            except LinkFailed as again:
                delay_s = self._restarts.failed(self._clock.now())
                if delay_s is None:
                    return _final(again)
                self._report(again)
            else:
                break
        self.up()
        self._clear_state()
        self._supervisor.start_modules()
        self.problem = ""
        log.info("the body answers again")
        self._timeline.add("guard", "body", "The body answers again, its odometry at zero", {"problem": ""})
        self._notify()
        return None

    def _report(self, failure: LinkFailed) -> None:
        reason = str(failure)
        self.problem = f"The body does not answer: {reason[:1].lower()}{reason[1:].rstrip('.')}. It is started again."
        log.warning("%s", self.problem)
        self._timeline.add("guard", "body", self.problem, {"problem": reason})
        self._notify()

    def _notify(self) -> None:
        self._observers.notify(self.problem)


def _final(failure: LinkFailed) -> LinkFailed:
    return LinkFailed(f"{str(failure).rstrip('.')}; that was the {MOST_IN_A_ROW}th time in a row, so the program ends.")
