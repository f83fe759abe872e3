"""The desires that a step is made of: the one place that knows the names of desire classes and their parameters."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

from app.tours.steps import Step
from app.tours.values import text_in

SAY: Final = "Say"
POINT_AT: Final = "PointAt"
LOOK_AT: Final = "LookAt"
EXPRESS: Final = "Express"

#: Key of the step, desire class, parameters.
StepDesire = tuple[str, str, dict[str, Any]]


def desires_of(step: Step, language: str, fallback: str) -> Iterator[StepDesire]:
    """The desires of ``step`` in ``language`` (``fallback`` where it has no text in it).

    To look at visitors or at a poster depends on where they are: that is the guide's, and not among them.
    """
    if step.say is not None:
        used = language if language in step.say else fallback
        yield "say", SAY, {"text": text_in(step.say, language, fallback), "language": used}
    if isinstance(step.look, tuple):
        yield "look", LOOK_AT, _on_map(step.look)
    if step.point is not None:
        yield "point", POINT_AT, _on_map(step.point)
    if step.gesture is not None:
        yield "gesture", step.gesture.cls, dict(step.gesture.params)
    if step.expression is not None:
        yield "expression", EXPRESS, {"expression": step.expression}


def _on_map(point: tuple[float, float, float]) -> dict[str, Any]:
    x, y, z = point
    return {"x": x, "y": y, "z": z, "frame": "map"}
