"""Voice activity detection: Silero VAD, a small recurrent network, on each separated source (see SILERO_VAD.md)."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.modules.perception.voices.agc import AutomaticGain

Sound = NDArray[np.float32]
MODEL = Path(__file__).with_name("silero_vad_16k_op15.onnx")
#: Input of the network: sample rate (Hz), samples per judgement, and samples of context before.
SPEECH_RATE = 16_000
CHUNK = 512
CONTEXT = 64
#: Weight, in judgements, of a prior "no voice" at a source's start: a single sound is not enough.
_DOUBT = 2.0
#: Level (dB) below the source's louder moments, as in pauses between words, at which a judgement has no weight.
_PAUSE_DB = 20.0
#: Silence before every source: root mean square (dB of full scale), and number of chunks.
_QUIET_DB, _QUIET_CHUNKS = -50.0, 16


@dataclass(slots=True)
class _Stream:
    """State of the network for one source."""

    context: Sound
    state: Sound
    gain: AutomaticGain = field(default_factory=lambda: AutomaticGain(SPEECH_RATE))
    waiting: Sound = field(default_factory=lambda: np.zeros(0, np.float32))
    judged: float = _DOUBT
    speech: float = float("nan")


class VoiceActivityDetector:
    """Speech probability of each of several sources, from its sound at 16 kHz.

    The network is less certain about quiet speech, and about speech that starts without silence before. So each source
    is brought to one level (AutomaticGain) and preceded by half a second of silence. About ``window`` judgements (32 ms
    each) are averaged, weighted by their level above the source's pauses, so that a voice remains a voice between its
    words.
    """

    def __init__(self, window: int = 8) -> None:
        self._network = _load()
        self._window = window
        self._streams: dict[int, _Stream] = {}

    def reset(self) -> None:
        """Drop all sources."""
        self._streams.clear()

    def keep(self, tracks: Collection[int]) -> None:
        """Drop all other sources."""
        self._streams = {track: stream for track, stream in self._streams.items() if track in tracks}

    def speech(self, track: int) -> float:
        """Probability in [0, 1] that the source is a voice, NaN before its first 32 ms."""
        stream = self._streams.get(track)
        return float("nan") if stream is None else stream.speech

    def update(self, sounds: Mapping[int, Sound]) -> None:
        """Take the next sound of each source, by track: (N,) float32, in [-1, 1), at 16 kHz."""
        streams = []
        for track, sound in sounds.items():
            stream = self._streams.get(track)
            if stream is None:
                stream = self._streams[track] = _Stream(*self._network.after_quiet)
            stream.waiting = np.concatenate([stream.waiting, sound])
            streams.append(stream)
        while ready := [stream for stream in streams if len(stream.waiting) >= CHUNK]:
            self._speech_detector(ready)

    def _speech_detector(self, streams: list[_Stream]) -> None:
        levelled = [stream.gain.apply(stream.waiting[:CHUNK]) for stream in streams]
        chunks = np.stack(
            [np.concatenate([stream.context, sound]) for stream, (sound, _) in zip(streams, levelled, strict=True)]
        )
        states = np.stack([stream.state for stream in streams], axis=1)
        probabilities, states = self._network(chunks, states)
        for index, stream in enumerate(streams):
            stream.context = chunks[index, -CONTEXT:]
            stream.waiting = stream.waiting[CHUNK:]
            stream.state = states[:, index]
            counts = max(0.0, 1 - levelled[index][1] / _PAUSE_DB)
            before = 0.0 if math.isnan(stream.speech) else stream.speech
            stream.judged = min(stream.judged + counts, self._window)
            stream.speech = before + (float(probabilities[index, 0]) - before) * min(1.0, counts / stream.judged)


class SpeechProbability:
    """Probability of speech in each 32 ms of one sound, by itself: what begins and ends an utterance is found by it."""

    def __init__(self) -> None:
        self._network = _load()
        self.reset()

    def reset(self) -> None:
        """Discard the past: the next samples do not follow the last."""
        self._stream = _Stream(*self._network.after_quiet)

    def update(self, sound: Sound) -> list[float]:
        """Take the next samples (N,) float32, in [-1, 1), at 16 kHz; the probability of each chunk that they end."""
        stream = self._stream
        stream.waiting = np.concatenate([stream.waiting, sound])
        found = []
        while len(stream.waiting) >= CHUNK:
            levelled, _ = stream.gain.apply(stream.waiting[:CHUNK])
            chunk = np.concatenate([stream.context, levelled])
            probabilities, states = self._network(chunk[None], stream.state[:, None])
            stream.context, stream.state = levelled[-CONTEXT:], states[:, 0]
            stream.waiting = stream.waiting[CHUNK:]
            found.append(float(probabilities[0, 0]))
        return found


class _SileroNetwork:
    """The network: chunks (B, 576) and states (2, B, 128) in, probabilities (B, 1) and new states out."""

    def __init__(self, session: Any) -> None:
        self._session = session
        self._rate = np.array(SPEECH_RATE, np.int64)
        rng = np.random.default_rng(1)
        chunk = np.zeros((1, CONTEXT + CHUNK), np.float32)
        state = np.zeros((2, 1, 128), np.float32)
        for _ in range(_QUIET_CHUNKS):
            quiet = rng.normal(0, 10 ** (_QUIET_DB / 20), (1, CHUNK)).astype(np.float32)
            chunk = np.concatenate([chunk[:, -CONTEXT:], quiet], axis=1)
            _, state = self(chunk, state)
        #: Initial context (64,) and state (2, 128) of a source.
        self.after_quiet = chunk[0, -CONTEXT:], state[:, 0]

    def __call__(self, chunks: Sound, states: Sound) -> tuple[Sound, Sound]:
        probabilities, states = self._session.run(None, {"input": chunks, "state": states, "sr": self._rate})
        return probabilities, states


@cache
def _load() -> _SileroNetwork:
    """The network, loaded once per process: it has no state of its own."""
    import onnxruntime

    options = onnxruntime.SessionOptions()
    # Runs in the calling thread, so that CPU time is measured there, without spinning.
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.add_session_config_entry("session.intra_op.allow_spinning", "0")
    options.log_severity_level = 3
    return _SileroNetwork(onnxruntime.InferenceSession(MODEL, options, providers=["CPUExecutionProvider"]))
