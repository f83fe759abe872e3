"""Recognition of words: which of a few phrases one utterance is. Engines behind one interface; blocking, no asyncio."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from app.base.errors import ConfigError
from app.base.extensions import load_named, why_absent

#: Rate (Hz) of the sound that engines take.
RATE = 16_000


class RecognitionError(Exception):
    """Words cannot be recognized; the message is one sentence with the reason and the remedy."""


@dataclass(frozen=True, slots=True)
class Recognition:
    """The likeliest of the phrases. ``confidence`` in [0, 1]: how sure it is that this was said, and nothing else."""

    text: str
    confidence: float


class RecognitionEngine(Protocol):
    """Recognizes utterances; made with the path of its model, or None for its usual one. One thread at a time."""

    def recognize(self, samples: NDArray[np.int16], phrases: Sequence[str], language: str) -> Recognition | None:
        """Which of ``phrases``, in ``language`` (a tag such as ``en``), the utterance (N,) at RATE is; None: none.

        An empty utterance checks the phrases. Raises RecognitionError for a phrase or a language that it does not know,
        and where its package is missing.
        """
        ...


class RecognizerConfig(BaseModel):
    """What recognizes words: a class, and the path of its model."""

    model_config = ConfigDict(frozen=True, extra="forbid", populate_by_name=True)

    class_path: str = Field(
        "app.speech.pocketsphinx:PocketSphinx", alias="class", description="engine, package.module:Class"
    )
    path: Path | None = Field(None, description="of its model; none: its usual one")

    def make(self) -> RecognitionEngine:
        """The engine. Raises ConfigError where there is no such class."""
        found = load_named(self.class_path)
        if not isinstance(found, type):
            why = why_absent(self.class_path) or "it is no class"
            raise ConfigError(f"there is no recognizer {self.class_path!r} (package.module:Class): {why}")
        engine: RecognitionEngine = found(self.path)
        return engine
