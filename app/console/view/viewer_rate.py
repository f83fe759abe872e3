"""The rate at which one viewer of the scene is served, and what it wants to see."""

from __future__ import annotations

from dataclasses import dataclass, field

from app.console.view.viewpoints import Choice


@dataclass(frozen=True, slots=True)
class Pace:
    """At most ``points`` of a cloud, ``period_s`` between two updates, whether the ``costmap`` is shown, the viewpoint
    that was chosen, and the measured round trip ``lag_s``, None before it is known."""

    points: int
    period_s: float
    costmap: bool = False
    choice: Choice = field(default_factory=Choice)
    lag_s: float | None = None


#: Of a viewer that is not known yet, or not any more.
AT_LEAST = Pace(0, 1.0)
