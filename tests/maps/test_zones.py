"""Zones in their file."""

from __future__ import annotations

import string
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from app.base.errors import ConfigError
from app.maps.zones import checked, crossing, read_zones, zones_text
from app.messages import Zone

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
STAIRS = Zone("stairs", "keep_out", SQUARE, 1.0)

names = st.text(st.sampled_from(string.printable + "äé漢'\"\\#:"), min_size=1, max_size=20)


@st.composite
def zones(draw: st.DrawFn) -> tuple[Zone, ...]:
    made = []
    for name in draw(st.lists(names, unique=True, max_size=4)):
        x, y = draw(st.floats(-900, 900)), draw(st.floats(-900, 900))
        corners = [(x, y), (x + draw(st.floats(0.5, 9)), y), (x, y + draw(st.floats(0.5, 9)))]
        made.append(
            Zone(name, draw(st.sampled_from(["keep_out", "slow"])), np.array(corners), draw(st.floats(0.01, 1)))
        )
    return tuple(made)


def same(one: Zone, other: Zone) -> bool:
    return (one.name, one.kind, one.speed) == (other.name, other.kind, other.speed) and np.array_equal(
        one.polygon, other.polygon
    )


@given(known=zones())
def test_there_and_back(known: tuple[Zone, ...], tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("zones") / "zones.yaml"
    path.write_text(zones_text(known), encoding="utf-8")
    back = read_zones(path)
    assert len(back) == len(known)
    assert all(same(one, other) for one, other in zip(known, back, strict=True))


def test_no_file_is_no_zones(tmp_path: Path) -> None:
    assert read_zones(tmp_path / "zones.yaml") == ()


@pytest.mark.parametrize(
    ("change", "line", "words"),
    [
        (("keep_out", "keep-out"), 4, r"zones\[0\].kind: should be 'keep_out' or 'slow'"),
        (("speed: 1.0", "speed: 0"), 6, r"zones\[0\].speed: should be greater than 0"),
        (("[1.0, 1.0], [0.0, 1.0]", ""), 5, r"zones\[0\].polygon"),
        (("[1.0, 1.0], [0.0, 1.0]", "[2.0, 0.0]"), 5, "corners are on one line"),
        (
            ("[1.0, 0.0], [1.0, 1.0]", "[1.0, 1.0], [1.0, 0.0]"),
            5,
            "should not cross itself: the side from corner 1 to 2",
        ),
        (("speed: 1.0", "sped: 1.0"), 6, r"zones\[0\].sped: unknown key"),
        (("[1.0, 1.0]", "[1.0, .inf]"), 5, r"zones\[0\].polygon\[2\]\[1\]"),
    ],
)
def test_a_mistake_is_reported_with_its_line(tmp_path: Path, change: tuple[str, str], line: int, words: str) -> None:
    text = zones_text([STAIRS])
    assert change[0] in text
    path = tmp_path / "zones.yaml"
    path.write_text(text.replace(*change), encoding="utf-8")
    with pytest.raises(ConfigError, match=words) as mistake:
        read_zones(path)
    assert (mistake.value.file, mistake.value.line) == (str(path), line)


def test_two_zones_of_one_name_and_one_without_floor_are_refused() -> None:
    with pytest.raises(ValueError, match="two zones are called 'stairs'"):
        checked([STAIRS, STAIRS])
    with pytest.raises(ValueError, match="cover some floor"):
        checked([replace(STAIRS, polygon=np.zeros((3, 2)))])
    assert checked([STAIRS, replace(STAIRS, name="ramp", kind="slow", speed=0.3)])[1].speed == 0.3


@st.composite
def stars(draw: st.DrawFn) -> NDArray[np.float64]:
    """Corners around a centre, each in a sector of its own: a polygon that is simple, however jagged."""
    count = draw(st.integers(4, 12))
    turns = np.array([draw(st.floats(0.1, 0.9)) for _ in range(count)]) + np.arange(count)
    angles = 2 * np.pi * turns / count
    reach = np.array([draw(st.floats(0.5, 20)) for _ in range(count)])
    centre = draw(st.floats(-900, 900)), draw(st.floats(-900, 900))
    corners = np.column_stack([reach * np.cos(angles), reach * np.sin(angles)]) + centre
    return corners[:: draw(st.sampled_from([1, -1]))]


@given(polygon=stars(), begin=st.integers(0, 11))
def test_a_polygon_around_a_centre_does_not_cross_itself_wherever_it_begins(
    polygon: NDArray[np.float64], begin: int
) -> None:
    assert crossing(np.roll(polygon, begin, axis=0)) is None


@given(count=st.integers(4, 40), swapped=st.integers(0, 39), reach=st.floats(0.1, 500))
def test_two_corners_exchanged_make_two_sides_cross(count: int, swapped: int, reach: float) -> None:
    angles = 2 * np.pi * np.arange(count) / count
    polygon = reach * np.column_stack([np.cos(angles), np.sin(angles)])
    a, b = swapped % count, (swapped + 1) % count
    polygon[[a, b]] = polygon[[b, a]]
    found = crossing(polygon)
    assert found is not None
    # What crosses are the sides before and behind the one between the two.
    assert {frozenset(side) for side in found} == {frozenset({(a - 1) % count, a}), frozenset({b, (b + 1) % count})}


def test_sides_that_touch_do_not_cross() -> None:
    closed = np.array([[0.0, 0], [2, 0], [2, 2], [0, 2], [0, 0]])
    assert crossing(closed) is None
    notched = np.array([[0.0, 0], [2, 0], [2, 2], [1, 0], [0, 2]])
    assert crossing(notched) is None
