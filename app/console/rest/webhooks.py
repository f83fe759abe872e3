"""Webhooks: other programs that the robot calls when something happens."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path
from fastapi.responses import Response
from pydantic import Field, field_validator

from app.base.web_address import checked_url
from app.console.problems import Problem
from app.console.records.webhooks import NewWebhookReport, WebhookList, WebhookReport, WebhookTrial
from app.console.rest.answers import Json, problems
from app.console.rest.models import Request
from app.console.rest.routing import router as api_router
from app.console.webhooks.kept import MOST_HOOKS, WebhooksUnreadable
from app.console.webhooks.signing import secret_bytes
from app.console.webhooks.webhooks import TooManyWebhooks, UnknownWebhook, Webhooks
from app.messages import EventKind

WebhookId = Annotated[str, Path(description="The webhook's id.", examples=["3f9c2a7be1d04c58"])]


class NewWebhook(Request):
    """Who is called, of what."""

    url: str = Field(description="Where events are posted: http or https.", examples=["https://example.org/robot"])
    kinds: list[EventKind] = Field(
        min_length=1, description="Kinds of events of the timeline.", examples=[["accomplishment", "tour"]]
    )
    subject: str = Field(
        "", max_length=200, description="Only events about this: a desire class, a module; empty: about anything."
    )
    secret: str | None = Field(
        None, description="With which requests are signed: `whsec_` and 24 to 64 bytes in base64; left out: a new one."
    )

    @field_validator("url")
    @classmethod
    def _can_be_posted_to(cls, url: str) -> str:
        return checked_url(url)

    @field_validator("secret")
    @classmethod
    def _signs(cls, secret: str | None) -> str | None:
        if secret is not None:
            secret_bytes(secret)
        return secret


def webhooks_router(webhooks: Webhooks | None) -> APIRouter:
    """Routes of ``/webhooks``; ``webhooks`` None: a replay, which calls none."""
    router = api_router("webhooks")

    def served() -> Webhooks:
        if webhooks is None:
            raise Problem(409, "no-webhooks", "This is a replay: what happened then calls nobody now.")
        return webhooks

    @router.get("/webhooks", response_model=WebhookList, summary="List all webhooks", responses=problems(409))
    async def list_webhooks() -> Response:
        """In the order of their making, with how their deliveries go; without their secrets."""
        return Json(WebhookList(served().reports()))

    @router.post(
        "/webhooks",
        response_model=NewWebhookReport,
        status_code=201,
        summary="Have events posted to a URL",
        responses=problems(400, 409, 422, 507),
    )
    async def create_webhook(new: NewWebhook) -> Response:
        """From now on each event of these `kinds` is posted to `url`, in order, one at a time, signed as the
        specification Standard Webhooks 1.0 says, until the receiver answers 2xx: again after 1 s, 5 s, 30 s, 2 min,
        and then every 10 min for a day. A receiver that answers 410 gets nothing more. `secret` is answered once."""
        kept = served()
        try:
            hook = await kept.add(new.url, new.kinds, new.subject, new.secret)
        except TooManyWebhooks:
            raise Problem(409, "too-many-webhooks", f"There are {MOST_HOOKS} webhooks: remove one first.") from None
        except WebhooksUnreadable as error:
            raise Problem(409, "webhooks-unreadable", f"The webhooks that are kept cannot be read: {error}.") from None
        except OSError as error:
            raise _not_kept(error) from None
        return Json(NewWebhookReport(kept.report(hook.id), hook.secret), status_code=201)

    @router.get(
        "/webhooks/{webhook_id}", response_model=WebhookReport, summary="One webhook", responses=problems(404, 409)
    )
    async def get_webhook(webhook_id: WebhookId) -> Response:
        try:
            return Json(served().report(webhook_id))
        except UnknownWebhook:
            raise _unknown(webhook_id) from None

    @router.post(
        "/webhooks/{webhook_id}/trial",
        response_model=WebhookTrial,
        summary="Post an event for a trial",
        responses=problems(404, 409),
    )
    async def try_webhook(webhook_id: WebhookId) -> Response:
        """Posts one event, whose `data.data.trial` is true, once, and answers with what became of it."""
        try:
            answer = await served().try_out(webhook_id)
        except UnknownWebhook:
            raise _unknown(webhook_id) from None
        return Json(WebhookTrial(answer.taken, answer.status, answer.problem))

    @router.delete(
        "/webhooks/{webhook_id}", status_code=204, summary="Remove a webhook", responses=problems(404, 409, 507)
    )
    async def delete_webhook(webhook_id: WebhookId) -> Response:
        """Nothing more is posted; events that wait are given up."""
        try:
            await served().remove(webhook_id)
        except UnknownWebhook:
            raise _unknown(webhook_id) from None
        except OSError as error:
            raise _not_kept(error) from None
        return Response(status_code=204)

    return router


def _unknown(id_: str) -> Problem:
    return Problem(404, "no-such-webhook", f"There is no webhook {id_!r}; GET /api/v1/webhooks lists them.")


def _not_kept(error: OSError) -> Problem:
    return Problem(507, "not-kept", f"The webhooks could not be written: {error.strerror or error}.")
