"""The rate at which one viewer of the scene is served."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Pace:
    """At most ``points`` of a cloud, ``period_s`` between two updates, and whether the ``costmap`` is shown."""

    points: int
    period_s: float
    costmap: bool = False


#: Of a viewer that is not known yet, or not any more.
AT_LEAST = Pace(0, 1.0)
