"""Simulated microphones: scenes in, frames out, each as soon as the scenes cover it. No clock."""

from __future__ import annotations

import itertools
import math
from collections import deque
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from app.base.geometry import Pose2, Pose3
from app.messages import Audio
from app.robots.simulated.acoustics.auralization import Auralizer, Emission
from app.robots.simulated.acoustics.building import build
from app.robots.simulated.acoustics.diffraction import BaffledMicrophones
from app.robots.simulated.acoustics.dry_sound import SampledSound
from app.robots.simulated.acoustics.ipc import (
    AcousticsSetup,
    ActiveSound,
    LoudspeakerFrame,
    MicrophoneFrame,
    SoundScene,
)
from app.robots.simulated.acoustics.loudspeaker_source import LoudspeakerSource
from app.robots.simulated.acoustics.selfnoise import SelfNoise

LATE_S = 0.15
"""Greatest delay (s) behind the world before frames are dropped."""
PAUSE_S = 0.5
"""Gap (s) between scenes that means a pause of the demand."""
_BELOW_NOISE_DB = 10.0
_LOUDSPEAKER = "\0loudspeaker"


class MicrophoneSimulator:
    """Takes scenes in order; returns the frames that they complete."""

    def __init__(self, setup: AcousticsSetup) -> None:
        config = setup.config
        self._rate, self._size, self._frame = config.rate, config.frame_samples, config.link
        p_BM = _moved(setup.X_BM, config.positions)
        self._p_BM = p_BM
        self._X_BA = Pose3(setup.X_BM.rotation, p_BM.mean(axis=0))
        self._microphones = BaffledMicrophones(
            (p_BM - p_BM.mean(axis=0)) @ setup.X_BM.rotation, config.rate, config.shadow
        )
        building = build(setup.world)
        self._hearing = Auralizer(
            self._microphones,
            building,
            self._size,
            late_s=0.75 * max(max(room.rt60_s) for room in building.rooms),
            floor=_amplitude(config.noise_db - _BELOW_NOISE_DB),
            seed=setup.seed,
        )
        self._hearing.prepare(building.rooms)
        X_AB = self._X_BA.inverse()
        left, right = (_moved(X_AB, p) for p in setup.p_BW)
        fans = np.array([0.0, 0.0, -0.12])
        self._noise = SelfNoise(
            self._microphones,
            _amplitude(config.fans_db),
            wheels=_amplitude(config.wheels_db),
            own=_amplitude(config.noise_db),
            p_AF=fans,
            p_AL=left,
            p_AR=right,
            seed=setup.seed,
        )
        self._clips = {
            key: (SampledSound(samples), SampledSound(samples, loop=True), level)
            for key, (samples, level) in setup.clips.items()
        }
        self._speaker = LoudspeakerSource(config.rate)
        self._speaker_gain = 0.0
        self._p_BS: NDArray[np.float64] = np.zeros(3)
        if setup.loudspeaker is not None:
            self._speaker_gain = _amplitude(setup.loudspeaker.gain_db)
            self._p_BS = _moved(setup.X_BS, setup.loudspeaker.position)
        self._scenes: deque[SoundScene] = deque()
        self._lost = 0
        self.clipped = 0
        """Number of clipped samples so far."""

    @property
    def _speaks(self) -> bool:
        return self._speaker_gain > 0 and self._speaker.waiting_s > 0

    def play(self, played: LoudspeakerFrame) -> None:
        """Queue sound for the loudspeaker."""
        self._speaker.play(played.audio.samples[:, 0], played.audio.rate)

    def listen(self, scenes: list[SoundScene]) -> list[MicrophoneFrame]:
        """The frames that ``scenes``, the next ones, complete. Frames that are too late are dropped."""
        if not scenes:
            return []
        known = [*self._scenes, *scenes]
        if len(known) == len(scenes) or any(b.time_s - a.time_s > PAUSE_S for a, b in itertools.pairwise(known)):
            # Demand starts now, or this process has just started: no loss
            self._scenes = deque(scenes[-1:])
            self._skip_to(scenes[-1].time_s)
            return []
        self._scenes.extend(scenes)
        behind = self._scenes[-1].time_s - self._hearing.position / self._rate
        if behind > LATE_S:
            self._lost += self._skip_to(self._scenes[-1].time_s - self._size / self._rate)
        heard = []
        while (self._hearing.position + self._size) / self._rate <= self._scenes[-1].time_s:
            heard.append(self._next(self._lost))
            self._lost = 0
        return heard

    def _skip_to(self, time_s: float) -> int:
        frames = max(0, math.ceil(time_s * self._rate / self._size) - self._hearing.position // self._size)
        if frames:
            self._hearing.skip(frames)
        return frames

    def _next(self, lost: int) -> MicrophoneFrame:
        position = self._hearing.position
        end_s = (position + self._size) / self._rate
        while len(self._scenes) > 2 and self._scenes[1].time_s < end_s:
            self._scenes.popleft()
        before, after = self._scenes[0], self._scenes[min(1, len(self._scenes) - 1)]
        span = after.time_s - before.time_s
        share = min(max((end_s - before.time_s) / span, 0.0), 1.0) if span > 0 else 1.0
        X_WB = before.X_WB.interpolate(after.X_WB, share)
        X_WA = X_WB.to_pose3() @ self._X_BA
        speaks = self._speaks
        sound = self._hearing.block(self._emissions(before, after, share, X_WB), X_WA)
        rims = [a + share * (b - a) for a, b in zip(before.rims_mps, after.rims_mps, strict=True)]
        sound += self._noise.frame(position, self._size, *rims)
        scaled = np.rint(sound * 32768.0)
        self.clipped += int(np.count_nonzero(np.abs(scaled) > 32767.5))
        samples = np.clip(scaled, -32768, 32767).astype(np.int16)
        stamp = after.stamp - (after.time_s - position / self._rate)
        audio = Audio(
            stamp,
            self._frame,
            samples=np.ascontiguousarray(samples.T),
            rate=self._rate,
            first_sample=position,
            p_BM=self._p_BM,
        )
        return MicrophoneFrame(audio, lost, self._played(audio) if speaks else None)

    def _played(self, audio: Audio) -> Audio:
        """What the loudspeaker plays during ``audio``."""
        played = np.rint(self._speaker.read(audio.first_sample, self._size) * 32768.0)
        samples = np.clip(played, -32768, 32767).astype(np.int16)[:, None]
        return replace(audio, frame="loudspeaker", samples=samples, p_BM=np.zeros((0, 3)))

    def _emissions(self, before: SoundScene, after: SoundScene, share: float, X_WB: Pose2) -> list[Emission]:
        earlier = {sound.name: sound for sound in before.sounds}
        emissions = []
        for sound in after.sounds:
            once, looped, level = self._clips[sound.key]
            then = earlier.get(sound.name, sound)
            p_W = np.array(then.p_W) + share * (np.array(sound.p_W) - np.array(then.p_W))
            emissions.append(
                Emission(
                    sound.name,
                    looped if sound.loop else once,
                    begin=round(sound.begin_s * self._rate),
                    p_W=p_W,
                    gain=_amplitude(sound.gain_db),
                    looks=_looks(sound),
                    level=level,
                )
            )
        if self._speaks:
            place = _moved(X_WB.to_pose3(), self._p_BS)
            emissions.append(Emission(_LOUDSPEAKER, self._speaker, 0, place, self._speaker_gain, level=0.1))
        return emissions


def _moved(X: Pose3, points: ArrayLike) -> NDArray[np.float64]:
    return np.asarray(X.transform(np.asarray(points, dtype=np.float64)), dtype=np.float64)


def _looks(sound: ActiveSound) -> NDArray[np.float64] | None:
    return None if sound.looks is None else np.array([math.cos(sound.looks), math.sin(sound.looks), 0.0])


def _amplitude(db: float) -> float:
    return float(10 ** (db / 20))
