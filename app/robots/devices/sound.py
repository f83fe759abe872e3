"""Sound inputs and outputs: microphones and loudspeakers of this computer, or a file. Blocking."""

from __future__ import annotations

import contextlib
from pathlib import Path
from types import ModuleType
from typing import TypeAlias

import numpy as np
import soundfile
from numpy.typing import NDArray

from app.base.plain_file import check_plain
from app.robots.devices.config import SoundInputConfig, SpeakerConfig
from app.robots.devices.image_inputs import InputUnavailable

Samples = NDArray[np.int16]
#: Supported files, in words.
SOUNDS = "WAV, FLAC, Ogg, MP3"
#: Greatest number of channels of a sound card.
_MOST_RATE, _MOST_CHANNELS = 384_000, 64
_OR_A_FILE = "--microphones FILE takes a sound file instead"


def open_sound(config: SoundInputConfig) -> SoundInput:
    """The opened input of ``config.source``, of ``channels`` channels at ``rate`` (Hz). Raises InputUnavailable.

    Its ``read(count)`` gives the next samples (count, C) int16, None at the end, and raises InputUnavailable; ``gap``:
    samples were lost just before. A ``live`` one (microphones) has its own rate, and ``skip`` discards what it has
    buffered; else the reader waits for the length of a frame.
    """
    if isinstance(config.source, str) and Path(config.source).is_file():
        return _SoundFile(Path(config.source), config)
    if isinstance(config.source, str) and Path(config.source).suffix:
        raise InputUnavailable(f"there is no file {config.source}")
    return _Microphones(config)


class _SoundFile:
    live = False
    gap = False

    def __init__(self, path: Path, config: SoundInputConfig) -> None:
        self._path = path
        try:
            check_plain(path)
            self._file = soundfile.SoundFile(str(path))
        except (soundfile.LibsndfileError, OSError) as failure:
            reason = getattr(failure, "error_string", None) or getattr(failure, "strerror", None) or str(failure)
            raise InputUnavailable(f"{path} cannot be read as sound ({SOUNDS}): {reason.rstrip('.')}") from None
        except TypeError:  # soundfile raises this for .raw, whose format is unknown
            raise InputUnavailable(f"{path} cannot be read as sound: samples without a header; make it a WAV") from None
        self.rate, self.channels = self._file.samplerate, self._file.channels
        if self.rate > _MOST_RATE or self.channels > _MOST_CHANNELS:
            raise InputUnavailable(
                f"{path} says it has {self.channels} channels of {self.rate} samples a second; at most "
                f"{_MOST_CHANNELS} of {_MOST_RATE} are read"
            )
        if not self._file.frames:
            raise InputUnavailable(f"{path} holds no sound")
        self._loop = config.loop

    def read(self, count: int) -> Samples | None:
        try:
            samples = self._next(count)
            while len(samples) < count:
                if not self._loop:
                    if not len(samples):
                        return None
                    return np.concatenate([samples, np.zeros((count - len(samples), self.channels), np.int16)])
                self._file.seek(0)
                more = self._next(count - len(samples))
                if not len(more):
                    raise InputUnavailable(f"{self._path} holds no sound any more")
                samples = np.concatenate([samples, more])
        except soundfile.LibsndfileError as failure:
            raise InputUnavailable(f"{self._path} is damaged, and cannot be read to its end: {failure}") from None
        return samples

    def _next(self, count: int) -> Samples:
        return np.asarray(self._file.read(count, dtype="int16", always_2d=True), np.int16)

    def skip(self) -> None: ...

    def close(self) -> None:
        self._file.close()


def sounddevice() -> ModuleType:
    """The library for sound cards. Raises InputUnavailable where it, or PortAudio below it, is missing."""
    try:
        import sounddevice as found
    except ImportError:
        raise InputUnavailable("sound cards need the package sounddevice (`pip install 'hbba[devices]'`)") from None
    except OSError:
        raise InputUnavailable("sound cards need the library PortAudio (Debian: `apt install libportaudio2`)") from None
    return found  # type: ignore[no-any-return]


def no_sound_card() -> str:
    """Why no sound card can be used on this computer; "" if one can."""
    try:
        sounddevice()
    except InputUnavailable as missing:
        return str(missing)
    return ""


class _Microphones:
    live = True

    def __init__(self, config: SoundInputConfig) -> None:
        if missing := no_sound_card():
            raise InputUnavailable(f"{missing}; {_OR_A_FILE}")
        library = sounddevice()
        self.rate, self.channels = config.rate, config.channels
        self.gap = False
        device = None if config.source == "default" else config.source
        self._error = library.PortAudioError
        try:
            self._stream = library.RawInputStream(
                samplerate=config.rate, blocksize=config.frame_samples, device=device, channels=config.channels,
                dtype="int16", latency="low",
            )  # fmt: skip
            self._stream.start()
        except (self._error, ValueError) as failure:
            raise InputUnavailable(
                f"the microphone ({config.source}) cannot be opened: {failure}; {_OR_A_FILE}"
            ) from None

    def read(self, count: int) -> Samples | None:
        try:
            data, self.gap = self._stream.read(count)
        except self._error as failure:
            raise InputUnavailable(f"the microphone gives no more sound: {failure}") from None
        return np.frombuffer(bytes(data), np.int16).reshape(-1, self.channels).copy()

    def skip(self) -> None:
        with contextlib.suppress(self._error):  # the next read reports it
            self._stream.read(self._stream.read_available)

    def close(self) -> None:
        self._stream.abort()
        self._stream.close()


SoundInput: TypeAlias = _SoundFile | _Microphones


class LoudspeakerStream:
    """A loudspeaker for one channel at ``rate``; :meth:`write` blocks until the device takes the samples."""

    def __init__(self, config: SpeakerConfig, rate: int) -> None:
        """Raises InputUnavailable."""
        library = sounddevice()
        self.rate = rate
        self._error = library.PortAudioError
        device = None if config.source == "default" else config.source
        try:
            self._stream = library.RawOutputStream(
                samplerate=rate, device=device, channels=1, dtype="int16", latency="low"
            )
            self._stream.start()
        except (self._error, ValueError) as failure:
            raise InputUnavailable(f"the loudspeaker ({config.source}) cannot be opened: {failure}") from None

    def write(self, samples: Samples) -> None:
        """Play ``samples`` (N,) int16. Raises InputUnavailable."""
        try:
            self._stream.write(np.ascontiguousarray(samples).tobytes())
        except self._error as failure:
            raise InputUnavailable(f"the loudspeaker takes no more sound: {failure}") from None

    def close(self) -> None:
        """Release the device."""
        self._stream.abort()
        self._stream.close()
