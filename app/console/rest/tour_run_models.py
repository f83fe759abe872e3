"""Requests about the tour that is under way."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from app.messages import TourButton
from app.tours.values import Id, Language


class NewTourRun(BaseModel):
    """How a tour begins."""

    model_config = ConfigDict(extra="forbid", title="NewTourRun")

    begin: Literal["now", "visitors"] = Field(
        "now", description="Now, or when visitors or the schedule begin it, as the tour says, again and again."
    )
    language: Language | None = Field(None, description="That the robot speaks; left out: the tour's first.")


class TourPress(BaseModel):
    """One thing that is done with the tour under way."""

    model_config = ConfigDict(extra="forbid", title="TourPress")

    button: TourButton | None = Field(None, description="A button, one of `buttons` now.")
    stop: Id | None = Field(None, description="Id of a stop to go to.")
    ask: Id | None = Field(None, description="Id of a question that a visitor asks, one of `questions` now.")
