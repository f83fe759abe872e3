"""Events delivered to one receiver: in their order, one at a time, tried again where it does not take them."""

from __future__ import annotations

import asyncio
import itertools
import logging
from collections import deque
from dataclasses import dataclass
from typing import Protocol

from app.console.records.webhooks import DeliveryState, WebhookReport
from app.console.webhooks.kept import Webhook
from app.console.webhooks.signing import signed
from app.console.wire import encode
from app.messages import TimelineEvent

#: So many events wait at most; of more, the oldest is given up.
MOST_WAITING = 1000
#: Waits (s) before the second attempt and those after it; the last is repeated.
WAITS_S = (1.0, 5.0, 30.0, 120.0, 600.0)
#: An event is given up when it is older (s): who was away for so long reads the timeline.
OLDEST_S = 24 * 3600.0
#: HTTP's word for a receiver that wants nothing more.
_GONE = 410

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Answer:
    """A receiver's HTTP ``status``, None where there was none, and the ``problem`` in words."""

    status: int | None
    problem: str = ""

    @property
    def taken(self) -> bool:
        """Whether the receiver took the event."""
        return self.status is not None and 200 <= self.status < 300


class Post(Protocol):
    """Posts ``body`` with ``headers`` to ``url``; never raises for what a receiver does."""

    async def __call__(self, url: str, body: bytes, headers: dict[str, str]) -> Answer: ...


class Time(Protocol):
    """The robot's clock."""

    def now(self) -> float: ...
    async def sleep(self, seconds: float) -> None: ...


def body_of(event: TimelineEvent) -> bytes:
    """``event`` as the specification's JSON: ``type``, ``timestamp`` (s, robot's clock) and ``data``, the event."""
    return encode({"type": f"timeline.{event.kind}", "timestamp": event.stamp, "data": event})


class Delivery:
    """The events that wait for one webhook; :meth:`run` delivers them until it is cancelled.

    ``run_id`` makes events of two runs of the program distinct: their numbers begin at 1 in each.
    """

    def __init__(self, hook: Webhook, post: Post, clock: Time, run_id: str) -> None:
        self.hook = hook
        self._post = post
        self._clock = clock
        self._run_id = run_id
        self._waiting: deque[TimelineEvent] = deque()
        self._came = asyncio.Event()
        self._state: DeliveryState = "idle"
        self._problem = ""
        self._delivered = self._dropped = 0
        self._succeeded: float | None = None

    def add(self, event: TimelineEvent) -> None:
        """Have ``event`` delivered, if it is one that is wanted."""
        hook = self.hook
        if self._state == "gone" or event.kind not in hook.kinds or hook.subject not in ("", event.subject):
            return
        if len(self._waiting) == MOST_WAITING:
            # The oldest may be under way: it is then delivered, and the next one given up.
            del self._waiting[1]
            self._dropped += 1
        self._waiting.append(event)
        self._came.set()

    async def run(self) -> None:
        """Deliver what comes, until the receiver is gone."""
        while True:
            await self._came.wait()
            while self._waiting:
                if not await self._deliver(self._waiting[0]):
                    self._state = "gone"
                    self._dropped += len(self._waiting)
                    self._waiting.clear()
                    return
                self._waiting.popleft()
            self._came.clear()
            self._state = "idle"

    async def _deliver(self, event: TimelineEvent) -> bool:
        """Until ``event`` is taken or too old; False: the receiver is gone."""
        for attempt in itertools.count():
            if self._clock.now() - event.stamp > OLDEST_S:
                break
            self._state = "retrying" if attempt else "delivering"
            answer = await self.attempt(event)
            if answer.taken or answer.status == _GONE:
                return answer.taken
            await self._clock.sleep(WAITS_S[min(attempt, len(WAITS_S) - 1)])
        self._dropped += 1
        log.warning("webhook %s: an event of a day ago is given up: %s", self.hook.id, self._problem)
        return True

    async def attempt(self, event: TimelineEvent) -> Answer:
        """Post ``event`` once."""
        body = body_of(event)
        headers = signed(self.hook.secret, f"{self._run_id}-{event.id}", self._clock.now(), body)
        answer = await self._post(self.hook.url, body, headers)
        if answer.taken:
            self._delivered += 1
            self._succeeded = self._clock.now()
            self._problem = ""
        else:
            if not self._problem:
                log.warning("webhook %s: %s", self.hook.id, answer.problem)
            self._problem = answer.problem
        return answer

    def report(self) -> WebhookReport:
        """How it is."""
        hook = self.hook
        return WebhookReport(
            id=hook.id,
            url=hook.url,
            kinds=hook.kinds,
            subject=hook.subject,
            state=self._state,
            waiting=len(self._waiting),
            delivered=self._delivered,
            dropped=self._dropped,
            problem=self._problem,
            succeeded=self._succeeded,
        )
