from __future__ import annotations

import struct
import sys
from pathlib import Path

import numpy as np
import pytest
import soundfile

from app.robots.devices.config import SoundInputConfig
from app.robots.devices.image_inputs import InputUnavailable
from app.robots.devices.sound import SoundInput, open_sound
from tests.robots.devices.files import RATE, ramp, sound_file


def test_a_file_comes_sample_by_sample_and_over_again(tmp_path: Path) -> None:
    samples = ramp(1000)
    source = open_sound(SoundInputConfig(source=str(sound_file(tmp_path, samples))))
    assert (source.rate, source.channels, source.live) == (RATE, 2, False)
    frames = [source.read(300) for _ in range(7)]
    source.close()
    assert np.array_equal(np.concatenate([f for f in frames if f is not None]), np.resize(samples, (2100, 2)))


def test_without_looping_the_last_frame_is_filled_up(tmp_path: Path) -> None:
    source = open_sound(SoundInputConfig(source=str(sound_file(tmp_path, ramp(400, 1))), loop=False))
    frames = [source.read(300) for _ in range(3)]
    assert frames[1] is not None
    assert len(frames[1]) == 300
    assert not frames[1][100:].any()
    assert frames[2] is None


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("gone.wav", None, "there is no file"),
        ("broken.wav", b"RIFFnonsense", "cannot be read as sound"),
        ("bare.raw", bytes(1024), "without a header"),
    ],
)
def test_what_cannot_be_opened_says_why(tmp_path: Path, name: str, content: bytes | None, said: str) -> None:
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputUnavailable, match=said):
        open_sound(SoundInputConfig(source=str(path)))


@pytest.mark.parametrize(("rate", "channels"), [(2_000_000_000, 1), (48_000, 500)])
def test_a_file_that_says_what_no_sound_card_gives_is_refused(rate: int, channels: int, tmp_path: Path) -> None:
    path = sound_file(tmp_path, ramp(8))
    data = bytearray(path.read_bytes())
    struct.pack_into("<HIIH", data, 22, channels, rate, min(rate * channels * 2, 0xFFFFFFFF), channels * 2)
    path.write_bytes(bytes(data) + bytes(2_000))
    with pytest.raises(
        InputUnavailable, match=f"says it has {channels} channels of {rate} samples .* at most 64 of 384000"
    ):
        open_sound(SoundInputConfig(source=str(path)))


def test_a_file_without_sound_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputUnavailable, match="holds no sound"):
        open_sound(SoundInputConfig(source=str(sound_file(tmp_path, ramp(0)))))


def exhaust(source: SoundInput) -> None:
    while source.read(512) is not None:
        pass


def test_a_file_that_breaks_off_says_so(tmp_path: Path) -> None:
    whole = tmp_path / "whole.flac"
    soundfile.write(str(whole), np.random.default_rng(1).integers(-3000, 3000, 32000, dtype=np.int16), RATE)
    half = tmp_path / "half.flac"
    half.write_bytes(whole.read_bytes()[:20000])
    source = open_sound(SoundInputConfig(source=str(half)))
    with pytest.raises(InputUnavailable, match=r"half\.flac is damaged"):
        exhaust(source)


def test_without_the_library_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "sounddevice", None)
    with pytest.raises(InputUnavailable, match=r"pip install 'hbba\[devices\]'"):
        open_sound(SoundInputConfig())
