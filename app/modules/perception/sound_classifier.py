"""SoundClassifier: what kind of sound is heard, by one front microphone.

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ SoundClassifier    in   audio    Audio, 16 kHz or more, all frames (lossless)            │
    │                    out  classes  SoundClass, 4 Hz: of the second before                  │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

Each quarter of a second, the last second is judged by ``sound_classes``: silence, voice-like, tonal, impulsive or
broadband. After a gap in the sound it is silent for a second.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from app.attention.desires import DesireClass
from app.messages import Audio, SoundClass
from app.modules.perception.overruns import Overruns
from app.modules.perception.sound_classes import LEAST_RATE_HZ, Thresholds, classify, features
from app.runtime.errors import InboxOverflow, ModuleFailed
from app.runtime.module import Module, ModuleContext, Settings

#: Inbox capacity: a second of frames, for stalls of the event loop.
_CAPACITY = 94
#: Length of what is judged, and time between two judgements (s).
STRETCH_S, EVERY_S = 1.0, 0.25


class SoundClassifierSettings(Settings):
    """Settings of SoundClassifier."""

    microphone: int = Field(0, ge=0, description="which channel of the sound is listened to: a front microphone")
    floor_db: float = Field(
        Thresholds().floor_db, le=0, description="dB of full scale, 200 Hz to 8 kHz: below it is silence"
    )


CLASSIFY_SOUNDS = DesireClass(
    name="ClassifySounds",
    title="Classify sounds",
    description="Say whether what is heard is voice-like, tonal as an alarm, impulsive as a clap, or broadband noise.",
)


class SoundClassifier(Module):
    """Says what kind of sound is heard."""

    title = "Sound classifier"
    desire_classes = (CLASSIFY_SOUNDS,)
    runs_elsewhere = True
    Settings = SoundClassifierSettings
    settings: SoundClassifierSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._overruns = Overruns(self.log, self.clock)
        self._limits = Thresholds(floor_db=self.settings.floor_db)
        self._awaited = -1
        self._rate = 0
        self._heard: list[NDArray[np.int16]] = []
        self._count = 0
        self.audio = self.input("audio", Audio, capacity=_CAPACITY, lossless=True)
        self.classes = self.output("classes", SoundClass)
        self.on(self.audio, self._listen)

    def overflowed(self, port: str, loss: InboxOverflow) -> None:
        """Log the loss and begin again."""
        self._overruns.lost(self.audio, loss)
        self._awaited = -1

    async def _listen(self, audio: Audio) -> None:
        self._overruns.heard()
        count, channels = audio.samples.shape
        if self.settings.microphone >= channels:
            raise ModuleFailed(
                f"{self.name} listens to microphone {self.settings.microphone}, but {audio.frame} has {channels}: "
                f"set `microphone` to 0 … {channels - 1}"
            )
        if audio.rate < LEAST_RATE_HZ:
            raise ModuleFailed(
                f"{audio.frame} gives {audio.rate} samples a second, and {self.name} needs {LEAST_RATE_HZ} at least: "
                "choose a higher rate of the microphones, or leave the module out"
            )
        if audio.first_sample != self._awaited or audio.rate != self._rate:
            self._rate, self._count = audio.rate, 0
            self._heard.clear()
        self._awaited = audio.first_sample + count
        self._heard.append(audio.samples[:, self.settings.microphone])
        self._count += count
        stretch = round(STRETCH_S * audio.rate)
        if self._count < stretch:
            return
        samples = np.concatenate(self._heard)[-stretch:]
        self._heard = [samples[round(EVERY_S * audio.rate) :]]
        self._count = len(self._heard[0])
        found = await self.compute(features, samples, audio.rate)
        self.classes.publish(
            SoundClass(
                stamp=audio.stamp + count / audio.rate,
                frame=audio.frame,
                name=classify(found, self._limits),
                level_db=found.level_db,
                centroid_hz=found.centroid_hz,
                rolloff_hz=found.rolloff_hz,
                flatness=found.flatness,
                onset_db=found.onset_db,
            )
        )
