"""RestAfterGesture: the motivation that lets an arm rest after a gesture.

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ RestAfterGesture  in   left, right  Exploitation of an arm each, 10 Hz                   │
    │                   edits desires of class Rest                                            │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

An arm that a behavior has commanded, and none has for ``pause_s``, is desired to rest. The desire leaves when the arm
is at rest, or when another gesture begins; it expires, too.
"""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from functools import partial

from pydantic import Field

from app.attention.desires import SCALE
from app.attention.workspace import IntentionWorkspace, UnknownDesire
from app.messages import Exploitation
from app.modules.motivations.motivation import Motivation
from app.runtime.module import ModuleContext, Settings

REST = "Rest"
#: The desire leaves by itself after so long (s).
_EXPIRES_S = 15.0


class RestAfterGestureSettings(Settings):
    """Settings of RestAfterGesture."""

    pause_s: float = Field(1.5, gt=0, le=60, description="an arm without commands for so long after a gesture rests")
    intensity: float = Field(2.0, gt=0, le=SCALE, description="of the desire Rest")
    utility: float = Field(1.0, gt=0, le=SCALE, description="desired of the class Rest")


@dataclass(slots=True)
class _Arm:
    """``gestured``: stamp (s) of the last command of another behavior than Rest, None once Rest has followed it;
    ``desire``: id of the desire that it rests."""

    gestured: float | None = None
    desire: str | None = None


class RestAfterGesture(Motivation):
    """Desires that an arm rests after a gesture."""

    title = "Rest after a gesture"
    motive = "instinctive"
    Settings = RestAfterGestureSettings
    settings: RestAfterGestureSettings

    _workspace: IntentionWorkspace

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        for side in ("left", "right"):
            self.on(self.input(side, Exploitation), partial(self._take, side))
        self._arms = {"left": _Arm(), "right": _Arm()}

    async def start(self) -> None:
        """Look up the workspace."""
        self._workspace = self.service(IntentionWorkspace)

    async def stop(self) -> None:
        """Withdraw what it desired."""
        for arm in self._arms.values():
            self._withdraw(arm)

    async def _take(self, side: str, report: Exploitation) -> None:
        arm = self._arms[side]
        if report.behavior is not None and report.behavior != REST:
            arm.gestured = report.stamp
            self._withdraw(arm)
        elif report.behavior == REST:
            arm.gestured = None
        elif arm.gestured is not None and report.stamp - arm.gestured >= self.settings.pause_s:
            arm.gestured = None
            arm.desire = self._workspace.add(
                REST,
                intensity=self.settings.intensity,
                utility=self.settings.utility,
                params={"arm": side},
                ttl=_EXPIRES_S,
                source=self.source,
            ).id

    def _withdraw(self, arm: _Arm) -> None:
        if arm.desire is not None:
            # It has rested, or the desire expired.
            with contextlib.suppress(UnknownDesire):
                self._workspace.remove(arm.desire)
            arm.desire = None
