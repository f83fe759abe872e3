"""Emotions: what the robot feels of how its desires fare, what of it shows, and what it does to what is ignored.

    ┌─────────────────────────────────────────────────────────────────────────────────────────────┐
    │ Emotions  in   desires    Desires: exploited, intended                                       │
    │           out  emotions   EmotionState, on change, at most once a second                     │
    │           raises intensities in the Intention Workspace, if it `modulates`                   │
    │           states a desire of class Express, if it `shows`                                    │
    └─────────────────────────────────────────────────────────────────────────────────────────────┘

What is felt follows from :mod:`app.attention.emotions`, what is raised from :mod:`app.attention.modulation`, what shows
from :mod:`app.attention.showing`. Feelings outlast a restart of the module; what is raised and what shows does not.
The module's own desire is neither felt nor raised.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Final, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

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
from app.attention.showing import STEP, Showing, ShowingLimits
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
    ShownEmotion,
)
from app.modules.motivations.face_wish import FaceWish
from app.modules.motivations.motivation import Motivation
from app.runtime.module import Caution, ModuleContext, Settings

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
    shows: bool = Field(False, description="whether face and voice show what is felt")
    shows_from: float = Field(0.5, gt=0, le=1, description="an emotion this strong begins to show")
    shows_until: float = Field(0.3, ge=0, lt=1, description="below it, it shows no more")
    shows_most: float = Field(0.75, ge=STEP, le=1, description="how strongly it shows at most; 1: all of an expression")
    decay_per_s: float = Field(DECAY_PER_S, ge=0, le=1, description="loss of each emotion per second; 0: none")
    effects: dict[str, EffectsSettings] = Field(
        default_factory=dict,
        description="by desire class, beside those published, or instead of them",
    )

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if not self.shows_until < self.shows_from:
            raise ValueError("shows_until must be less than shows_from")
        return self


class Emotions(Motivation):
    """Feels, shows it, and raises what is ignored."""

    title = "Emotions"
    motive = "emotional"
    Settings = EmotionsSettings
    settings: EmotionsSettings

    _workspace: IntentionWorkspace
    _face: FaceWish

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
        self._showing = Showing(ShowingLimits(settings.shows_from, settings.shows_until, settings.shows_most))
        self._desires: Desires | None = None
        self._how = Fates()
        self._felt_until = 0.0
        self._raised: dict[str, Modulation] = {}
        self._shown: ShownEmotion | None = None
        self._published: EmotionState | None = None

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
        self._face = FaceWish(self._workspace, self.source)
        self._face.start()
        self._felt_until = self.clock.now()
        self._publish()

    async def stop(self) -> None:
        """Raise and show nothing."""
        if not hasattr(self, "_face"):
            return
        self._workspace.modulate({})
        self._face.stop()
        last = self._published
        if last is not None and (last.raised or last.shown is not None):
            self.output_emotions.publish(replace(last, stamp=self.clock.now(), raised=(), shown=None))

    def _take(self, message: Desires) -> None:
        # How desires fared holds up to now.
        self._feel()
        others = tuple(desire for desire in message.desires if desire.source != self.source)
        self._desires = replace(message, desires=others)
        self._how = fates(self._desires)

    def _beat(self) -> None:
        self._feel()
        self._modulate()
        if self.settings.shows:
            self._shown = self._showing.update({emotion: self._felt.intensity(emotion) for emotion in EMOTIONS})
            self._face.show(self._shown)
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
            shows=self.settings.shows,
            shown=None if self._shown is None else replace(self._shown, desire=self._face.desire),
        )
        if state != self._published:
            self._published = state
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
