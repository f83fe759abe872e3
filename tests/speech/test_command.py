from __future__ import annotations

import sys
from pathlib import Path

import pytest
from pydantic import TypeAdapter, ValidationError

from app.speech.command import CommandEngine
from app.speech.config import EngineConfig
from app.speech.utterance import SpeechError

#: Writes a tone as long as the text has letters, in 10 ms.
PROGRAM = """
import sys, wave
text = sys.argv[1] if len(sys.argv) > 2 else sys.stdin.read()
with wave.open(sys.argv[-1], "wb") as file:
    file.setnchannels(1); file.setsampwidth(2); file.setframerate(16000)
    file.writeframes(b"\\x00\\x10" * 160 * len(text))
"""


@pytest.fixture
def program(tmp_path: Path) -> str:
    path = tmp_path / "speak.py"
    path.write_text(PROGRAM)
    return str(path)


@pytest.mark.parametrize("arguments", [("{text}", "{file}"), ("{file}",)])
def test_the_programs_file_is_the_utterance(program: str, arguments: tuple[str, ...]) -> None:
    utterance = CommandEngine([sys.executable, program, *arguments]).synthesize("ten {file}", "en")
    assert utterance.rate == 16_000
    assert (utterance.samples != 0).sum() == 1600
    assert [utterance.text[word.begin : word.end] for word in utterance.words] == ["ten", "{file}"]
    assert utterance.words[-1].end_s == pytest.approx(0.1)


def test_a_text_is_no_option(program: str) -> None:
    utterance = CommandEngine([sys.executable, program, "{text}", "{file}"]).synthesize("--help", "en")
    assert (utterance.samples != 0).sum() == 160 * len(" --help")


@pytest.mark.parametrize(
    ("command", "problem"),
    [
        (["/no/such/program", "{file}"], "'/no/such/program' cannot be run: No such file"),
        ([sys.executable, "-c", "raise SystemExit('no voice')", "{file}"], "status 1.*: no voice"),
        ([sys.executable, "-c", "", "{file}"], r"wrote no sound file: its arguments must have \{file\}"),
    ],
)
def test_what_fails_is_said_in_a_sentence(command: list[str], problem: str) -> None:
    with pytest.raises(SpeechError, match=problem):
        CommandEngine(command).synthesize("hello", "en")


def test_a_program_that_does_not_end_is_ended() -> None:
    command = [sys.executable, "-c", "input()\nwhile True: pass", "{file}"]
    with pytest.raises(SpeechError, match="took longer than"):
        CommandEngine(command, timeout_s=0.3).synthesize("hello\n", "en")


def test_engines_are_configured_by_name() -> None:
    engines: TypeAdapter[EngineConfig] = TypeAdapter(EngineConfig)
    assert engines.validate_python({"engine": "text"}).make().synthesize("hi", "en").duration_s > 0
    with pytest.raises(ValidationError, match=r"must have \{file\}"):
        engines.validate_python({"engine": "command", "command": ["flite"]})
