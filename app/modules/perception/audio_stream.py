"""AudioStream: the front microphone's sound, for people.

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ AudioStream    in   audio  Audio, all microphones, 48 kHz; not decimated                 │
    │                out  sound  Audio, one channel, the same rate, frames of about 20 ms      │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

Publishes one microphone, amplified. A sum of several would lose frequencies: sound from the side arrives 0.6 ms apart
at two microphones 22 cm apart, and their sum cancels 800 Hz and its odd multiples. The separated voices have less
noise. The front microphone is the highest of those furthest ahead: farthest from the wheels.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from app.attention.desires import DesireClass
from app.messages import Audio, read_only
from app.modules.perception.overruns import Overruns
from app.runtime.errors import InboxOverflow
from app.runtime.module import Module, ModuleContext, Settings

#: Positions (m) that differ by less are at the same distance.
_LEVEL_M = 0.005


def front_microphone(p_BM: NDArray[np.float64]) -> int:
    """Index of the microphone at ``p_BM`` (C, 3), m in B, furthest ahead; among several the highest, then the first.

    0 for microphones without positions (0, 3).
    """
    if len(p_BM) == 0:
        return 0
    ahead = np.flatnonzero(p_BM[:, 0] >= p_BM[:, 0].max() - _LEVEL_M)
    return int(ahead[np.argmax(np.round(p_BM[ahead, 2] / _LEVEL_M))])


def amplified(samples: NDArray[np.int16], gain: float) -> NDArray[np.int16]:
    """``samples`` times ``gain``, clipped at full scale."""
    loud = np.rint(samples * np.float32(gain))
    return np.asarray(np.clip(loud, -32768, 32767), np.int16)


class AudioStreamSettings(Settings):
    microphone: int | None = Field(None, ge=0, description="which microphone, from 0; none: the front one")
    gain_db: float = Field(12.0, ge=-40, le=40, description="made louder by so much")
    frame_s: float = Field(0.02, ge=0.005, le=0.2, description="a frame for people is at least so long")


LISTEN = DesireClass(
    name="Listen",
    title="Hear through the robot's ears",
    description="Send people what the robot's front microphone hears.",
)


class AudioStream(Module):
    title = "Sound for people"
    desire_classes = (LISTEN,)
    Settings = AudioStreamSettings
    settings: AudioStreamSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._waiting: list[Audio] = []
        self._overruns = Overruns(self.log, self.clock)
        self._places: NDArray[np.float64] | None = None
        self._front = 0
        self._gain = 10.0 ** (self.settings.gain_db / 20.0)
        self.audio = self.input("audio", Audio, capacity=94, lossless=True)
        self.sound = self.output("sound", Audio)
        self.on(self.audio, self._take)

    def overflowed(self, port: str, loss: InboxOverflow) -> None:
        """Missed frames are dropped: people hear a gap, and then current sound."""
        self._overruns.lost(self.audio, loss)
        self._waiting.clear()

    async def _take(self, audio: Audio) -> None:
        self._overruns.heard()
        if self._waiting and not _follows(self._waiting[-1], audio):
            # No subscription for a while, or lost samples: a frame has no gaps.
            self._waiting.clear()
        self._waiting.append(audio)
        if sum(len(frame.samples) for frame in self._waiting) >= self.settings.frame_s * audio.rate * (1 - 1e-9):
            self._publish()

    def _publish(self) -> None:
        first, frames = self._waiting[0], self._waiting
        self._waiting = []
        number = self._microphone(first)
        samples = amplified(np.concatenate([frame.samples[:, number] for frame in frames]), self._gain)
        places = read_only(first.p_BM[number : number + 1].copy())
        self.sound.publish(replace(first, samples=read_only(samples[:, None]), p_BM=places))

    def _microphone(self, audio: Audio) -> int:
        if self._places is None or self._places is not audio.p_BM:
            self._places, self._front = audio.p_BM, front_microphone(audio.p_BM)
        number = self._front if self.settings.microphone is None else self.settings.microphone
        return min(number, int(audio.samples.shape[1]) - 1)


def _follows(before: Audio, audio: Audio) -> bool:
    return (
        audio.first_sample == before.first_sample + len(before.samples)
        and audio.rate == before.rate
        and audio.samples.shape[1] == before.samples.shape[1]
    )
