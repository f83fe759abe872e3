"""Webhooks as people see them; a secret is shown once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from msgspec import Meta

from app.messages import EventKind
from app.messages.base import doc

#: ``idle``: everything is delivered. ``gone``: the receiver answered 410, and gets nothing more.
DeliveryState = Literal["idle", "delivering", "retrying", "gone"]


@dataclass(frozen=True, slots=True)
class WebhookReport:
    """Events of the timeline that are posted to a URL."""

    id: Annotated[str, Meta(examples=["3f9c2a7be1d04c58"])]
    url: Annotated[str, Meta(examples=["https://example.org/robot"])]
    kinds: Annotated[tuple[EventKind, ...], doc("Events of these kinds are posted.")]
    subject: Annotated[str, doc("Only events about this: a desire class, a module, a person's code; empty: all.")]
    state: DeliveryState
    waiting: Annotated[int, doc("Events that wait to be delivered, the one under way included.")]
    delivered: Annotated[int, doc("Events delivered since the program was started.")]
    dropped: Annotated[int, doc("Events given up since the program was started: too old, or too many waited.")]
    problem: Annotated[str, doc("Why the last attempt failed, in words; empty: it did not.")]
    succeeded: Annotated[float | None, doc("When an event was delivered last (robot's clock, s); null: never.")]


@dataclass(frozen=True, slots=True)
class NewWebhookReport:
    """A webhook that has just been made, with its secret, which is not shown again."""

    webhook: WebhookReport
    secret: Annotated[
        str, doc("The receiver verifies `webhook-signature` with it (Standard Webhooks, scheme v1), and keeps it.")
    ]


@dataclass(frozen=True, slots=True)
class WebhookList:
    """Every webhook, in the order of their making."""

    webhooks: tuple[WebhookReport, ...]


@dataclass(frozen=True, slots=True)
class WebhookTrial:
    """What became of an event that was posted for a trial."""

    delivered: bool
    status: Annotated[int | None, doc("The receiver's HTTP status; null: it did not answer.")]
    problem: Annotated[str, doc("What went wrong, in words; empty: nothing.")]
