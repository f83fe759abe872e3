"""What attention publishes: the intention in force and its reasons. Recorded as any message; no module acts on it.

A class with a field ``cls`` is a Struct, for its JSON has a member ``class``. A closed filter's φ is inf.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from msgspec import Struct

from app.messages.base import Stamp, doc

ReasonState = Literal["fulfilled", "degraded", "unfulfilled", "inhibited"]

Divisor = Annotated[float, doc("φ: one message in φ passes; null: none passes.", nullable=True)]


@dataclass(frozen=True, slots=True)
class Alternative:
    """A change that would serve a desire better: more of a resource, or no desire for another class."""

    kind: Literal["capacity", "without"]
    utility: Annotated[float, doc("The utility that the class would get.")]
    resource: Annotated[str, doc("Of `capacity`: the resource; else empty.")] = ""
    amount: Annotated[float, doc("Of `capacity`: how much more of it.")] = 0.0
    unit: str = ""
    without: Annotated[str, doc("Of `without`: the other class; else empty.")] = ""


@dataclass(frozen=True, slots=True)
class Reason:
    """Why a desired class gets what it gets."""

    state: ReasonState
    utility: Annotated[float, doc("The utility it gets.")]
    wanted: Annotated[float, doc("The utility desired.")]
    best: Annotated[float, doc("The most that any selection could give it.")]
    text: Annotated[str, doc("The reason in words.")]
    alternatives: tuple[Alternative, ...] = ()
    searched: Annotated[bool, doc("Whether the search for alternatives was complete.")] = True


class SelectedStrategy(Struct, frozen=True, rename={"cls": "class"}):
    """A strategy at work."""

    name: str
    cls: str
    utility: float
    filters: Mapping[str, Divisor]
    costs: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class ResourceUse:
    """What is used of a resource."""

    used: float
    capacity: float
    unit: str


@dataclass(frozen=True, slots=True)
class IntentionReport:
    """The intention at work: what was selected, what follows from it, and why. Published when it is put in force, and
    again once its reasons are complete."""

    stamp: Stamp
    strategies: tuple[SelectedStrategy, ...]
    fulfilled: Annotated[tuple[str, ...], doc("Classes whose strongest desire is fulfilled.")]
    omega: Annotated[float, doc("Ω, what the selection is worth (thesis, equation 4.9).")]
    bound: Annotated[
        float,
        doc("No selection can be worth more; equal to `omega` when proven, null where none is known.", nullable=True),
    ]
    use: Mapping[str, ResourceUse]
    filters: Annotated[Mapping[str, Divisor], doc("φ of every filter that attention controls.")]
    proven: Annotated[bool, doc("Whether no better selection exists.")]
    solve_ms: float
    relaxed: Annotated[tuple[str, ...], doc("Security desires that could not be kept.")]
    reasons: Annotated[Mapping[str, Reason], doc("By desired class.")]
    parameters: Annotated[Mapping[str, Mapping[str, Any]], doc("What each module was handed.")]
    desires: Annotated[Mapping[str, str], doc("Id of the strongest desire of each class that it answers.")]
