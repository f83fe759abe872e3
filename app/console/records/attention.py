"""Lists of what attention reports."""

from __future__ import annotations

from dataclasses import dataclass

from app.messages import DesireClassReport, ResourceReport, Scale, StrategyReport, TimelineEvent


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
