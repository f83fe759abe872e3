"""Requests of visitors' phones."""

from __future__ import annotations

from pydantic import ConfigDict, Field

from app.console.live.messages import VisitorButton
from app.console.rest.models import Request
from app.tours.values import Id


class VisitorKey(Request):
    """The key of a link for visitors."""

    model_config = ConfigDict(title="VisitorKey")

    key: str = Field(max_length=100)


class VisitorPress(Request):
    """One thing that a visitor presses."""

    model_config = ConfigDict(title="VisitorPress")

    button: VisitorButton | None = Field(None, description="One of `buttons` now.")
    ask: Id | None = Field(None, description="Id of a question, one of `questions` now.")
