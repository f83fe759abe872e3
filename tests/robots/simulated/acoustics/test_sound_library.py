"""The library: every sound there, as loud as it is in life, the same each time, and clear words for what is not."""

from __future__ import annotations

import importlib.util
import os
import sys
from pathlib import Path

import numpy as np
import pytest
import soundfile

from app.base.errors import ConfigError
from app.robots.simulated.acoustics import sound_library
from app.robots.simulated.acoustics.sound_library import MEAN_DB_SPL, PEAK_DB_SPL, RECORDINGS, SPEECH, ClipLibrary
from app.robots.simulated.acoustics.synthesis import MAKERS
from app.speech import espeak

RATE = 48000
SENSITIVITY_DB = -32.0


@pytest.fixture(scope="module")
def library() -> ClipLibrary:
    return ClipLibrary(RATE, SENSITIVITY_DB)


def db(amplitude: float) -> float:
    return float(20 * np.log10(amplitude))


@pytest.mark.parametrize("name", sorted(RECORDINGS))
def test_speech_is_as_loud_as_a_talker_and_has_its_pauses(library: ClipLibrary, name: str) -> None:
    clip = library.get(name)
    assert db(clip.level) == pytest.approx(SENSITIVITY_DB, abs=0.1)
    assert 1.5 < clip.seconds < 7.0
    assert 0.5 < clip.activity.mean() <= 1.0
    spectrum = np.abs(np.fft.rfft(clip.samples)) ** 2
    f = np.fft.rfftfreq(clip.samples.size, 1 / RATE)
    assert spectrum[(f > 80) & (f < 4000)].sum() > 0.7 * spectrum.sum()
    assert spectrum[f > 8200].sum() < 1e-3 * spectrum.sum()


@pytest.mark.parametrize("name", sorted(MAKERS))
def test_sounds_made_by_rule_have_their_levels_and_are_the_same_each_time(library: ClipLibrary, name: str) -> None:
    clip = library.get(name)
    if name in PEAK_DB_SPL:
        assert db(np.abs(clip.samples).max()) == pytest.approx(PEAK_DB_SPL[name] - 65 + SENSITIVITY_DB, abs=0.1)
    else:
        assert db(clip.samples.std()) == pytest.approx(MEAN_DB_SPL[name] - 65 + SENSITIVITY_DB, abs=0.1)
    np.testing.assert_array_equal(clip.samples, ClipLibrary(RATE, SENSITIVITY_DB).get(name).samples)
    assert clip.samples.dtype == np.float32
    assert np.abs(clip.samples[-1]) < 0.3 * np.abs(clip.samples).max()


def test_a_clap_is_short_and_begins_at_once_and_no_two_are_alike(library: ClipLibrary) -> None:
    one, other = library.get("clap", "operator: clap 1"), library.get("clap", "operator: clap 2")
    assert not np.array_equal(one.samples, other.samples)
    for clip in (one, other):
        energy = np.cumsum(clip.samples.astype(float) ** 2)
        assert np.searchsorted(energy, 0.9 * energy[-1]) < 0.03 * RATE
        loud = np.flatnonzero(np.abs(clip.samples) > 0.3 * np.abs(clip.samples).max())
        assert loud[0] < 0.003 * RATE


def test_it_reports_when_a_sound_is_active(library: ClipLibrary) -> None:
    clip = library.get("question")
    assert not clip.active(-0.1)
    assert not clip.active(clip.seconds + 0.1)
    assert clip.active(clip.seconds + 0.3, loop=True) == clip.active(0.3)
    activity = [clip.active(0.01 * index + 0.005) for index in range(clip.activity.size)]
    np.testing.assert_array_equal(activity, clip.activity)


def test_files_of_any_rate_become_speech_of_ordinary_loudness(library: ClipLibrary, tmp_path: Path) -> None:
    times = np.arange(22050) / 22050
    soundfile.write(tmp_path / "tone.wav", np.column_stack([np.sin(2 * np.pi * 440 * times)] * 2) * 0.01, 22050)
    clip = library.get(str(tmp_path / "tone.wav"))
    assert clip.seconds == pytest.approx(1.0, abs=0.001)
    assert db(clip.level) == pytest.approx(SENSITIVITY_DB, abs=0.2)
    spectrum = np.abs(np.fft.rfft(clip.samples))
    assert np.fft.rfftfreq(clip.samples.size, 1 / RATE)[np.argmax(spectrum)] == pytest.approx(440, abs=1)


def test_what_there_is_not_is_said_in_a_sentence(library: ClipLibrary, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"there is no sound 'clapp'.*clap"):
        library.get("clapp")
    (tmp_path / "no.wav").write_text("no sound")
    with pytest.raises(ConfigError, match="cannot be read as sound"):
        library.get(str(tmp_path / "no.wav"))


def test_text_without_a_synthesizer_is_refused_with_the_remedy(
    library: ClipLibrary, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "espeakng_loader", None)
    espeak._library.cache_clear()
    with pytest.raises(ConfigError, match=r"'come here, robot' cannot be said.*hbba\[speech\]"):
        ClipLibrary(RATE, SENSITIVITY_DB).get("come here, robot")


@pytest.mark.skipif(importlib.util.find_spec("espeakng_loader") is None, reason="the extra 'speech' is not installed")
def test_text_is_spoken_by_each_person_in_a_voice_of_their_own(library: ClipLibrary) -> None:
    one, other = library.get("come here, robot", "person 1"), library.get("come here, robot", "person 2")
    assert 0.5 < one.seconds < 4.0
    assert db(one.level) == pytest.approx(SENSITIVITY_DB, abs=0.1)
    assert one.samples.size != other.samples.size or not np.array_equal(one.samples, other.samples)


def test_the_recordings_are_small_and_their_licences_stated() -> None:
    files = sorted(SPEECH.glob("*.flac"))
    assert {file.stem for file in files} == set(RECORDINGS.values())
    assert sum(file.stat().st_size for file in files) < 1_000_000
    notice = (SPEECH / "README.md").read_text(encoding="utf-8")
    for file in files:
        line = next(line for line in notice.splitlines() if file.name in line)
        assert "public domain" in line


@pytest.mark.parametrize(("rate", "seconds"), [(2_000_000_000, 0.0), (100, 1.0), (48_000, 1_251.0)])
def test_a_file_that_says_more_than_sound_has_is_refused(rate: int, seconds: float, tmp_path: Path) -> None:
    path = tmp_path / "endless.flac" if seconds > 10 else tmp_path / "odd.wav"
    soundfile.write(path, np.zeros(max(10, int(rate * seconds)), np.int16), rate)
    with pytest.raises(ConfigError, match=rf"says it has \d+ samples, {rate} a second; at most"):
        sound_library._read(path)


def test_a_pipe_in_a_files_place_is_refused_and_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "a.wav")
    with pytest.raises(ConfigError, match="is a pipe, no regular file"):
        sound_library._read(tmp_path / "a.wav")
