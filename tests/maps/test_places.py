"""Places in their file, and how ids and names are made."""

from __future__ import annotations

import math
import re
import string
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.errors import ConfigError
from app.base.geometry import Pose2
from app.maps.places import (
    LONGEST_NAME,
    PLACE_ID,
    checked,
    go_to_parameters,
    new_id,
    new_name,
    places_text,
    pose_of,
    read_places,
    with_pose,
    write_places,
)
from app.messages import Place

LAB = Place("robotics-lab", "Robotics lab", 1.5, -2.0, 0.25, "poster", "tour:robotics lab", 3)
DOCK = Place("dock", "Dock", 0.0, 0.0, -math.pi, "here")

texts = st.text(st.sampled_from(string.printable + "äé漢'\"\\#:\u2028"), max_size=90)
metres = st.floats(-1000, 1000)


@st.composite
def places(draw: st.DrawFn) -> tuple[Place, ...]:
    made: list[Place] = []
    for wanted in draw(st.lists(texts, max_size=5)):
        name = new_name(wanted, [place.name for place in made])
        poster = draw(texts)
        made.append(
            Place(
                new_id(name, [place.id for place in made]),
                name,
                draw(metres),
                draw(metres),
                draw(st.floats(-math.pi, math.pi, exclude_max=True)),
                "poster" if poster else draw(st.sampled_from(["hand", "here"])),
                poster,
                draw(st.integers(0, 1000)),
            )
        )
    return tuple(made)


@given(known=places())
def test_there_and_back(known: tuple[Place, ...], tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("places") / "places.yaml"
    write_places(path, known)
    assert read_places(path) == known


def test_no_file_is_no_places(tmp_path: Path) -> None:
    assert read_places(tmp_path / "places.yaml") == ()


@pytest.mark.parametrize(
    ("change", "line", "words"),
    [
        (('"robotics-lab"', '"Robotics lab"'), 3, r"places\[0\].id: .*pattern"),
        (('"robotics-lab"', '"dock"'), 2, "two places have the id 'dock'"),
        (('"Robotics lab"', '"Dock"'), 2, "two places are called 'Dock'"),
        (('"Robotics lab"', '""'), 4, r"places\[0\].name"),
        (('"Robotics lab"', '" lab"'), 4, r"places\[0\].name: should be printable, without spaces before"),
        (("x: 1.5", "x: .nan"), 5, r"places\[0\].x"),
        (("x: 1.5", "x: 1001"), 5, r"places\[0\].x: should be less than or equal to 1000"),
        (("heading: 0.25", "theta: 0.25"), 7, r"places\[0\].theta: unknown key; did you mean|allowed: heading"),
        (("source: \"poster\"", "source: paper"), 8, r"places\[0\].source: should be 'hand', 'here' or 'poster'"),
        (("source: \"poster\"", "source: hand"), 3, "poster's text if and only if its source is poster"),
    ],
)  # fmt: skip
def test_a_mistake_is_reported_with_its_line(tmp_path: Path, change: tuple[str, str], line: int, words: str) -> None:
    text = places_text([LAB, DOCK])
    assert change[0] in text
    path = tmp_path / "places.yaml"
    path.write_text(text.replace(*change, 1), encoding="utf-8")
    with pytest.raises(ConfigError, match=words) as mistake:
        read_places(path)
    assert (mistake.value.file, mistake.value.line) == (str(path), line)


def test_a_problem_is_of_the_moment_and_not_kept() -> None:
    assert checked([Place("dock", "Dock", 0, 0, 0, problem="it is in an obstacle")])[0].problem == ""


def test_an_angle_out_of_range_is_wrapped() -> None:
    assert checked([Place("dock", "Dock", 0, 0, 3 * math.pi)])[0].heading == pytest.approx(-math.pi)


@pytest.mark.parametrize(
    ("name", "taken", "id_"),
    [
        ("Robotics lab", [], "robotics-lab"),
        ("Robotics lab", ["robotics-lab", "robotics-lab-2"], "robotics-lab-3"),
        ("Küche & Büro (2)", [], "kuche-buro-2"),
        ("漢字", [], "place"),
        ("漢字", ["place"], "place-2"),
        ("a" * 60, ["a" * 40], "a" * 38 + "-2"),
    ],
)
def test_an_id_is_made_of_the_name(name: str, taken: list[str], id_: str) -> None:
    assert new_id(name, taken) == id_


@given(wanted=texts, taken=st.sets(texts))
def test_what_is_made_is_valid_and_new(wanted: str, taken: set[str]) -> None:
    name = new_name(wanted, taken)
    id_ = new_id(wanted, taken)
    assert name not in taken
    assert len(name) <= LONGEST_NAME
    assert id_ not in taken
    assert re.fullmatch(PLACE_ID, id_)
    assert checked([Place(id_, name, 0, 0, 0)])


def test_a_pose_given_by_hand_frees_it_from_its_poster() -> None:
    moved = with_pose(LAB, Pose2(1.0, 2.0, 4.0))
    assert (moved.id, moved.name) == (LAB.id, LAB.name)
    assert (moved.source, moved.poster, moved.landmark) == ("hand", "", 0)
    assert pose_of(moved) == Pose2(1.0, 2.0, pytest.approx(4.0 - 2 * math.pi, abs=1e-5))


def test_a_goal_by_name_carries_the_name_and_the_pose() -> None:
    wanted = {"x": 1.5, "y": -2.0, "heading": 0.25, "place": "robotics-lab", "name": "Robotics lab"}
    assert go_to_parameters(LAB) == wanted
