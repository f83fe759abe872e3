"""Reasons found beside the event loop."""

from __future__ import annotations

import logging
from collections.abc import Awaitable, Callable, Mapping
from typing import Any, Final

from app.attention.problem import Selection, SelectionProblem
from app.attention.reasons import explain
from app.attention.strategies import Resource
from app.messages import Reason

_log = logging.getLogger(__name__)

EXPLAIN_S: Final = 0.05
"""Real seconds that reasons may take."""


class Explainer:
    """Finds the reasons of intentions, with what would help, within ``limit_s``; 0 finds none."""

    def __init__(
        self, resources: Mapping[str, Resource], limit_s: float, offload: Callable[..., Awaitable[Any]]
    ) -> None:
        self._resources = resources
        self._limit_s = limit_s
        self._offload = offload

    async def reasons(
        self, problem: SelectionProblem, selection: Selection, give_up: Callable[[], bool]
    ) -> dict[str, Reason] | None:
        """The reasons; None, and an entry in the log, if they cannot be found. ``give_up`` is true when they are no
        longer needed."""
        if self._limit_s <= 0:
            return None
        try:
            found: dict[str, Reason] = await self._offload(self._explain, problem, selection, give_up)
        except Exception as failure:  # noqa: BLE001 - logged; an intention is in force without its reasons too
            _log.exception("no reasons for the intention: %s", failure)
            return None
        return found

    def _explain(
        self, problem: SelectionProblem, selection: Selection, give_up: Callable[[], bool]
    ) -> dict[str, Reason]:
        return explain(problem, selection, time_limit_s=self._limit_s, resources=self._resources, give_up=give_up)
