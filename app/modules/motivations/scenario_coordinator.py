"""ScenarioCoordinator: the motivation that posts the scenario's desires (thesis 4.2.5, 4.4).

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ ScenarioCoordinator    in   landmarks  Landmarks (m in odom), as they come; may be absent│
    │                        in   noises     LoudNoise, as they come; may be absent            │
    │                        in   sources    SoundSources, as they come; may be absent         │
    │                        writes desires into the Intention Workspace                       │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

At start it posts its desires in one transaction, when it stops it removes those that are left. The default is the
thesis's desires at the start of the tour-guide configuration, of the classes that exist: FindQRCodes, LocateFaces,
DetectNoises and SLAM (i 8, u 1) and Teleoperation (i 8, u 1, security). A code found for the first time is logged.

A loud noise makes it desire LocateVoices (i 8, u 1) for ``listen_s``; the desire is renewed while a voice is located
(thesis 4.4): a cheap detector that always runs activates an expensive one.
"""

from __future__ import annotations

import math
from typing import Any

from pydantic import BaseModel, Field

from app.attention.workspace import IntentionWorkspace, UnknownDesire
from app.messages import Landmarks, LoudNoise, SoundSources
from app.modules.motivations.motivation import Motivation
from app.runtime.module import ModuleContext, Settings

LISTEN = "LocateVoices"
_BEAT_S = 0.25
#: Renewed this long before its end, so that it does not lapse between two ticks.
_AHEAD_S = 2 * _BEAT_S


class DesireSettings(BaseModel, frozen=True, extra="forbid", populate_by_name=True):
    """One desire to post, from configuration."""

    cls: str = Field(alias="class", description="the desire class")
    intensity: float = Field(8, gt=0, le=8)
    utility: float = Field(1, ge=0, le=8, description="desired utility; 0 inhibits the class")
    security: bool = Field(False, description="must be fulfilled")
    params: dict[str, Any] = Field(default_factory=dict, description="as the class declares them")


USUAL = (
    DesireSettings(cls="FindQRCodes"),
    DesireSettings(cls="LocateFaces"),
    DesireSettings(cls="DetectNoises"),
    DesireSettings(cls="SLAM"),
    DesireSettings(cls="Teleoperation", security=True),
)


class ScenarioCoordinatorSettings(Settings):
    desires: tuple[DesireSettings, ...] | None = Field(
        None, description="what it desires from start to stop; none said: the usual ones, of the classes there are"
    )
    listen_s: float = Field(5.0, ge=1, description="a loud noise makes it listen so long, a voice so long again")
    voice: float = Field(0.5, ge=0, le=1, description="a source at least this probably speech is a voice")


class ScenarioCoordinator(Motivation):
    title = "Scenario coordinator"
    Settings = ScenarioCoordinatorSettings
    settings: ScenarioCoordinatorSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.landmarks = self.input("landmarks", Landmarks)
        self.noises = self.input("noises", LoudNoise, capacity=8)
        self.sources = self.input("sources", SoundSources)
        self.on(self.landmarks, self._take_landmarks)
        self.on(self.noises, self._take_noise)
        self.on(self.sources, self._take_sources)
        self.every(_BEAT_S, self._keep_listening)
        self._posted: list[str] = []
        self._listening: str | None = None
        self._ends = -math.inf
        self._voice_heard = False
        self._known = 0

    async def start(self) -> None:
        """Post the desires; all or none.

        Raises UnknownDesireClass or InvalidDesire, which name the fault.
        """
        workspace = self.service(IntentionWorkspace)
        wanted = self.settings.desires
        if wanted is None:
            wanted = tuple(desire for desire in USUAL if desire.cls in workspace.classes)
        posted = []
        with workspace.transaction():
            for desire in wanted:
                added = workspace.add(
                    desire.cls,
                    intensity=desire.intensity,
                    utility=desire.utility,
                    security=desire.security,
                    params=desire.params,
                    source=self.source,
                )
                posted.append(added.id)
        self._posted = posted

    async def stop(self) -> None:
        posted = [*self._posted, *([self._listening] if self._listening is not None else [])]
        if not posted:
            return
        workspace = self.service(IntentionWorkspace)
        with workspace.transaction():
            for desire_id in posted:
                try:
                    workspace.remove(desire_id)
                except UnknownDesire:
                    self.log.info("desire %s was already gone", desire_id)
        self._posted, self._listening = [], None

    async def _take_landmarks(self, message: Landmarks) -> None:
        for landmark in message.landmarks[self._known :]:
            x, y, _ = landmark.p_FQ
            self.log.info("found QR code %r at x %.2f m, y %.2f m in %s", landmark.text, x, y, message.frame)
        self._known = max(self._known, len(message.landmarks))

    async def _take_noise(self, noise: LoudNoise) -> None:
        self._listen(because=f"a noise {noise.ratio:.0f} times louder than before")

    async def _take_sources(self, heard: SoundSources) -> None:
        # A source without a speech probability may be a voice.
        self._voice_heard |= any(s.active and not s.speech < self.settings.voice for s in heard.sources)

    async def _keep_listening(self) -> None:
        if self._listening is None or self.clock.now() < self._ends - _AHEAD_S:
            return
        if self._voice_heard:
            self._listen(because="a voice")
        elif self.clock.now() >= self._ends:
            self._listening = None  # it expires by itself

    def _listen(self, because: str) -> None:
        """Desire LocateVoices for ``listen_s`` from now on, whether or not it is desired already."""
        workspace = self.service(IntentionWorkspace)
        if LISTEN not in workspace.classes:
            return
        listen_s = self.settings.listen_s
        self._voice_heard = False
        self._ends = self.clock.now() + listen_s
        if self._listening is not None:
            try:
                workspace.change(self._listening, ttl=listen_s)
                return
            except UnknownDesire:
                pass  # it expired or was removed
        self.log.info("listens for voices: heard %s", because)
        self._listening = workspace.add(LISTEN, intensity=8, utility=1, ttl=listen_s, source=self.source).id
