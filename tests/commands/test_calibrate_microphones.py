"""``hbba calibrate microphones``: from a recording, a log or a sound card to positions, written only if asked for."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import soundfile
from numpy.typing import NDArray

from app.base import paths
from app.cli import main
from app.commands.calibrate_microphones.arrays import ConfiguredArray
from app.commands.calibrate_microphones.listening import claps_in, missing_sides, said, where
from app.commands.calibrate_microphones.sound_inputs import Sound
from app.logs.log import Logged
from app.logs.manifest import Manifest
from app.messages import Audio, read_only
from app.modules.perception.voices.array_calibration.structure import aligned
from app.modules.perception.voices.microphone_array import MicrophoneArray
from tests.logs.replay.logs import BEGIN, write_log
from tests.modules.perception.voices.array_calibration.clap_sounds import RATE, around, recording
from tests.modules.perception.voices.sounds import toward

#: Four corners of no regular shape, as configured and as they are.
CONFIGURED = np.array([(0.08, 0.0, 0.0), (-0.03, 0.05, 0.0), (-0.03, -0.03, 0.01), (0.0, 0.0, 0.12)])
TRUE = CONFIGURED + np.random.default_rng(2).normal(0, 0.004, CONFIGURED.shape)
PLACES = around(14, 3)
SOUND = recording(PLACES, TRUE, 3, gains_db=np.array([0.0, 4.0, 0.0, 0.0]))
Said = Callable[..., tuple[int, str, str]]


def error_m(found: NDArray[np.float64]) -> float:
    return float(np.sqrt(((aligned(found, TRUE) - TRUE) ** 2).sum(axis=1).mean()))


@pytest.fixture
def array(tmp_path: Path) -> Path:
    """The configured array."""
    file = tmp_path / "pyramid.yaml"
    rows = "".join(f"  - [{x}, {y}, {z}]   # a corner\n" for x, y, z in CONFIGURED.tolist())
    file.write_text(f"# four microphones\npositions:\n{rows}", encoding="utf-8")
    return file


@pytest.fixture
def claps(tmp_path: Path) -> Path:
    """A recording of them."""
    file = tmp_path / "claps.wav"
    soundfile.write(file, SOUND, RATE)
    return file


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Said:
    """Runs the command; gives its exit code, output and remarks."""

    def command(*arguments: object) -> tuple[int, str, str]:
        code = main(["calibrate", "microphones", *map(str, arguments)])
        printed = capsys.readouterr()
        return code, printed.out, printed.err

    return command


def positions_in(file: Path) -> NDArray[np.float64]:
    rows = [line.split("[")[1].split("]")[0] for line in file.read_text("utf-8").splitlines() if "[" in line]
    return np.array([[float(number) for number in row.split(",")] for row in rows])


def test_a_recording_calibrates_and_is_written_when_asked_for(array: Path, claps: Path, run: Said) -> None:
    before = array.read_text("utf-8")
    code, out, _ = run(claps, "--array", array)
    assert code == 0
    assert out.startswith(f"{array}: 4 microphones, 14 claps, 14 of them used\n")
    assert "Adopt these positions: the positions found explain claps that they were not fitted to within" in out
    assert re.search(r"Levels differ by (3\.[5-9]|4\.[0-5]) dB\.", out)
    assert "Sound does not show how the array as a whole is turned" in out
    assert f"Nothing is written; --write puts the positions into {array}" in out
    assert array.read_text("utf-8") == before
    code, out, _ = run(claps, "--array", array, "--write", "--json")
    document = json.loads(out)
    assert (code, document["verdict"], document["written"], document["order"]) == (0, "adopt", str(array), None)
    written = positions_in(array)
    np.testing.assert_allclose(written, document["positions"])
    assert error_m(written) < 0.001 < 0.004 < error_m(CONFIGURED)
    assert array.read_text("utf-8").count("# a corner") == 4
    assert [one["fault"] for one in document["microphones"]] == [""] * 4
    assert len(document["claps"]) == 14
    # Calibrated, the same claps confirm it, and there is nothing to write.
    code, out, _ = run(claps, "--array", array, "--write")
    assert code == 0
    assert "Keep the configured positions" in out
    assert "Written" not in out
    np.testing.assert_allclose(positions_in(array), written)


def test_other_order_and_faults_are_said(array: Path, tmp_path: Path, run: Said) -> None:
    file = tmp_path / "swapped.flac"
    soundfile.write(file, SOUND[:, [2, 1, 0, 3]], RATE)
    code, out, _ = run(file, "--array", array)
    assert code == 0
    assert "The channels are in another order than configured: 0, 2 are the microphones configured as 2, 0." in out
    assert re.search(r"^ +2 .* configured as 0$", out, re.MULTILINE)
    dead = SOUND.copy()
    dead[:, 1] = 0
    soundfile.write(file, dead, RATE)
    code, out, _ = run(file, "--array", array, "--write")
    # Three microphones are a plane: its claps are of all heights.
    assert code == 1
    assert "Channel 1 hears none of the claps." in out
    assert "Do not adopt this: clap again: " in out
    np.testing.assert_allclose(positions_in(array), CONFIGURED)


def test_a_log_has_its_own_array(tmp_path: Path, array: Path, run: Said) -> None:
    messages = [
        Logged(
            BEGIN + begin / RATE,
            "microphones",
            Audio(BEGIN + begin / RATE, "m", read_only(SOUND[begin : begin + 512]), RATE, begin, read_only(CONFIGURED)),
        )
        for begin in range(0, len(SOUND) - 512, 512)
    ]
    log = write_log(tmp_path / "claps.mcap", messages, Manifest())
    code, out, _ = run(log, "--json")
    document = json.loads(out)
    assert (code, document["array"], document["verdict"]) == (0, "microphones of it", "adopt")
    assert error_m(np.array(document["positions"])) < 0.001
    assert run(log, "--write")[0] == 2
    code, _, err = run(log, "--channel", "played")
    assert (code, "there is no sound on a channel 'played'; sound is on microphones" in err) == (2, True)
    code, out, _ = run(log, "--array", array, "--json")
    assert (code, json.loads(out)["array"]) == (0, str(array))


def test_claps_at_the_sound_card_are_counted_and_said(tmp_path: Path, claps: Path, run: Said) -> None:
    body = tmp_path / "body.yaml"
    model = paths.config_dir() / "robots" / "desk.urdf"
    body.write_text(
        f"kind: devices\nname: Desk\nmodel: {model}\n"
        f"microphones: {{source: {claps}, channels: 4, positions: {CONFIGURED.tolist()}}}   # ours\n",
        encoding="utf-8",
    )
    code, out, err = run("--robot", body, "--claps", "13", "--write")
    assert code == 0
    assert "Clap 13 times, 1 to 2 m from the array, each time from another side, some above its height" in err
    lines = [line for line in err.splitlines() if line.startswith("clap ")]
    assert len(lines) == 13
    assert "; 12 more; nothing yet from " in lines[0]
    assert lines[-1].endswith("that is all")
    assert f"Written: {body}" in out
    assert body.read_text("utf-8").endswith("}   # ours\n")
    assert error_m(positions_in_body(body)) < 0.001


def positions_in_body(file: Path) -> NDArray[np.float64]:
    text = file.read_text("utf-8")
    return np.array(json.loads(text[text.index("[[") : text.index("]]") + 2]))


def test_an_interrupt_ends_the_listening_with_what_was_heard(capsys: pytest.CaptureFixture[str]) -> None:
    def blocks(claps: int) -> Iterator[tuple[NDArray[np.int16], int]]:
        end = round((0.45 * claps + 0.25) * RATE)
        yield from ((SOUND[begin : begin + 4800], 0) for begin in range(0, end, 4800))
        raise KeyboardInterrupt

    configured = ConfiguredArray(MicrophoneArray(CONFIGURED), "corners")
    assert len(claps_in(Sound(RATE, blocks(3), configured, live=True), configured.array, 12)) == 3
    assert "clap 3: from " in capsys.readouterr().err
    with pytest.raises(KeyboardInterrupt):
        claps_in(Sound(RATE, blocks(0), configured, live=True), configured.array, 12)


def test_mistakes_are_one_sentence(tmp_path: Path, array: Path, claps: Path, run: Said) -> None:
    def refused(*arguments: object) -> str:
        code, out, err = run(*arguments)
        assert (code, out) == (2, "")
        return err

    assert "name the array with --array or --robot" in refused(claps)
    assert "name the array with --array or --robot" in refused()
    assert "--write: name the file to be written" in refused(claps, "--write")
    assert "there is no file nothing.wav" in refused("nothing.wav", "--array", array)
    assert f"{claps}: has 4 channels, but irl1 has 8 microphones" in refused(claps, "--array", "irl1")
    assert "has no microphones with positions" in refused(claps, "--robot", "webcam")
    assert "a simulated body has no sound card" in refused("--robot", "irl1_tr")
    slow = tmp_path / "slow.wav"
    soundfile.write(slow, SOUND[:4000], 8000)
    assert "has 8000 samples a second; at least 16000 are needed" in refused(slow, "--array", array)
    text = tmp_path / "text.wav"
    text.write_text("no sound")
    assert "cannot be read as a recording" in refused(text, "--array", array)
    few = tmp_path / "few.wav"
    soundfile.write(few, SOUND[: 3 * RATE], RATE)
    code, out, _ = run(few, "--array", array)
    assert code == 1
    assert out.startswith("Not calibrated: ")
    assert "at least 8 are needed" in out
    code, out, _ = run(few, "--array", array, "--json")
    assert (code, json.loads(out)["verdict"]) == (1, "repeat")


def test_directions_are_words() -> None:
    assert where(toward(3, 2)) == "the front"
    assert where(toward(50, 33)) == "the front left, 30° up"
    assert where(toward(-92, -18)) == "the right, 20° down"
    assert where(toward(179, 0)) == where(toward(-179, 0)) == "behind"
    assert where(toward(0, 80)) == "above"
    heard = [toward(0, 0), toward(95, 30)]
    assert missing_sides(heard, 3) == ["behind", "the right", "below"]
    assert missing_sides(heard, 2) == ["behind", "the right"]
    assert missing_sides(heard, 1) == []
    assert said(2, 5, heard, 2) == "clap 2: from the left, 30° up; 3 more; nothing yet from behind and the right"
    assert said(5, 5, heard, 2) == "clap 5: from the left, 30° up; that is all"
