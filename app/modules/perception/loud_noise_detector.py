"""LoudNoiseDetector: noises much louder than the background, by one front microphone (thesis 4.2).

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ LoudNoiseDetector    in   audio   Audio, frames of 512 at 48 kHz, all of them (lossless) │
    │                      in   played  Audio: what the robot's loudspeaker plays, numbered as │
    │                                   the microphones' samples; may be absent                │
    │                      out  noises  LoudNoise, one for each noise, when it begins          │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

Applies the rule of ``loud_noises`` to each frame: its energy against the robust mean of those before it. No noise is
published within the first second, or within a second after a gap of more than a second (``first_sample``): the
background is unknown then. Nor is one published while the loudspeaker plays, and for ``ECHO_S`` after: it would be the
robot's own.

The cost is so small that frames are processed on the event loop, without a thread. ``ratio``
and ``hold_off_s`` are parameters of the desire DetectNoises.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from pydantic import BaseModel, Field

from app.attention.desires import DesireClass
from app.messages import Audio, LoudNoise
from app.modules.perception.loud_noises import FRAME, BandEnergy, LoudnessRule, OnsetDetector, onset_of
from app.modules.perception.overruns import Overruns
from app.runtime.errors import InboxOverflow, ModuleFailed
from app.runtime.module import Module, ModuleContext, Settings

#: Inbox capacity: a second of frames, for stalls of the event loop.
_CAPACITY = 94
#: Time (s) after the loudspeaker's last sample for which a noise may be its echo.
ECHO_S = 0.5


class LoudNoiseDetectorSettings(Settings):
    microphone: int = Field(0, ge=0, description="which channel of the sound is listened to: a front microphone")
    ratio: float = Field(20.0, gt=1, description="so many times the background's energy is loud; unless a desire says")
    hold_off_s: float = Field(0.25, ge=0, description="quiet between two noises; unless a desire says")
    window_s: float = Field(200 * FRAME / 48_000, gt=0, description="over which the background is averaged")
    history_s: float = Field(
        100 * FRAME / 48_000, gt=0, description="time without detections at the start, or after a gap"
    )
    floor_db: float = Field(
        -32.0,
        le=0,
        description="dB of full scale: nothing below it is loud; here, a talker of ordinary loudness at 1 m",
    )


class DetectNoisesParameters(BaseModel, extra="forbid", title="Detect loud noises"):
    ratio: float = Field(
        20.0,
        ge=2,
        le=1000,
        title="How loud",
        description="A noise is loud if its energy is this many times that of the background.",
    )
    hold_off_s: float = Field(
        0.25,
        ge=0,
        le=10,
        title="Hold-off",
        description="Quiet between two noises that count as two, in seconds.",
    )


DETECT_NOISES = DesireClass(
    name="DetectNoises",
    title="Detect loud noises",
    description="Report when a clap, a call or the like is heard, much louder than what was heard before.",
    parameters=DetectNoisesParameters,
)


class LoudNoiseDetector(Module):
    title = "Loud noise detector"
    desire_classes = (DETECT_NOISES,)
    auxiliary_inputs = frozenset({"played"})
    Settings = LoudNoiseDetectorSettings
    settings: LoudNoiseDetectorSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._ratio = self.settings.ratio
        self._hold_off_s = self.settings.hold_off_s
        self._rate = 0
        self._awaited = -1
        self._overruns = Overruns(self.log, self.clock)
        self._rest = np.zeros(0, np.int16)
        self._band = BandEnergy(48_000)
        self._detector = OnsetDetector()
        #: Number of the first sample that the loudspeaker cannot have caused.
        self._own_until = -1
        # Read with each frame of the microphones, not on arrival: what was played meanwhile has come before it.
        self.played = self.input("played", Audio, capacity=_CAPACITY, always_open=True, wants="if_wanted")
        self.audio = self.input("audio", Audio, capacity=_CAPACITY, lossless=True)
        self.noises = self.output("noises", LoudNoise)
        self.on(self.audio, self._listen)

    def configure(self, parameters: Mapping[str, Any]) -> None:
        self._ratio = float(parameters.get("ratio", self.settings.ratio))
        self._hold_off_s = float(parameters.get("hold_off_s", self.settings.hold_off_s))
        if self._rate:
            self._detector.follow(self._rule())

    def overflowed(self, port: str, loss: InboxOverflow) -> None:
        """Log the loss and restart: the background is unknown."""
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
        lost = audio.first_sample - self._awaited
        if lost or audio.rate != self._rate:
            self._resume(audio, lost)
        self._awaited = audio.first_sample + count
        samples = audio.samples[:, self.settings.microphone]
        own = audio.first_sample < self._played_until()
        begin = audio.stamp - len(self._rest) / audio.rate
        if count != FRAME or len(self._rest):
            samples = np.concatenate((self._rest, samples))
            whole = len(samples) - len(samples) % FRAME
            samples, self._rest = samples[:whole], samples[whole:]
        for first in range(0, len(samples), FRAME):
            frame = samples[first : first + FRAME]
            noise = onset_of(frame, self._band.frame(frame), self._detector)
            if noise is not None and not own:
                self.noises.publish(LoudNoise(begin + first / audio.rate, noise.ratio, noise.level_db))

    def _played_until(self) -> int:
        while self.played.connected and self.played.subscription.waiting:
            played = self.played.subscription.receive_nowait()
            self._own_until = played.first_sample + len(played.samples) + round(ECHO_S * played.rate)
        return self._own_until

    def _resume(self, audio: Audio, lost: int) -> None:
        """Continue after a gap of ``lost`` samples; restart after a long gap or a change of the sound's format."""
        self._rest = np.zeros(0, np.int16)
        self._band = BandEnergy(audio.rate)
        if self._awaited < 0 or audio.rate != self._rate or not 0 <= lost <= audio.rate:
            self._rate = audio.rate
            self._detector = OnsetDetector(self._rule())

    def _rule(self) -> LoudnessRule:
        settings = self.settings
        return LoudnessRule.lasting(
            self._rate,
            self._ratio,
            floor_db=settings.floor_db,
            window_s=settings.window_s,
            history_s=settings.history_s,
            hold_off_s=self._hold_off_s,
        )
