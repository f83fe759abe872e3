"""ScenarioCoordinator: the motivation that wants what the scenario needs (thesis 4.2.5, 4.4).

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ ScenarioCoordinator    in   landmarks  Landmarks (m in odom), as they come; may be absent│
    │                        writes desires into the Intention Workspace                       │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

At start it posts its desires in one transaction, when it stops it takes back those that still stand. By default the
thesis's desires at the start of the tour-guide configuration, for the classes there are: FindQRCodes (i 8, u 1) and
Teleoperation (i 8, u 1, security). A code found for the first time is logged.
"""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from app.attention.desires import Source
from app.attention.workspace import IntentionWorkspace, UnknownDesire
from app.messages import Landmarks
from app.runtime.module import Module, ModuleContext, Settings


class DesireSettings(BaseModel):
    """One desire to post, as it stands in configuration."""

    model_config = ConfigDict(frozen=True, extra="forbid", populate_by_name=True)

    cls: str = Field(alias="class", description="the desire class")
    intensity: float = Field(8, gt=0, le=8)
    utility: float = Field(1, ge=0, le=8, description="desired utility; 0 inhibits the class")
    security: bool = Field(False, description="must be fulfilled")
    params: dict[str, Any] = Field(default_factory=dict, description="as the class declares them")


class ScenarioCoordinatorSettings(Settings):
    """Settings of ScenarioCoordinator."""

    desires: tuple[DesireSettings, ...] = (
        DesireSettings(cls="FindQRCodes"),
        DesireSettings(cls="Teleoperation", security=True),
    )


class ScenarioCoordinator(Module):
    """Posts the scenario's desires and takes them back."""

    title = "Scenario coordinator"
    Settings = ScenarioCoordinatorSettings
    settings: ScenarioCoordinatorSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._desires = self.settings.desires
        self.landmarks = self.input("landmarks", Landmarks)
        self.on(self.landmarks, self._notice)
        self._posted: list[str] = []
        self._known = 0

    async def start(self) -> None:
        """Post the desires; all or none.

        Raises UnknownDesireClass or InvalidDesire, which name what is wrong, for a desire that cannot be.
        """
        workspace = self.service(IntentionWorkspace)
        source = Source("motivation", self.name)
        posted = []
        with workspace.transaction():
            for wanted in self._desires:
                desire = workspace.add(
                    wanted.cls,
                    intensity=wanted.intensity,
                    utility=wanted.utility,
                    security=wanted.security,
                    params=wanted.params,
                    source=source,
                )
                posted.append(desire.id)
        self._posted = posted

    async def stop(self) -> None:
        """Take back what was posted and still stands."""
        if not self._posted:
            return
        workspace = self.service(IntentionWorkspace)
        with workspace.transaction():
            for desire_id in self._posted:
                try:
                    workspace.remove(desire_id)
                except UnknownDesire:
                    self.log.info("desire %s was already gone", desire_id)
        self._posted = []

    async def _notice(self, message: Landmarks) -> None:
        for landmark in message.landmarks[self._known :]:
            x, y, _ = landmark.p_OQ
            self.log.info("found QR code %r at x %.2f m, y %.2f m in odom", landmark.text, x, y)
        self._known = max(self._known, len(message.landmarks))
