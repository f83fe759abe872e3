"""Recharge: the motivation that desires the dock when the battery runs low.

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ Recharge   in   battery  BatteryState, 1 Hz; never filtered                              │
    │            states a desire of class Dock                                                 │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

Below the charge ``low`` it desires to dock, the more intensely the less is left, and no longer once the battery is
``full``. So a desire for another place that is more intense than this one still has its way while there is enough left.
Where docking fails, people are asked for help, and it is tried again after ``again_s``.
"""

from __future__ import annotations

import math
from typing import Self

from pydantic import Field, model_validator

from app.attention.desires import SCALE
from app.attention.timeline import Timeline
from app.attention.workspace import IntentionWorkspace, UnknownDesire
from app.messages import BatteryState
from app.modules.motivations.motivation import Motivation
from app.runtime.module import ModuleContext, Settings

DOCK = "Dock"
#: Intensities change in such steps: each change is a problem to solve.
_STEP = 0.5


class RechargeSettings(Settings):
    """Settings of Recharge; charges are shares of the capacity."""

    low: float = Field(0.25, gt=0, lt=1, description="below this charge it desires the dock")
    urgent: float = Field(0.05, ge=0, lt=1, description="at this charge it does so most intensely")
    full: float = Field(0.95, gt=0, le=1, description="at this charge it desires it no longer")
    least: float = Field(2.0, gt=0, le=SCALE, description="intensity of the desire at the charge low")
    most: float = Field(SCALE, gt=0, le=SCALE, description="its intensity at the charge urgent")
    again_s: float = Field(120.0, gt=0, description="time between a dock that was not reached and the next try")

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if not self.urgent < self.low < self.full or self.least > self.most:
            raise ValueError("urgent, low and full must rise, and least not exceed most")
        return self


def intensity_at(charge: float, before: float, settings: RechargeSettings) -> float:
    """Intensity of the desire for the dock at ``charge`` (0 to 1), 0 for none; ``before``: what it was.

    It begins below ``low`` and lasts until ``full``, in steps of half a point.
    """
    if charge >= settings.full or (before == 0.0 and charge >= settings.low):
        return 0.0
    share = min(max((settings.low - charge) / (settings.low - settings.urgent), 0.0), 1.0)
    wanted = settings.least + share * (settings.most - settings.least)
    return min(settings.most, max(settings.least, math.floor(wanted / _STEP + 1e-9) * _STEP))


class Recharge(Motivation):
    """Desires to dock while the battery is low."""

    title = "Recharge"
    motive = "instinctive"
    Settings = RechargeSettings
    settings: RechargeSettings

    _workspace: IntentionWorkspace
    _timeline: Timeline

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.battery = self.input("battery", BatteryState, always_open=True)
        self.on(self.battery, self._take)
        self._intensity = 0.0
        self._desire: str | None = None
        self._not_before = -math.inf

    async def start(self) -> None:
        self._workspace = self.service(IntentionWorkspace)
        self._timeline = self.service(Timeline)

    async def stop(self) -> None:
        """Withdraw the desire."""
        self._withdraw()

    async def _take(self, state: BatteryState) -> None:
        self._intensity = intensity_at(state.charge, self._intensity, self.settings)
        if self._intensity == 0.0:
            self._withdraw()
            return
        now = self.clock.now()
        if self._desire is not None:
            self._keep(now, self._desire)
        elif now >= self._not_before:
            added = self._workspace.add(DOCK, intensity=self._intensity, utility=1.0, source=self.source)
            self._desire = added.id

    def _keep(self, now: float, desire_id: str) -> None:
        try:
            report = self._workspace.report(desire_id)
        except UnknownDesire:
            report = None
        if report is None or report.ended is not None:
            # It was withdrawn by others: the robot is wanted where it is, for a while.
            self._desire, self._not_before = None, now + self.settings.again_s
        elif report.outcome == "failed":
            text = f"Could not dock: {report.reason}. Please help the robot to its dock"
            data = {"reason": report.reason, "again_s": self.settings.again_s}
            self._timeline.add("battery", "not docked", text, data)
            self._withdraw()
            self._not_before = now + self.settings.again_s
        elif report.intensity != self._intensity:
            self._workspace.change(desire_id, intensity=self._intensity)

    def _withdraw(self) -> None:
        desire_id, self._desire = self._desire, None
        if desire_id is None:
            return
        try:
            self._workspace.remove(desire_id)
        except UnknownDesire:
            self.log.debug("desire %s was withdrawn already", desire_id)
