"""The JSON of :class:`app.messages.NavigationReport`, in which NaN is null and arrays are lists."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, Field

from app.messages.base import Stamp


class GoalPoseModel(BaseModel):
    """A goal on the map."""

    x: float
    y: float
    theta: float | None = Field(description="null: any heading.")


class GivenUpModel(BaseModel):
    """A goal that the robot has given up."""

    stamp: Stamp
    goal: GoalPoseModel
    reason: str = Field(description="Why, in words.")


class NavigationModel(BaseModel):
    """State of the behavior that drives to a goal; as `navigation` on the live stream."""

    stamp: Stamp
    behavior: str = Field(description="Empty before the first report.")
    state: Literal["idle", "planning", "following", "recovering", "waiting", "arrived", "unreachable"]
    reason: str = Field(description="In words, and what would help.")
    goal: GoalPoseModel | None
    target: GoalPoseModel | None = Field(description="The nearest reachable place, which it drives to.")
    remaining_m: float | None
    recoveries: int
    desire: str | None = Field(description="Id of the strongest desire to go somewhere.")
    path: list[tuple[float, float]] = Field(description="Points on the map (m), at most 200.")
    given_up: GivenUpModel | None = Field(
        description="The goal given up last, until there is another or DELETE /goal; null: none."
    )
