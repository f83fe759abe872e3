"""From microphone samples to voices: localization, tracking, speech detection, separation (as ManyEars, thesis 4.2).

The functional core of VoiceLocalizer and of ``hbba detect voices``: knows no clock and no channel.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import wrap_angle
from app.messages import SeparatedSound, SoundSource, SoundSources, read_only
from app.modules.perception.height_prior import range_from_height
from app.modules.perception.voices.array_check import ArrayCheck
from app.modules.perception.voices.delay_and_sum import DelayAndSum
from app.modules.perception.voices.localization import Localizer
from app.modules.perception.voices.microphone_array import MicrophoneArray
from app.modules.perception.voices.resampling import Resampler
from app.modules.perception.voices.separation import Separated, Separator
from app.modules.perception.voices.tracking import SoundTrack, Tracker
from app.modules.perception.voices.voice_activity import SPEECH_RATE, VoiceActivityDetector

_FULL_SCALE = 32768.0
_QUIETEST = 1e-12
#: Period (blocks) of the array check, and least clearness of a checked moment, so that silence costs nothing.
_CHECK_EVERY = 2
_CHECK_CLEARNESS = 0.04
#: Standard deviation of elevations (rad) by the array's dimensions; a line gives none.
_ELEVATION_SIGMA = {1: 1.0, 2: math.radians(8), 3: math.radians(2.5)}


@dataclass(frozen=True, slots=True)
class PipelineSettings:
    """``separation`` of up to ``voices`` sources; ``speech``: whether to compute speech probabilities. ``keep_s``: how
    long a silent source keeps its output of the separation when another sounds."""

    separation: bool = True
    voices: int = 2
    speech: bool = True
    keep_s: float = 0.5


class VoicePipeline:
    """Processes sound block by block.

    ``array``: microphones in ``base_link``, whose origin is on the floor; all columns of the sound, or its ``channels``
    if it is a subset. ``rate``: from 16,000 up. ``step``: samples per block. Tracks are numbered from ``first_track``
    and kept in ``odom``'s axes, so that a rotation of the robot does not blur them. ``array_check`` compares the sound
    with the geometry of ``array``.
    """

    def __init__(
        self,
        array: MicrophoneArray,
        rate: int,
        settings: PipelineSettings = PipelineSettings(),
        *,
        first_track: int = 1,
    ) -> None:
        self.array = array
        self.rate = rate
        self.settings = settings
        self._localizer = Localizer(array, rate)
        self.step = self._localizer.step
        self.array_check = ArrayCheck(array, self._localizer.band, self._localizer.settings.frame / rate)
        self._blocks = 0
        self._tracker = Tracker()
        self._offset = first_track - 1
        self._beams = DelayAndSum(array, rate)
        self._speech_detector = VoiceActivityDetector() if settings.speech else None
        self._separator = Separator(array, rate) if settings.separation else None
        self._elevation_sigma = _ELEVATION_SIGMA[array.dimensions]
        self._ranges: dict[int, tuple[float, float]] = {}
        self._newest = self._offset
        self._time = -math.inf
        self.reset()

    def reset(self) -> None:
        """The next samples do not follow the last; sources that are still heard keep their numbers."""
        self._localizer.reset()
        self._beams.reset()
        if self._separator is not None:
            self._separator.reset()
        if self._speech_detector is not None:
            self._speech_detector.reset()
        self._resamplers: dict[int, Resampler] = {}
        self._powers: dict[int, float] = {}
        self._waiting = np.zeros((0, len(self.array)), np.float32)
        self._separated: tuple[int, ...] = ()
        self._heard = 0
        self._heading: float | None = None
        self._began: int | None = None

    @property
    def next_track(self) -> int:
        """A number not yet used by this pipeline."""
        return self._newest + 1

    def instant(self, time_s: float) -> float:
        """Time of the directions of the block that begins at ``time_s``: the middle of its last frame."""
        return time_s + (self.step - self._localizer.hop) / self.rate

    def process(
        self,
        samples: NDArray[np.int16],
        time_s: float,
        first_sample: int = 0,
        heading: float = 0.0,
        *,
        own_noise: bool = False,
    ) -> tuple[SoundSources, SeparatedSound | None]:
        """Process one block: ``samples`` (step, C), of which the first is number ``first_sample``, taken at ``time_s``.

        ``heading`` (rad) is the robot's in ``odom`` at :meth:`instant`. The sources are those of then, in
        ``base_link``; what is separated comes every few blocks, and is older. ``own_noise``: the robot speaks or
        drives; sound of its loudspeaker and its wheels, which are too near, is no evidence for the check of the
        array. Raises ValueError for samples of another shape.
        """
        if samples.ndim != 2 or len(samples) != self.step or samples.shape[1] <= max(self.array.channels):
            raise ValueError(f"samples are ({self.step}, > {max(self.array.channels)}), not {samples.shape}")
        sound = samples[:, list(self.array.channels)].astype(np.float32) / np.float32(_FULL_SCALE)
        if self._began is None:
            self._began = first_sample
        instant = self.instant(time_s)
        if instant <= self._time:
            self._restart()
        tracks = self._follow(sound, instant, heading)
        if not own_noise:
            self._check_array()
        self._time = instant
        self._heard += self.step
        self._listen(sound, tracks)
        separated = self._separate(sound, tracks, time_s)
        if self._speech_detector is not None:
            self._speech_detector.keep([track.id for track in tracks])
        p_BA = tuple(self.array.middle.tolist())
        return SoundSources(instant, p_BA, tuple(self._source(track) for track in tracks)), separated

    def _restart(self) -> None:
        """Reset after a jump back in time; track numbers are not reused."""
        first = self.next_track
        self._tracker, self._offset = Tracker(), first - 1
        began = self._began
        self.reset()
        self._began = began

    def _follow(self, sound: NDArray[np.float32], instant: float, heading: float) -> tuple[SoundTrack, ...]:
        """Tracks in ``base_link``'s axes of that instant."""
        turned = 0.0 if self._heading is None else wrap_angle(heading - self._heading)
        self._heading = heading
        # Peaks are of a mean over the last moments, in which the robot had turned less.
        localizer = self._localizer
        mean_age = localizer.settings.follow_memory_s * localizer.rate / localizer.step
        R_OM = _turn(heading - turned * mean_age)
        peaks = localizer.process(sound, self._tracker.expected @ R_OM, turned)
        tracks = self._tracker.update(instant, replace(peaks, directions=peaks.directions @ R_OM.T))
        R_OB = _turn(heading)
        here = tuple(
            replace(track, id=track.id + self._offset, direction=track.direction @ R_OB, velocity=track.velocity @ R_OB)
            for track in tracks
        )
        self._newest = max(self._newest, *(track.id for track in here), 0)
        return here

    def _check_array(self) -> None:
        self._blocks += 1
        if (
            self._blocks % _CHECK_EVERY == 0
            and not self.array_check.done
            and self._localizer.clearness() > _CHECK_CLEARNESS
        ):
            self.array_check.update(self._localizer.cross_spectra())

    def _listen(self, sound: NDArray[np.float32], tracks: tuple[SoundTrack, ...]) -> None:
        """Level of each source, and speech detection of active sources that are not separated."""
        self._beams.update(sound)
        powers = {}
        voices = {}
        for track in tracks:
            beam = self._beams.beam(track.direction)
            power = float(np.mean(beam * beam))
            powers[track.id] = 0.5 * (power + self._powers.get(track.id, power))
            if self._speech_detector is not None and track.active and track.id not in self._separated:
                voices[track.id] = self._resampled(track.id, beam, self.rate)
        self._powers = powers
        alive = {track.id for track in tracks}
        self._resamplers = {track: known for track, known in self._resamplers.items() if track in alive}
        if self._speech_detector is not None:
            self._speech_detector.update(voices)

    def _separate(
        self, sound: NDArray[np.float32], tracks: tuple[SoundTrack, ...], time_s: float
    ) -> SeparatedSound | None:
        if self._separator is None:
            return None
        self._waiting = np.concatenate([self._waiting, sound])
        if len(self._waiting) < self._separator.step:
            return None
        block, self._waiting = self._waiting[: self._separator.step], self._waiting[self._separator.step :]
        before = self._separated
        chosen = self._chosen(tracks)
        self._separated = tuple(track.id for track in chosen)
        others = [track for track in tracks if track.id not in self._separated]
        known = [(track.id, track.direction) for track in (*chosen, *others)]
        out = self._separator.process(block, known, len(chosen))
        if self._speech_detector is not None:
            # The detector already has this sound of a source that was not separated until now.
            active = {track.id for track in chosen if track.active and track.id in before}
            self._speech_detector.update(
                {
                    track: self._resampled(track, out.samples[:, column], self._separator.output_rate)
                    for column, track in enumerate(out.tracks)
                    if track in active
                }
            )
        return self._message(out, time_s)

    def _chosen(self, tracks: tuple[SoundTrack, ...]) -> list[SoundTrack]:
        """Sources to separate: those separated so far while they sound or paused for a moment; then voices, then by
        power."""
        keep_s = self.settings.keep_s

        def worth(track: SoundTrack) -> tuple[bool, bool, float]:
            stays = track.id in self._separated and self._time - track.last_seen < keep_s
            speech = self._speech_detector is not None and self._speech_detector.speech(track.id) > 0.5
            return (stays or (track.active and speech), track.active, track.power)

        return sorted(tracks, key=worth, reverse=True)[: self.settings.voices]

    def _message(self, out: Separated, time_s: float) -> SeparatedSound | None:
        assert self._separator is not None
        assert self._began is not None
        if not len(out.samples):
            return None
        rate, ratio = self._separator.output_rate, self._separator.ratio
        before = self._heard - self.step - out.first_sample * ratio
        samples = np.clip(np.rint(out.samples * _FULL_SCALE), -32768, 32767).astype(np.int16)
        first = self._began // ratio + out.first_sample
        return SeparatedSound(time_s - before / self.rate, out.tracks, read_only(samples), rate, first)

    def _resampled(self, track: int, sound: NDArray[np.float32], rate: int) -> NDArray[np.float32]:
        """The source's sound at the speech detector's rate."""
        if rate == SPEECH_RATE:
            return np.ascontiguousarray(sound)
        known = self._resamplers.get(track)
        if known is None or known.rate_in != rate:
            known = self._resamplers[track] = Resampler(rate, SPEECH_RATE)
        return known.process(np.ascontiguousarray(sound))

    def _source(self, track: SoundTrack) -> SoundSource:
        x, y, z = track.direction.tolist()
        range_m, range_sigma_m = self._range(z)
        return SoundSource(
            track=track.id,
            direction=(x, y, z),
            power=min(1.0, max(0.0, float(track.power))),
            level_db=10 * math.log10(max(self._powers.get(track.id, 0.0), _QUIETEST)),
            active=track.active,
            speech=math.nan if self._speech_detector is None else self._speech_detector.speech(track.id),
            range_m=range_m,
            range_sigma_m=range_sigma_m,
        )

    def _range(self, rise: float) -> tuple[float, float]:
        """Distance of a mouth, and its deviation, for a sine of the elevation; cached in steps of 0.005."""
        step = round(rise * 200)
        if (known := self._ranges.get(step)) is None:
            sine = step / 200
            direction = (math.sqrt(1 - sine * sine), 0.0, sine)
            height_m = float(self.array.middle[2])
            known = range_from_height(direction, height_m, "mouth", elevation_sigma=self._elevation_sigma)
            self._ranges[step] = known
        return known


def _turn(heading: float) -> NDArray[np.float64]:
    c, s = math.cos(heading), math.sin(heading)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
