"""Sound as WAV."""

from __future__ import annotations

import wave
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from app.recording.export.target import Target, Unsurveyed, Write
from app.recording.log import LogError, LoggedChannel

#: A piece that begins so much later than the one before ended has others missing in between; less is jitter.
GAP_S = 0.02


class AudioMessage(Protocol):
    """What a message must have to be sound: ``samples`` (N, C) int16 from ``stamp`` on, ``rate`` of them a second."""

    @property
    def stamp(self) -> float:
        """Capture of the first sample, s."""
        ...

    @property
    def samples(self) -> NDArray[np.int16]:
        """(N, C)."""
        ...

    @property
    def rate(self) -> int:
        """Hz."""
        ...


def is_audio(message_type: type[Any]) -> bool:
    """Whether messages of this class are sound, told by their fields."""
    return is_dataclass(message_type) and {"stamp", "samples", "rate"} <= {f.name for f in fields(message_type)}


class Wav(Unsurveyed):
    """``<channel>.wav``: silence where pieces are missing, so that it lasts as long as it took."""

    def accepts(self, message_type: type[Any]) -> bool:
        """Every class that is an :class:`AudioMessage`."""
        return is_audio(message_type)

    @contextmanager
    def writer(self, channel: LoggedChannel, target: Target) -> Iterator[Write]:
        """One file; rate and number of channels are those of the first message."""
        name = f"{channel.name}.wav"
        target.check(name)
        sound: wave.Wave_write | None = None
        first, rate, shape, frames, silence = 0.0, 0, 0, 0, 0

        def write(message: AudioMessage) -> None:
            nonlocal sound, first, rate, shape, frames, silence
            samples = message.samples
            if sound is None:
                sound = wave.open(stream, "wb")  # noqa: SIM115  # without a message it has no header to close with
                first, rate, shape = message.stamp, message.rate, samples.shape[1]
                sound.setnchannels(shape)
                sound.setsampwidth(2)
                sound.setframerate(rate)
            if (message.rate, samples.shape[1]) != (rate, shape):
                raise LogError(
                    f"{channel.name} changes from {shape} channels at {rate} Hz to {samples.shape[1]} at "
                    f"{message.rate} Hz at {message.stamp - first:.3f} s; cut the log there"
                )
            missing = round((message.stamp - first) * rate) - frames
            if missing > GAP_S * rate:
                sound.writeframesraw(bytes(2 * shape * missing))
                frames, silence = frames + missing, silence + missing
            sound.writeframesraw(np.ascontiguousarray(samples, "<i2").tobytes())
            frames += len(samples)

        with target.file(name) as part, part.open("wb") as stream:
            try:
                yield write
            finally:
                if sound is not None:
                    sound.close()
            if sound is None:
                part.unlink()
                return
        quiet = f", {silence / rate:.1f} s of it silence for what is missing" if silence else ""
        target.written.append(f"{target.folder / name}: {frames / rate:.1f} s, {shape} channels at {rate} Hz{quiet}")
