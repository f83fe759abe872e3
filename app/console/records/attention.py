"""Lists of what attention reports."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from app.attention.desires import Desire
from app.attention.reports import DesireClassReport, ResourceReport, Scale, StrategyReport
from app.attention.timeline import TimelineEvent
from app.messages.base import doc


@dataclass(frozen=True, slots=True)
class DesireList:
    """Every desire, in the order they came."""

    desires: tuple[Desire, ...]
    exploited: Annotated[
        tuple[str, ...], doc("Ids of those that a behavior serves by commands that its arbiter lets through now.")
    ]


@dataclass(frozen=True, slots=True)
class DesireClassList:
    """Every desire class, in the order the console shows them, and the ends of the scales."""

    classes: tuple[DesireClassReport, ...]
    scale: Scale


@dataclass(frozen=True, slots=True)
class StrategyList:
    """Every strategy, in table order."""

    strategies: tuple[StrategyReport, ...]


@dataclass(frozen=True, slots=True)
class ResourceList:
    """Every resource."""

    resources: tuple[ResourceReport, ...]


@dataclass(frozen=True, slots=True)
class EventList:
    """Events, oldest first."""

    events: tuple[TimelineEvent, ...]
