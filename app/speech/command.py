"""Any program that makes a sound file of a text: ``flite -t {text} -o {file}``."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import soundfile

from app.speech.estimate import estimated_mouth, estimated_words
from app.speech.manner import USUAL, Manner
from app.speech.utterance import SpeechError, Utterance

#: Greatest length (s) of the sound of one sentence.
LONGEST_S = 120.0
#: Length (s) of a pause at the end of a sentence, which programs leave out.
_PAUSE_S = 0.2


class CommandEngine:
    """Runs ``command``, without a shell; ``{file}`` is the WAV file to write, ``{language}`` the language's tag, and
    ``{text}`` the text, which comes by standard input where no argument has it. It ends within ``timeout_s``."""

    def __init__(self, command: Sequence[str], timeout_s: float = 30.0) -> None:
        self._command = tuple(command)
        self._timeout_s = timeout_s

    def synthesize(self, text: str, language: str, manner: Manner = USUAL) -> Utterance:
        """``text`` as the program's file has it, in its own manner; times are estimated. Raises SpeechError."""
        # A text that begins with a dash would be taken for an option.
        safe = f" {text}" if text.startswith("-") else text
        with tempfile.TemporaryDirectory(prefix="hbba-speech-") as folder:
            file = Path(folder) / "speech.wav"
            values = {"{text}": safe.replace("\0", " "), "{file}": str(file), "{language}": language}
            self._run([_filled(argument, values) for argument in self._command], text)
            samples, rate = _read(file, self._command[0])
        duration_s = len(samples) / rate
        words = estimated_words(text, duration_s)
        mouth = estimated_mouth(text, words)
        samples = np.concatenate([samples, np.zeros(round(_PAUSE_S * rate), np.int16)])
        return Utterance(text, samples, rate, duration_s=len(samples) / rate, words=words, mouth=mouth)

    def _run(self, command: list[str], text: str) -> None:
        by_input = not any("{text}" in argument for argument in self._command)
        program = self._command[0]
        try:
            done = subprocess.run(
                command,
                input=text.encode() if by_input else b"",
                capture_output=True,
                timeout=self._timeout_s,
                check=False,
            )
        except subprocess.TimeoutExpired:
            raise SpeechError(f"{program} took longer than {self._timeout_s:g} s to speak a sentence") from None
        except OSError as failure:
            raise SpeechError(f"the speech program {program!r} cannot be run: {failure.strerror}") from None
        if done.returncode != 0:
            last = done.stderr.decode("utf-8", "replace").strip().splitlines()
            why = last[-1] if last else "it gave no reason"
            raise SpeechError(f"{program} failed (status {done.returncode}): {why}")


def _filled(argument: str, values: dict[str, str]) -> str:
    """``argument`` with its placeholders replaced; a placeholder in the text itself stays as it is."""
    for name, value in values.items():
        if name in argument:
            before, _, after = argument.partition(name)
            return before + value + _filled(after, values)
    return argument


def _read(file: Path, program: str) -> tuple[np.ndarray[tuple[int], np.dtype[np.int16]], int]:
    try:
        with soundfile.SoundFile(file) as sound:
            rate = int(sound.samplerate)
            if sound.frames > LONGEST_S * rate or not 8_000 <= rate <= 96_000:
                raise SpeechError(
                    f"{program} wrote {sound.frames} samples at {rate} Hz; it may write {LONGEST_S:g} s, at 8 to 96 kHz"
                )
            samples = sound.read(dtype="int16", always_2d=True)
    except (soundfile.SoundFileError, OSError):
        raise SpeechError(f"{program} wrote no sound file: its arguments must have {{file}} where it writes") from None
    return np.ascontiguousarray(samples[:, 0]), rate
