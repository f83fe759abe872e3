"""The library of sounds: recorded speech, sounds made by rule, files, and spoken text, each at its natural level.

Levels are sound pressure levels at 1 m, tied to the microphones by ``MicrophonesConfig.sensitivity_db``: that many dB
of full scale are the 65 dB of a talker of ordinary loudness.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from app.base.errors import ConfigError
from app.base.plain_file import check_plain
from app.base.yaml_source import suggestion
from app.robots.simulated.acoustics.activity import ACTIVITY_S, activity, pieces
from app.robots.simulated.acoustics.bands import fast_length
from app.robots.simulated.acoustics.synthesis import MAKERS
from app.speech.espeak import Espeak
from app.speech.utterance import SpeechError

Samples = NDArray[np.float32]
TALKER_DB_SPL = 65.0
SPEECH = Path(__file__).parent / "speech"
FILES = (".wav", ".flac", ".ogg")

#: Names of recorded speech, with their files.
RECORDINGS = MappingProxyType(
    {
        "hello": "kennedy_1",
        "question": "kennedy_2",
        "answer": "kennedy_3",
        "remark": "austen_1",
        "reply": "austen_2",
        "story": "austen_3",
    }
)
#: Sounds made by rule: dB SPL at 1 m, of the loudest sample (a blow) or of the mean (what lasts).
PEAK_DB_SPL = MappingProxyType({"clap": 94.0, "knock": 88.0, "door": 92.0, "step": 72.0})
MEAN_DB_SPL = MappingProxyType({"alarm": 80.0, "music": 65.0, "fan": 42.0})
#: Names of all sounds of the library.
NAMES = (*sorted(RECORDINGS), *sorted(MAKERS))
VARIANTS = 8
Key = tuple[str, int]


@dataclass(frozen=True, slots=True, eq=False)
class Clip:
    """A sound: ``samples`` (N,) float32, amplitude at 1 m with full scale 1; ``level`` the RMS of its active parts.

    ``activity`` (N / 10 ms,) bool: whether it is louder than its own pauses.
    """

    samples: Samples
    activity: NDArray[np.bool_]
    level: float
    rate: int

    @property
    def seconds(self) -> float:
        """Duration (s)."""
        return self.samples.size / self.rate

    def active(self, after_s: float, loop: bool = False) -> bool:
        """Whether it is active ``after_s`` (s) after its begin."""
        if after_s < 0 or not self.activity.size:
            return False
        at = int(after_s / ACTIVITY_S)
        return (
            bool(self.activity[at % self.activity.size if loop else at]) if loop or at < self.activity.size else False
        )


class ClipLibrary:
    """Clips by name at one ``rate``; ``sensitivity_db`` as in MicrophonesConfig."""

    def __init__(self, rate: int, sensitivity_db: float) -> None:
        self._rate = rate
        self._sensitivity_db = sensitivity_db
        self._clips: dict[Key, Clip] = {}

    @property
    def names(self) -> tuple[str, ...]:
        return NAMES

    def key(self, clip: str, by: str = "") -> Key:
        """Key of the sound that :meth:`get` returns for these arguments."""
        varied = clip in PEAK_DB_SPL or (clip not in RECORDINGS and clip not in MAKERS and not _is_file(clip))
        return clip, zlib.crc32(by.encode()) % VARIANTS if varied and by else 0

    def get(self, clip: str, by: str = "") -> Clip:
        """The sound called ``clip``: one of ``names``, an absolute path of a sound file, or text to be spoken.

        A name with a space that is no file is text. ``by`` selects a variant, so that claps and voices of people
        differ. Raises ConfigError for an unknown name, a file without sound, and text without an installed speech
        synthesis.
        """
        return self.at(self.key(clip, by))

    def at(self, key: Key) -> Clip:
        """The sound of a :meth:`key`; raises as :meth:`get` does."""
        if key not in self._clips:
            self._clips[key] = self._make(*key)
        return self._clips[key]

    def _make(self, clip: str, variant: int) -> Clip:
        if clip in RECORDINGS:
            return self._talk(*_read(SPEECH / f"{RECORDINGS[clip]}.flac"))
        if clip in MAKERS:
            samples = MAKERS[clip](self._rate, np.random.default_rng([zlib.crc32(clip.encode()), variant]))
            if clip in PEAK_DB_SPL:
                return self._clip(samples * (self._amplitude(PEAK_DB_SPL[clip]) / np.abs(samples).max()))
            return self._clip(samples * (self._amplitude(MEAN_DB_SPL[clip]) / samples.std()))
        if _is_file(clip):
            return self._talk(*_read(Path(clip)))
        if " " in clip.strip():
            try:
                spoken = Espeak(pitch=25 + 8 * variant).synthesize(clip, "en")
            except SpeechError as failure:
                raise ConfigError(f"the text {clip!r} cannot be said: {failure}") from None
            return self._talk(spoken.samples.astype(np.float32) / 32768.0, spoken.rate)
        raise ConfigError(f"there is no sound {clip!r}; {suggestion(clip, self.names)}")

    def _amplitude(self, db_spl: float) -> float:
        """Root mean square, full scale 1, of a sound of ``db_spl``."""
        return float(10 ** ((db_spl - TALKER_DB_SPL + self._sensitivity_db) / 20))

    def _talk(self, samples: Samples, rate: int) -> Clip:
        """Speech or a file, scaled to the level of an ordinary talker."""
        whole = _resampled(samples, rate, self._rate)
        level = self._clip(whole).level
        return self._clip(whole * np.float32(self._amplitude(TALKER_DB_SPL) / level) if level > 0 else whole)

    def _clip(self, samples: Samples) -> Clip:
        active = activity(samples, self._rate)
        sounding = pieces(samples, self._rate)[active]
        level = float(sounding.std()) if sounding.size else 0.0
        return Clip(samples.astype(np.float32, copy=False), active, level, self._rate)


#: Greatest number of samples of a file, all channels together (four bytes of memory each), and plausible rates (Hz).
_MOST_SAMPLES = 60_000_000
_RATES = (1_000, 384_000)


def _is_file(clip: str) -> bool:
    return clip.lower().endswith(FILES)


def _read(path: Path) -> tuple[Samples, int]:
    import soundfile

    try:
        check_plain(path)
        with soundfile.SoundFile(path) as file:
            rate, size = file.samplerate, file.frames * file.channels
            if size > _MOST_SAMPLES or not _RATES[0] <= rate <= _RATES[1]:
                raise ConfigError(
                    f"{path} says it has {size} samples, {rate} a second; at most {_MOST_SAMPLES} are read, from "
                    f"{_RATES[0]} to {_RATES[1]} a second"
                )
            samples = file.read(dtype="float32", always_2d=True)
    except (soundfile.SoundFileError, OSError) as failure:
        raise ConfigError(f"{path} cannot be read as sound: {failure}") from None
    if not samples.size:
        raise ConfigError(f"{path} holds no sound")
    return samples.mean(axis=1), int(rate)


def _resampled(samples: Samples, rate: int, wanted: int) -> Samples:
    """``samples`` at another rate, by its spectrum; padded with silence against wrap-around."""
    if rate == wanted:
        return samples.astype(np.float32, copy=False)
    around = rate // 100
    padded = np.pad(samples, around)
    padded = np.pad(padded, (0, fast_length(padded.size) - padded.size))
    size = round(padded.size * wanted / rate)
    spectrum = np.fft.rfft(padded)[: size // 2 + 1]
    begin = round(around * wanted / rate)
    resampled = np.fft.irfft(spectrum, size) * (size / padded.size)
    return resampled[begin : begin + round(samples.size * wanted / rate)].astype(np.float32)
