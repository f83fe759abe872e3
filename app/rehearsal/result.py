"""What a rehearsal found."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from app.messages.base import doc

Seconds = Annotated[float, doc("Since the rehearsal's begin, s.")]


@dataclass(frozen=True, slots=True)
class RehearsedState:
    """A state of the guide, as it began."""

    at_s: Seconds
    state: str
    stop: Annotated[str, doc("Id of the stop; empty: none.")]
    reason: Annotated[str, doc("In words; may be empty.")]


@dataclass(frozen=True, slots=True)
class Subtitle:
    """A sentence that was said."""

    at_s: Seconds
    until_s: Seconds
    text: str
    language: str


@dataclass(frozen=True, slots=True)
class RehearsedPose:
    """Where the robot was, on the map (m, rad), and how far the farthest visitor was from it (m; null: nobody)."""

    at_s: Seconds
    x: float
    y: float
    heading: float
    farthest_m: float | None


@dataclass(frozen=True, slots=True)
class RehearsalProblem:
    """What would go wrong. An ``error`` keeps the tour from being led as it is written; a ``warning`` does not."""

    severity: Literal["error", "warning"]
    stop: Annotated[str, doc("Id of the stop; empty: none.")]
    message: Annotated[str, doc("One sentence.")]
    at_s: float | None = None


@dataclass(frozen=True, slots=True)
class Rehearsal:
    """A tour as it was rehearsed."""

    tour: str
    language: str
    outcome: Annotated[str, doc("Why it ended, in words.")]
    duration_s: Seconds
    driven_m: float
    stops: Annotated[tuple[str, ...], doc("Ids of those that were presented, in order.")]
    states: tuple[RehearsedState, ...]
    subtitles: tuple[Subtitle, ...]
    path: tuple[RehearsedPose, ...]
    problems: tuple[RehearsalProblem, ...]

    @property
    def can_be_led(self) -> bool:
        """Whether nothing would keep it from being led as it is written."""
        return not any(problem.severity == "error" for problem in self.problems)
