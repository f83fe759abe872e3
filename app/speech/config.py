"""Speech engines as configured."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, field_validator

from app.speech.command import CommandEngine
from app.speech.espeak import Espeak
from app.speech.piper import Piper
from app.speech.text_only import TextOnly
from app.speech.utterance import SpeechEngine

#: A language's tag: ``en``, ``fr``, ``en-gb``.
Language = Annotated[str, Field(pattern=r"^[a-z]{2,3}(-[a-z0-9]{1,8})*$")]


class _EngineConfig(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class EspeakConfig(_EngineConfig):
    """espeak-ng: a hundred languages, plain."""

    engine: Literal["espeak"]
    variant: str = Field("", pattern=r"^[A-Za-z0-9_]*$", description="of the voice, as m3 or f2; none: its own")
    words_per_minute: int = Field(160, ge=80, le=450, description="how fast")
    pitch: int = Field(50, ge=0, le=100, description="how high")

    def make(self) -> SpeechEngine:
        """The engine."""
        return Espeak(self.variant, self.words_per_minute, self.pitch)


class PiperConfig(_EngineConfig):
    """Piper: one neural voice of one language."""

    engine: Literal["piper"]
    model: Path | None = Field(None, description="the voice's .onnx file; none: joe, English")

    def make(self) -> SpeechEngine:
        """The engine."""
        return Piper(self.model)


class CommandConfig(_EngineConfig):
    """Any program that writes a sound file."""

    engine: Literal["command"]
    command: tuple[str, ...] = Field(min_length=1, description="program and arguments: {file}, {text}, {language}")
    timeout_s: float = Field(30.0, gt=0, le=120, description="a sentence takes no longer")

    @field_validator("command")
    @classmethod
    def _writes(cls, command: tuple[str, ...]) -> tuple[str, ...]:
        if not any("{file}" in argument for argument in command[1:]):
            raise ValueError("one of the arguments must have {file}, the sound file that the program writes")
        return command

    def make(self) -> SpeechEngine:
        """The engine."""
        return CommandEngine(self.command, self.timeout_s)


class TextConfig(_EngineConfig):
    """No sound: subtitles alone."""

    engine: Literal["text"]
    words_per_minute: float = Field(160.0, ge=40, le=600, description="how fast subtitles go on")

    def make(self) -> SpeechEngine:
        """The engine."""
        return TextOnly(self.words_per_minute)


EngineConfig = Annotated[EspeakConfig | PiperConfig | CommandConfig | TextConfig, Field(discriminator="engine")]
