"""Emotions: what the robot feels of how its desires fare, and what that does to those that are ignored.

    ┌─────────────────────────────────────────────────────────────────────────────────────────────┐
    │ Emotions  in   desires    Desires: exploited, intended                                       │
    │           out  emotions   EmotionState, on change, at most once a second                     │
    │           raises intensities in the Intention Workspace, if it `modulates`                   │
    └─────────────────────────────────────────────────────────────────────────────────────────────┘

What is felt follows from :mod:`app.attention.emotions`, what is raised from :mod:`app.attention.modulation`. Feelings
outlast a restart of the module; what is raised does not.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Final

from pydantic import BaseModel, ConfigDict, Field

from app.attention.desires import SCALE
from app.attention.emotions import (
    DECAY_PER_S,
    EMOTIONS,
    PUBLISHED,
    Effects,
    EmotionDynamics,
    Fates,
    fates,
    sources,
)
from app.attention.modulation import ModulationLimits, Modulator
from app.attention.workspace import IntentionWorkspace
from app.base.yaml_source import suggestion
from app.messages import (
    Desires,
    Emotion,
    EmotionLevel,
    EmotionSource,
    EmotionState,
    Modulation,
    RaisedIntensity,
)
from app.runtime.module import Caution, Module, ModuleContext, Settings

_BEAT_S: Final = 1.0
_MOST_SOURCES: Final = 5
#: Kept over restarts: what is felt.
_FELT: Final = "felt"

Rate = Annotated[float, Field(ge=-1, le=1)]


class EffectsSettings(BaseModel):
    """What a desired class does to emotions, per second; an emotion that is not named is left alone."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    exploited: dict[Emotion, Rate] = Field(default_factory=dict, description="while it is exploited")
    neglected: dict[Emotion, Rate] = Field(default_factory=dict, description="while it is not")

    @property
    def effects(self) -> Effects:
        return Effects(self.exploited, self.neglected)


class EmotionsSettings(Settings):
    """What makes the robot feel, and how far that may go."""

    modulates: bool = Field(False, description="whether emotions raise the intensity of desires that are ignored")
    most: float = Field(2.0, gt=0, le=SCALE, description="greatest rise of an intensity")
    settle_s: float = Field(
        5.0,
        gt=0,
        le=3600,
        description="desires have been the same for so long before one counts as ignored; "
        "longer than attention.hysteresis_dwell_s",
    )
    again_s: float = Field(120.0, ge=0, le=86_400, description="a class is raised again only after so long")
    decay_per_s: float = Field(DECAY_PER_S, ge=0, le=1, description="loss of each emotion per second; 0: none")
    effects: dict[str, EffectsSettings] = Field(
        default_factory=dict,
        description="by desire class, beside those published, or instead of them",
    )


class Emotions(Module):
    """Feels, and raises what is ignored."""

    title = "Emotions"
    Settings = EmotionsSettings
    settings: EmotionsSettings

    _workspace: IntentionWorkspace

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        settings = self.settings
        self.on(self.input("desires", Desires, capacity=32, wants="never"), self._take)
        self.output_emotions = self.output("emotions", EmotionState)
        self.every(_BEAT_S, self._beat)
        given = {cls: each.effects for cls, each in settings.effects.items()}
        known = self.persistent.get(_FELT)
        effects = {**PUBLISHED, **given}
        if isinstance(known, EmotionDynamics):
            self._felt = known
        else:
            self._felt = self.persistent[_FELT] = EmotionDynamics(effects, settings.decay_per_s)
        self._modulator = Modulator(ModulationLimits(settings.most, settings.settle_s, settings.again_s))
        self._desires: Desires | None = None
        self._how = Fates()
        self._felt_until = 0.0
        self._raised: dict[str, Modulation] = {}
        self._shown: EmotionState | None = None

    def cautions(self) -> tuple[Caution, ...]:
        """Classes in the settings that the program does not have."""
        if IntentionWorkspace not in self._context.services:
            return ()
        classes = self.service(IntentionWorkspace).classes
        says = f"{self.name}.settings.effects names"
        return tuple(
            Caution(
                "An emotion waits in vain",
                f"{says} {cls!r}, which is no desire class; {suggestion(cls, list(classes))}",
            )
            for cls in self.settings.effects
            if cls not in classes
        )

    async def start(self) -> None:
        """Begin to feel."""
        self._workspace = self.service(IntentionWorkspace)
        self._felt_until = self.clock.now()
        self._publish()

    async def stop(self) -> None:
        """Raise nothing."""
        if hasattr(self, "_workspace"):
            self._workspace.modulate({})

    def _take(self, message: Desires) -> None:
        # How desires fared holds up to now.
        self._feel()
        self._desires, self._how = message, fates(message)

    def _beat(self) -> None:
        self._feel()
        self._modulate()
        self._publish()

    def _feel(self) -> None:
        now = self.clock.now()
        self._felt.advance(max(0.0, now - self._felt_until), self._how)
        self._felt_until = now

    def _modulate(self) -> None:
        known = self._desires
        # A recording of an older program does not say what is intended.
        if not self.settings.modulates or known is None or (known.desires and not known.progress):
            return
        intended = [each.id for each in known.progress if each.intended]
        raised = self._modulator.update(self.clock.now(), known.desires, intended, self._felt.shares)
        if raised != self._raised:
            self._raised = raised
            self._workspace.modulate(raised)

    def _publish(self) -> None:
        """Publish what is felt, if it is not what was published last."""
        classes = {} if self._desires is None else {desire.id: desire.cls for desire in self._desires.desires}
        state = EmotionState(
            0.0,
            tuple(self._level(emotion) for emotion in EMOTIONS),
            modulates=self.settings.modulates,
            raised=tuple(
                RaisedIntensity(id_, classes.get(id_, ""), each.by, each.emotion) for id_, each in self._raised.items()
            ),
        )
        if state != self._shown:
            self._shown = state
            self.output_emotions.publish(replace(state, stamp=self.clock.now()))

    def _level(self, emotion: Emotion) -> EmotionLevel:
        shares = self._felt.shares[emotion]
        return EmotionLevel(
            emotion,
            round(self._felt.intensity(emotion), 3),
            tuple(
                EmotionSource(cls, round(share, 3), cls in self._how.neglected)
                for cls, share in sources(shares, _MOST_SOURCES)
            ),
        )
