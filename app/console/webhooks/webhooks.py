"""The webhooks of a running program: kept in a file, each with a task that delivers events of the timeline."""

from __future__ import annotations

import asyncio
import logging
import secrets
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from app.attention.timeline import Timeline
from app.console.records.webhooks import WebhookReport
from app.console.webhooks.delivery import Answer, Delivery
from app.console.webhooks.kept import MOST_HOOKS, Webhook, WebhooksUnreadable, read_webhooks, write_webhooks
from app.console.webhooks.signing import new_secret
from app.messages import EventKind, TimelineEvent
from app.runtime.clock import Clock

if TYPE_CHECKING:
    import httpx

log = logging.getLogger(__name__)


class UnknownWebhook(Exception):
    """There is no webhook of this id."""


class TooManyWebhooks(Exception):
    """There are as many as there may be."""


class Webhooks:
    """Made, removed and run; ``file`` None: they last as long as the program. Nothing is sent before :meth:`open`."""

    #: A receiver answers within this (s, of the computer's clock), or the attempt has failed.
    answers_within_s = 10.0

    def __init__(self, timeline: Timeline, clock: Clock, file: Path | None = None) -> None:
        self._timeline = timeline
        self._clock = clock
        self._file = file
        self._run_id = secrets.token_hex(8)
        self._deliveries: dict[str, Delivery] = {}
        self._tasks: dict[str, asyncio.Task[None]] = {}
        self._client: httpx.AsyncClient | None = None
        self._leave: Callable[[], None] = lambda: None
        self._changing = asyncio.Lock()
        self._unreadable = ""

    async def open(self) -> None:
        """Deliver from now on. A file that cannot be read is reported in the log, and left as it is."""
        self._leave = self._timeline.observe(self._on_event)
        try:
            hooks = () if self._file is None else await asyncio.to_thread(read_webhooks, self._file)
        except (WebhooksUnreadable, OSError) as error:
            self._unreadable = str(error)
            log.error("no webhooks: %s", error)
            return
        for hook in hooks:
            self._serve(hook)

    async def close(self) -> None:
        """Deliver nothing more; what waits is lost."""
        self._leave()
        tasks, self._tasks = list(self._tasks.values()), {}
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        if self._client is not None:
            await self._client.aclose()

    def reports(self) -> tuple[WebhookReport, ...]:
        """Each, in the order of their making."""
        return tuple(delivery.report() for delivery in self._deliveries.values())

    def report(self, id_: str) -> WebhookReport:
        """Raises UnknownWebhook."""
        return self._found(id_).report()

    async def add(self, url: str, kinds: Sequence[EventKind], subject: str, secret: str | None) -> Webhook:
        """Make one, with a ``secret`` of its own where None is given. Raises TooManyWebhooks, ValueError, OSError, and
        WebhooksUnreadable where the file would be lost."""
        async with self._changing:
            if self._unreadable:
                raise WebhooksUnreadable(self._unreadable)
            if len(self._deliveries) >= MOST_HOOKS:
                raise TooManyWebhooks
            hook = Webhook(secrets.token_hex(8), url, tuple(dict.fromkeys(kinds)), subject, secret or new_secret())
            await self._keep([*(each.hook for each in self._deliveries.values()), hook])
            self._serve(hook)
            return hook

    async def remove(self, id_: str) -> None:
        """Raises UnknownWebhook, OSError."""
        async with self._changing:
            self._found(id_)
            await self._keep([each.hook for each in self._deliveries.values() if each.hook.id != id_])
            del self._deliveries[id_]
            task = self._tasks.pop(id_)
            task.cancel()
            await asyncio.wait({task})

    async def try_out(self, id_: str) -> Answer:
        """Post an event of the kind that it gets first, about nothing, once. Raises UnknownWebhook."""
        delivery = self._found(id_)
        kind = delivery.hook.kinds[0]
        number = secrets.randbelow(2**31) + 2**31  # no number of the timeline's
        event = TimelineEvent(
            number, self._clock.now(), kind, "trial", "A trial of this webhook.", data={"trial": True}
        )
        return await delivery.attempt(event)

    def _found(self, id_: str) -> Delivery:
        try:
            return self._deliveries[id_]
        except KeyError:
            raise UnknownWebhook(id_) from None

    def _serve(self, hook: Webhook) -> None:
        delivery = Delivery(hook, self._post, self._clock, self._run_id)
        self._deliveries[hook.id] = delivery
        self._tasks[hook.id] = asyncio.create_task(delivery.run(), name=f"webhook {hook.id}")

    async def _keep(self, hooks: list[Webhook]) -> None:
        if self._file is not None:
            await asyncio.to_thread(write_webhooks, self._file, hooks)

    def _on_event(self, event: TimelineEvent) -> None:
        for delivery in self._deliveries.values():
            delivery.add(event)

    async def _post(self, url: str, body: bytes, headers: dict[str, str]) -> Answer:
        import httpx  # a tenth of a second that a robot without webhooks does not spend

        if self._client is None:
            # Where a receiver sends on to was not agreed upon.
            self._client = httpx.AsyncClient(timeout=None, follow_redirects=False)
        sent = {"content-type": "application/json", "user-agent": "hbba", **headers}
        try:
            async with (
                asyncio.timeout(self.answers_within_s),
                self._client.stream("POST", url, content=body, headers=sent) as answer,
            ):
                status = answer.status_code
        except TimeoutError:
            return Answer(None, f"the receiver did not answer within {self.answers_within_s:g} s")
        except (httpx.HTTPError, httpx.InvalidURL) as error:
            return Answer(None, f"the receiver could not be reached: {str(error) or type(error).__name__}")
        return Answer(status, "" if 200 <= status < 300 else f"the receiver answered {status}")
