"""Drives: needs that grow while nothing sates them, and desire something as they do. A base class for motivations.

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ Drive  in  what a subclass declares: what sates it                                       │
    │        states a desire of the class ``drive_class``                                      │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

After the drives of Kismet (Breazeal, Designing Sociable Robots, MIT Press 2002, chapter 8): the level of a drive rises
steadily towards 1 where nothing happens that sates it, and falls by what does. Here a desire comes at ``begins``, grows
with the level, and goes at ``ends``: between them lies the hysteresis, so that a drive does not flicker. A subclass
names ``drive_class``, and calls :meth:`Drive.sate`; as long as ``grows_s`` is not set a drive is off.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar, Self

from pydantic import Field, model_validator

from app.attention.desires import SCALE
from app.attention.workspace import IntentionWorkspace, UnknownDesire
from app.modules.motivations.motivation import Motivation
from app.runtime.module import ModuleContext, Settings

_BEAT_S = 1.0
#: Intensities change in such steps: each change is a problem to solve.
_STEP = 0.5
#: Key of the level that the next instance takes over.
_KEPT = "level"


class DriveSettings(Settings):
    """Settings of a drive; levels are 0 (sated) to 1."""

    grows_s: float | None = Field(None, gt=0, description="time from sated to a level of 1; null: the drive is off")
    begins: float = Field(0.8, gt=0, le=1, description="level at which it desires")
    ends: float = Field(0.1, ge=0, lt=1, description="level at which it no longer does")
    least: float = Field(1.0, gt=0, le=SCALE, description="intensity of its desire as it begins")
    most: float = Field(2.0, gt=0, le=SCALE, description="intensity at a level of 1")

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if not self.ends < self.begins or self.least > self.most:
            raise ValueError("ends must be less than begins, and least not exceed most")
        return self


def grown(level: float, elapsed_s: float, settings: DriveSettings) -> float:
    """``level`` (0 to 1) after so many seconds in which nothing sated the drive."""
    return level if settings.grows_s is None else min(1.0, level + elapsed_s / settings.grows_s)


def urge(level: float, before: float, settings: DriveSettings) -> float:
    """Intensity of the desire at ``level``, 0 for none; ``before``: what it was. In steps of half a point."""
    if level < settings.begins and (before == 0.0 or level <= settings.ends):
        return 0.0
    share = (level - settings.begins) / (1.0 - settings.begins) if settings.begins < 1.0 else 1.0
    wanted = settings.least + min(max(share, 0.0), 1.0) * (settings.most - settings.least)
    return max(settings.least, math.floor(wanted / _STEP + 1e-9) * _STEP)


class Drive(Motivation):
    """A need that grows: the base class. A desire of it that ends, in whatever way, sates it wholly."""

    motive = "instinctive"
    #: Class of the desires that it states.
    drive_class: ClassVar[str]
    Settings = DriveSettings
    settings: DriveSettings

    _workspace: IntentionWorkspace

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.every(_BEAT_S, self._drive)
        self._urge = 0.0
        #: The id of the desire that it has stated.
        self._stated: str | None = None
        self._beat: float | None = None

    @property
    def level(self) -> float:
        """From 0, sated, to 1."""
        return float(self.persistent.get(_KEPT, 0.0))

    def sate(self, share: float = 1.0) -> None:
        """Take ``share`` (0 to 1) of the whole range from the level."""
        self.persistent[_KEPT] = max(0.0, self.level - share)

    def grows(self) -> bool:
        """Whether the need grows now; to be overridden by one that does only at times."""
        return True

    def drive_parameters(self) -> Mapping[str, Any]:
        """Parameters of the desire; to be overridden where the class has some."""
        return {}

    async def start(self) -> None:
        self._workspace = self.service(IntentionWorkspace)

    async def stop(self) -> None:
        """Withdraw the desire."""
        self._sleep()

    async def _drive(self) -> None:
        if self.settings.grows_s is None:
            return
        now = self.clock.now()
        last, self._beat = self._beat, now
        if self._stated is not None and not self._is_there(self._stated):
            self._stated, self._urge = None, 0.0
            self.sate()
        elif last is not None and self.grows():
            self.persistent[_KEPT] = grown(self.level, now - last, self.settings)
        before, self._urge = self._urge, urge(self.level, self._urge, self.settings)
        if self._urge == 0.0:
            self._sleep()
        elif self._stated is None:
            self._stated = self._workspace.add(
                self.drive_class,
                intensity=self._urge,
                utility=1.0,
                source=self.source,
                params=self.drive_parameters(),
            ).id
        elif before != self._urge:
            self._workspace.change(self._stated, intensity=self._urge)

    def retract(self, desire_id: str | None) -> None:
        """Withdraw a desire that may have left already; None: there is none."""
        if desire_id is not None and self._is_there(desire_id):
            self._workspace.remove(desire_id)

    def _sleep(self) -> None:
        stated, self._stated = self._stated, None
        self.retract(stated)

    def _is_there(self, desire_id: str) -> bool:
        try:
            self._workspace.get(desire_id)
        except UnknownDesire:
            return False
        return True
