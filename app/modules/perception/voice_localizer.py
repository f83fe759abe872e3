"""VoiceLocalizer: localization, tracking and separation of voices and other sounds (thesis 4.2: ManyEars).

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ VoiceLocalizer    in   audio      Audio, 2 and more channels, frames of any length; all  │
    │                                   or nothing: sound may not be decimated                 │
    │                   in   odometry   Odometry, 100 Hz, X_OB in odom; never filtered; may be │
    │                                   absent on a body that never turns                      │
    │                   in   played     Audio, one channel: what the robot's loudspeaker plays,│
    │                                   numbered as the microphones' samples; may be absent    │
    │                   out  sources    SoundSources, 23 Hz, directions in base_link           │
    │                   out  separated  SeparatedSound, 8 blocks/s, 16 kHz, up to 2 voices     │
    │                   out  confidence Confidence, by the noise there is all the time         │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

Computes steered response power over the sphere (voices/localization.py), tracks in ``odom``'s axes by the heading at
the sound's own time (voices/tracking.py), each source's probability of being speech (Silero VAD,
voices/voice_activity.py), its distance by people's heights (height_prior.py), and the separated sound of up to two
sources (voices/separation.py). What the loudspeaker plays is removed first (voices/own_voice.py), so that the robot's
own voice is nobody's.
``microphones`` (2, 4, 8 ...: the number of used ones) and ``separation`` are parameters
of the strategies for the desire LocateVoices, ``voices`` (how many are separated) of the desire itself. After a gap in
the sound, and after a restart, all state except the track numbers is reset. Microphone positions that do not explain
the sound (voices/array_check.py) are logged once; what is heard while the robot speaks or drives, or while its motion
is not known, is no evidence.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from app.attention.desires import DesireClass
from app.messages import Audio, Confidence, Odometry, SeparatedSound, SoundSources
from app.modules.perception.overruns import Overruns
from app.modules.perception.pose_at import PoseAt
from app.modules.perception.voices.microphone_array import MicrophoneArray
from app.modules.perception.voices.own_voice import Numbered, OwnVoiceFilter
from app.modules.perception.voices.pipeline import PipelineSettings, VoicePipeline
from app.modules.perception.voices.voice_activity import VoiceActivityDetector
from app.modules.perception.working_conditions import ConfidenceReporter, SteadyNoise, quiet_confidence
from app.runtime.errors import InboxOverflow, ModuleFailed
from app.runtime.module import Module, ModuleContext, Settings

#: Kept over restarts and for the next pipeline, so that track numbers are not reused.
_NEXT_TRACK = "next track"
#: Speeds (m/s, rad/s) up to which the base is at rest.
_AT_REST = 0.01
#: Noise of the wheels lasts so long (s) after the base has come to rest: what is heard is a mean over some blocks.
_ROLLS_OUT_S = 1.0


class VoiceLocalizerSettings(Settings):
    microphones: int | None = Field(
        None, ge=2, description="how many are used while no strategy says another; none: all there are"
    )
    separation: bool = Field(True, description="used while no strategy says another")
    voices: int = Field(2, ge=1, le=4, description="most sources separated, used while no desire says another")
    speech: bool = Field(True, description="judge whether sources are speech")
    body_m: float = Field(
        0.0, ge=0, le=1, description="radius of the body that the microphones stand on; 0: they hang in free air"
    )


@dataclass(frozen=True, slots=True)
class _Wiring:
    """Parameters of a pipeline."""

    p_BM: NDArray[np.float64]
    rate: int

    def same(self, audio: Audio) -> bool:
        return audio.rate == self.rate and (audio.p_BM is self.p_BM or np.array_equal(audio.p_BM, self.p_BM))


class LocateVoicesParameters(BaseModel, extra="forbid", title="Locate voices"):
    voices: int = Field(
        2,
        ge=1,
        le=4,
        title="Voices apart",
        description="Greatest number of separated sources, where the strategy in force separates.",
    )


LOCATE_VOICES = DesireClass(
    name="LocateVoices",
    title="Locate voices",
    description="Report where voices and other sounds come from (in base_link), and hear each by itself.",
    parameters=LocateVoicesParameters,
)


class VoiceLocalizer(Module):
    title = "Voice localizer"
    desire_classes = (LOCATE_VOICES,)
    auxiliary_inputs = frozenset({"played"})
    runs_elsewhere = True
    Settings = VoiceLocalizerSettings
    settings: VoiceLocalizerSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._microphones = self.settings.microphones
        self._wanted = PipelineSettings()
        self._poses = PoseAt(
            self.clock, self.log, "sounds are followed as if the robot stood still", "the time of the sound"
        )
        self._heading = 0.0
        self._overruns = Overruns(self.log, self.clock)
        self._wiring: _Wiring | None = None
        self._pipeline: VoicePipeline | None = None
        self._doubted = False
        self._waiting: list[NDArray[np.int16]] = []
        self._waiting_length = 0
        #: When the base last moved (s).
        self._moved = -math.inf
        #: Number and time of the first waiting sample, and the number of the next expected one.
        self._first_sample, self._stamp, self._next_sample = 0, 0.0, -1
        self._own_voice: OwnVoiceFilter | None = None
        # Read with each frame of the microphones, not on arrival: what was played meanwhile has come before it.
        self.played = self.input("played", Audio, capacity=188, always_open=True, wants="if_wanted")
        self.audio = self.input("audio", Audio, capacity=94, lossless=True)
        self.odometry = self.input("odometry", Odometry, capacity=100, always_open=True, rests=True)
        self.sources = self.output("sources", SoundSources)
        self.separated = self.output("separated", SeparatedSound)
        self.confidence = self.output("confidence", Confidence)
        self._works = ConfidenceReporter(self.confidence)
        self._noise = SteadyNoise()
        self.on(self.audio, self._take_audio)
        self.on(self.odometry, self._take_odometry)

    async def start(self) -> None:
        """Load the network of the voice activity detection."""
        if self.settings.speech:
            await self.compute(VoiceActivityDetector)

    def configure(self, parameters: Mapping[str, Any]) -> None:
        """Take ``microphones``, ``separation`` and ``voices`` from the intention; another pipeline if they changed."""
        settings = self.settings
        microphones = parameters.get("microphones", settings.microphones)
        wanted = PipelineSettings(
            separation=bool(parameters.get("separation", settings.separation)),
            voices=int(parameters.get("voices", settings.voices)),
            speech=settings.speech,
        )
        if (microphones, wanted) != (self._microphones, self._wanted):
            self._microphones, self._wanted = microphones, wanted
            self._retire()

    def overflowed(self, port: str, loss: InboxOverflow) -> None:
        """Lost sound is a gap, which the samples' numbers show."""
        self._overruns.lost(self.audio, loss)

    def _take_odometry(self, odometry: Odometry) -> None:
        self._poses.add(odometry)
        if max(abs(odometry.linear_mps), abs(odometry.lateral_mps), abs(odometry.angular_radps)) > _AT_REST:
            self._moved = odometry.stamp

    async def _take_audio(self, audio: Audio) -> None:
        self._overruns.heard()
        if self._wiring is None or not self._wiring.same(audio):
            self._retire()
            self._wiring = _Wiring(audio.p_BM, audio.rate)
            self._own_voice = OwnVoiceFilter(audio.samples.shape[1], audio.rate)
            self._doubted = False
        if audio.first_sample != self._next_sample:
            self._reset()
            if self._pipeline is not None and self.persistent.get(_NEXT_TRACK, 1) > self._pipeline.next_track:
                # The same module on another computer gave numbers meanwhile.
                self._retire()
        self._next_sample = audio.first_sample + len(audio.samples)
        first_sample, samples = await self._without_own_voice(audio)
        level_db = self._noise.hear(samples, audio.rate)
        if level_db is not None and self._works.due(audio.stamp):
            self._works.say(audio.stamp, quiet_confidence(level_db), "it is noisy all the time")
        if not self._waiting_length:
            self._first_sample = first_sample
            self._stamp = audio.stamp + (first_sample - audio.first_sample) / audio.rate
        self._waiting.append(samples)
        self._waiting_length += len(samples)
        while self._pipeline is None:
            wanted = self._microphones, self._wanted
            first = self.persistent.get(_NEXT_TRACK, 1)
            made = await self.compute(_made, self._wiring, *wanted, self.settings.body_m, first)
            # The parameters may have changed meanwhile.
            self._pipeline = made if wanted == (self._microphones, self._wanted) else None
        pipeline = self._pipeline
        while self._waiting_length >= pipeline.step and self._pipeline is pipeline:
            await self._process(pipeline, audio.rate)
            if pipeline.array_check.failed and not self._doubted:
                self._doubted = True
                self.log.warning(
                    "the microphones' positions do not explain what they hear: directions are wrong. Check the "
                    "order and the positions (m) of the microphones in the robot's file; `hbba calibrate microphones` "
                    "measures both",
                    extra={"frame": audio.frame, "explained_percent": round(100 * pipeline.array_check.share)},
                )

    async def _without_own_voice(self, audio: Audio) -> Numbered:
        """The next samples without what the loudspeaker played, and the number of the first; some may be kept back."""
        own_voice = self._own_voice
        assert own_voice is not None
        played: list[Numbered] = []
        while self.played.connected and self.played.subscription.waiting:
            frame = self.played.subscription.receive_nowait()
            if frame.rate == audio.rate:
                played.append((frame.first_sample, frame.samples[:, 0]))
        if not played and not own_voice.needed:
            return audio.first_sample, audio.samples
        used = None if self._pipeline is None else self._pipeline.array.channels
        return await self.compute(own_voice.process, audio.first_sample, audio.samples, played, used)

    async def _process(self, pipeline: VoicePipeline, rate: int) -> None:
        sound = np.concatenate(self._waiting)
        block, rest = sound[: pipeline.step], sound[pipeline.step :]
        stamp, first_sample = self._stamp, self._first_sample
        self._waiting, self._waiting_length = ([rest] if len(rest) else []), len(rest)
        self._stamp, self._first_sample = stamp + pipeline.step / rate, first_sample + pipeline.step
        heading = await self._heading_at(pipeline.instant(stamp))
        speaks = self._own_voice is not None and self._own_voice.needed
        drives = self._poses.late or pipeline.instant(stamp) - self._moved < _ROLLS_OUT_S
        process = partial(pipeline.process, own_noise=speaks or drives)
        sources, separated = await self.compute(process, block, stamp, first_sample, heading)
        self.persistent[_NEXT_TRACK] = pipeline.next_track
        self.sources.publish(sources)
        if separated is not None:
            self.separated.publish(separated)

    async def _heading_at(self, stamp: float) -> float:
        """The robot's heading at that time; the last known one where odometry does not reach it."""
        if not self.odometry.connected:
            return 0.0
        # After one timeout there is no further waiting: sound continues.
        X_OB = await self._poses.logged_at(stamp, 0.0 if self._poses.late else 0.5)
        if X_OB is not None:
            self._heading = X_OB.theta
        return self._heading

    def _reset(self) -> None:
        """Reset: the next samples do not follow the last."""
        self._waiting, self._waiting_length = [], 0
        if self._own_voice is not None:
            self._own_voice.reset()
        if self._pipeline is not None:
            self._pipeline.reset()

    def _retire(self) -> None:
        """Replace the pipeline, with new track numbers."""
        self._pipeline = None
        self._reset()


def _made(
    wiring: _Wiring, microphones: int | None, settings: PipelineSettings, body_m: float, first_track: int
) -> VoicePipeline:
    try:
        array = MicrophoneArray(wiring.p_BM, body_m=body_m)
        count = len(array) if microphones is None else min(microphones, len(array))
        return VoicePipeline(array.subset(count), wiring.rate, settings, first_track=first_track)
    except ValueError as mistake:
        raise ModuleFailed(f"voices cannot be located with these microphones: {mistake}") from None
