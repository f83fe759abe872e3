"""An intention put in force: parameters first, then filters, and only what has changed."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from typing import Any

from app.attention.intention import Intention
from app.attention.interfaces import FilterTarget, ParameterSink
from app.attention.timeline import Timeline

_log = logging.getLogger(__name__)


def enforce(
    before: Intention | None, after: Intention, *, filters: FilterTarget, parameters: ParameterSink, timeline: Timeline
) -> dict[str, float]:
    """Put ``after`` in force in the place of ``before``; returns the φ that changed, by filter.

    A module that refuses its parameters is noted on the timeline, and changes nothing else.
    """
    _configure({} if before is None else before.parameters, after.parameters, parameters, timeline)
    old = {} if before is None else before.divisors
    changed = {name: phi for name, phi in after.divisors.items() if old.get(name) != phi}
    if changed:
        filters.apply(changed)
    return changed


def _configure(
    before: Mapping[str, Mapping[str, Any]],
    after: Mapping[str, Mapping[str, Any]],
    sink: ParameterSink,
    timeline: Timeline,
) -> None:
    for module in sorted({*before, *after}):
        parameters = after.get(module, {})
        if parameters == before.get(module, {}):
            continue
        try:
            sink.configure(module, parameters)
        except Exception as failure:  # noqa: BLE001 - one module's refusal must not stop the others' attention
            text = f"{module} refused its parameters: {type(failure).__name__}: {failure}"
            _log.error("%s", text)
            timeline.add("module", module, text, {"parameters": dict(parameters)})
