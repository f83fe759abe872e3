"""The goals of one group of joints at an action: the newest is pursued, and cancelled at a stop; what became of it in
words. A class without rclpy, stepped by its caller; times in s of one clock.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from typing import Any

#: How long a server may take to say whether it takes a goal.
ANSWER_S = 1.0
#: How long nothing is sent after a goal that was not taken or ended badly; twice as long each time, up to the second.
FIRST_REST_S, LONGEST_REST_S = 1.0, 16.0
#: action_msgs/GoalStatus.
SUCCEEDED, CANCELED, ABORTED = 4, 5, 6
#: FollowJointTrajectory's error_code.
_ERRORS = {
    -1: "the goal is invalid",
    -2: "its joints are not the robot's",
    -3: "its time is past",
    -4: "the joints left its path",
    -5: "the joints did not get there",
}
#: So many results are waited for; those of older goals, which newer ones replaced, are not.
_RESULTS = 16


class Goals:
    """The goals at ``action``. ``send(positions)`` gives rclpy's future of a goal handle; ``now`` is the clock;
    ``say`` takes a sentence for people. ``period_s`` is from an answer to the next goal: a server that takes no more
    than so many a second counts by when they reach it."""

    def __init__(
        self,
        action: str,
        send: Callable[[tuple[float, ...]], Any],
        now: Callable[[], float],
        say: Callable[[str], None],
        *,
        period_s: float,
    ) -> None:
        self._action = action
        self._period_s = period_s
        self._answered_at = -math.inf
        self._send = send
        self._now = now
        self._say = say
        self._number = 0
        self._asked: float | None = None
        self._handle: Any = None
        self._results: deque[Any] = deque()
        self._halted = True
        self._refusal, self._until, self._rest_s = "", 0.0, FIRST_REST_S

    @property
    def pursued(self) -> bool:
        """Whether there is a goal that was sent and has not ended."""
        return self._asked is not None or self._handle is not None

    @property
    def refusal(self) -> str:
        """Why nothing is to be sent now, as the last goal ended badly; "" where it may be."""
        return self._refusal if self._now() < self._until else ""

    @property
    def ready(self) -> bool:
        """Whether the next goal may be sent."""
        return self._asked is None and self._now() - self._answered_at >= self._period_s

    def pursue(self, positions: tuple[float, ...]) -> None:
        """Send the goal at ``positions`` (rad, m); nothing while it is not :attr:`ready`."""
        self._halted = False
        if self.refusal or not self.ready:
            return
        self._number += 1
        self._asked = self._now()
        number = self._number
        self._send(positions).add_done_callback(lambda future: self._answered(number, future.result()))

    def halt(self) -> None:
        """Cancel the goal; one that is not answered yet is cancelled when it is."""
        self._halted = True
        if self._handle is not None:
            self._cancel(self._handle)
            self._handle = None

    def look(self, present: bool) -> None:
        """Note whether the server is ``present``, and whether it is late with its answer."""
        if not present:
            self._number += 1  # answers to what it was sent are of no meaning
            self._asked = self._handle = None
        elif self._asked is not None and self._now() - self._asked > ANSWER_S:
            self._asked = None
            self._number += 1
            self._refuse(f"{self._action} has not answered a goal for {ANSWER_S:g} s")

    def _answered(self, number: int, handle: Any) -> None:
        if number != self._number:
            if handle.accepted:
                self._cancel(handle)  # too late: it is not wanted any more
            return
        self._asked, self._answered_at = None, self._now()
        if not handle.accepted:
            self._refuse(f"{self._action} rejected the goal")
            return
        if self._handle is not None:
            self._rest_s = FIRST_REST_S  # the one before was pursued until this one replaced it
        if self._halted:
            self._handle = None
            self._cancel(handle)
            return
        self._handle = handle
        result = handle.get_result_async()
        self._results.append(result)
        result.add_done_callback(lambda future: self._ended(number, handle, future))
        if len(self._results) > _RESULTS:
            self._results.popleft().cancel()

    def _ended(self, number: int, handle: Any, future: Any) -> None:
        if future in self._results:
            self._results.remove(future)
        if handle is not self._handle or future.cancelled():
            return  # cancelled here, or replaced
        self._handle = None
        status, result = future.result().status, future.result().result
        if status == SUCCEEDED:
            self._rest_s = FIRST_REST_S
        elif number == self._number:  # else a newer one is on its way, which ended this
            what = "was cancelled by another" if status == CANCELED else "was aborted"
            reasons = (_ERRORS.get(int(result.error_code), ""), str(result.error_string))
            self._refuse(": ".join((f"{self._action}: the goal {what}", *filter(None, reasons))))

    def _refuse(self, reason: str) -> None:
        self._refusal, self._until = reason, self._now() + self._rest_s
        self._rest_s = min(2 * self._rest_s, LONGEST_REST_S)

    def _cancel(self, handle: Any) -> None:
        handle.cancel_goal_async().add_done_callback(self._cancelled)

    def _cancelled(self, future: Any) -> None:
        if not future.cancelled() and future.result().return_code == 1:  # REJECTED; the others: it is over
            self._say(f"{self._action} lets no goal be cancelled: joints go on to the set-point that was sent last")
