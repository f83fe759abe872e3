"""Is it a voice: Silero VAD, a small recurrent network, on each source's own sound (see SILERO_VAD.md beside this)."""

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
#: What the network was trained on: samples a second, samples in one judgement, and of those before it.
SPEECH_RATE = 16_000
CHUNK = 512
CONTEXT = 64
#: A source's first moment counts as so many judgements that it is no voice: a single sound is not enough.
_DOUBT = 2.0
#: What is so far (dB) below the source's louder moments, as the pauses between words are, says nothing.
_PAUSE_DB = 20.0
#: The quiet the network hears before every source: its root mean square (dB of full scale), and for how many chunks.
_QUIET_DB, _QUIET_CHUNKS = -50.0, 16


@dataclass(slots=True)
class _Stream:
    """One source's sound as the network hears it."""

    context: Sound
    state: Sound
    gain: AutomaticGain = field(default_factory=lambda: AutomaticGain(SPEECH_RATE))
    waiting: Sound = field(default_factory=lambda: np.zeros(0, np.float32))
    judged: float = _DOUBT
    speech: float = float("nan")


class VoiceActivityDetector:
    """How probably each of several sources is speech, from its sound at 16 kHz.

    The network judges quiet speech less surely than loud, and speech that it hears from its middle on less surely than
    after a silence. So each source is brought to one level (AutomaticGain), and begins after half a second of quiet.
    About ``window`` judgements (32 ms each) are averaged, each by how much it stands out of the source's own pauses:
    a voice stays one between its words.
    """

    def __init__(self, window: int = 8) -> None:
        self._network = _load()
        self._window = window
        self._streams: dict[int, _Stream] = {}

    def reset(self) -> None:
        """Forget all sources."""
        self._streams.clear()

    def keep(self, tracks: Collection[int]) -> None:
        """Forget all but these sources."""
        self._streams = {track: stream for track, stream in self._streams.items() if track in tracks}

    def speech(self, track: int) -> float:
        """Probability in [0, 1] that the source is a voice, NaN before 32 ms of it were heard."""
        stream = self._streams.get(track)
        return float("nan") if stream is None else stream.speech

    def hear(self, sounds: Mapping[int, Sound]) -> None:
        """Take what each source, by its track, says next: (N,) float32, in [-1, 1), 16,000 samples a second."""
        streams = []
        for track, sound in sounds.items():
            stream = self._streams.get(track)
            if stream is None:
                stream = self._streams[track] = _Stream(*self._network.after_quiet)
            stream.waiting = np.concatenate([stream.waiting, sound])
            streams.append(stream)
        while ready := [stream for stream in streams if len(stream.waiting) >= CHUNK]:
            self._judge(ready)

    def _judge(self, streams: list[_Stream]) -> None:
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
        #: Context (64,) and state (2, 128) with which a source begins.
        self.after_quiet = chunk[0, -CONTEXT:], state[:, 0]

    def __call__(self, chunks: Sound, states: Sound) -> tuple[Sound, Sound]:
        probabilities, states = self._session.run(None, {"input": chunks, "state": states, "sr": self._rate})
        return probabilities, states


@cache
def _load() -> _SileroNetwork:
    """The network, read once for the whole process: it keeps no state of its own."""
    import onnxruntime

    options = onnxruntime.SessionOptions()
    # In the thread that calls, so that the work is counted where it is done, and without waiting in circles.
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.add_session_config_entry("session.intra_op.allow_spinning", "0")
    options.log_severity_level = 3
    return _SileroNetwork(onnxruntime.InferenceSession(MODEL, options, providers=["CPUExecutionProvider"]))
