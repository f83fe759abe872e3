"""Arrays: their geometry, the directions they resolve, and the best subsets of their microphones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from app.base.errors import ConfigError
from app.base.paths import checkout_dir
from app.base.yaml_source import load_yaml
from app.modules.perception.voices.microphone_array import MicrophoneArray, load_array
from app.robots.stream_config import MicrophonesConfig

BOX = np.array(MicrophonesConfig().positions)


def test_the_file_of_the_robot_is_the_robots_array() -> None:
    checkout = checkout_dir()
    assert checkout is not None
    array = load_array(checkout / "config" / "arrays" / "irl1.yaml")
    np.testing.assert_array_equal(array.positions, BOX)
    lab = load_yaml(checkout / "config" / "lab.yaml").data
    assert array.body_m == lab["modules"]["VoiceLocalizer"]["settings"]["body_m"] > 0


def test_directions_are_taken_from_the_middle() -> None:
    array = MicrophoneArray(BOX)
    np.testing.assert_allclose(array.middle, [0, 0, 0.355])
    np.testing.assert_allclose(array.offsets.sum(axis=0), 0, atol=1e-12)
    assert len(array) == 8
    assert len(array.first) == 28
    assert array.channels == tuple(range(8))


def test_two_are_the_widest_from_left_to_right_in_front_and_above() -> None:
    pair = MicrophoneArray(BOX).subset(2)
    assert pair.channels == (0, 1)
    assert pair.dimensions == 1


def test_four_of_a_boxs_corners_touch_no_common_edge() -> None:
    four = MicrophoneArray(BOX).subset(4)
    assert four.channels == (0, 2, 5, 7)
    assert four.dimensions == 3
    np.testing.assert_allclose(four.offsets.T @ four.offsets / 4, MicrophoneArray(BOX).offsets.T @ BOX / 8, atol=1e-12)


def test_all_are_themselves_and_a_subset_of_a_subset_keeps_the_channels() -> None:
    array = MicrophoneArray(BOX)
    assert array.subset(8) is array
    assert array.subset(4).subset(2).channels[0] in (0, 2, 5, 7)


@pytest.mark.parametrize("count", [0, 1, 9])
def test_other_counts_are_refused(count: int) -> None:
    with pytest.raises(ValueError, match="2 to 8 microphones"):
        MicrophoneArray(BOX).subset(count)


@pytest.mark.parametrize(
    ("positions", "dimensions"),
    [
        ([[0, 0, 0], [0.1, 0.1, 0.1], [0.3, 0.3, 0.3]], 1),
        ([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0.0]], 2),
        ([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0.0], [0, 0, 0.1]], 3),
    ],
)
def test_how_much_of_a_direction_an_array_reports(positions: list[list[float]], dimensions: int) -> None:
    assert MicrophoneArray(np.array(positions)).dimensions == dimensions


def test_two_microphones_at_one_place_are_refused() -> None:
    with pytest.raises(ValueError, match="microphones 0 and 2 are at one place"):
        MicrophoneArray(np.array([[0, 0, 0], [0.1, 0, 0], [0, 0, 0.001]]))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("positions:\n  - [0, 0, 0]\n  - [0, 0.1]\n", r"array.yaml:3: positions\[1\]"),
        ("positions: [[0, 0, 0]]\n", r"array.yaml:1: positions"),
        ("position: [[0, 0, 0], [0, 0.1, 0]]\n", r"array.yaml:1: .*positions"),
        ("positions: [[0, 0, 0], [0, 0, 0]]\n", r"array.yaml:.* microphones 0 and 1 are at one place"),
        ("positions: [[0, 0, 0], [0, 85, 0]]\n", r"array.yaml:.* 0 and 1 are 85 m apart, .* positions are in metres"),
    ],
)
def test_errors_name_file_and_line(text: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "array.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError, match=said):
        load_array(path)
