"""Files of worlds: what is read, what is refused and how that is said."""

from __future__ import annotations

import json
import math
import os
from pathlib import Path
from typing import Any

import pytest

from app.base.errors import ConfigError
from app.experiments.barn.trial import goal_on_the_map
from app.experiments.barn.worlds import chosen, load_worlds
from tests.experiments.barn.conftest import make_file, make_world


def test_a_world_is_built_as_it_stands_in_the_file(tmp_path: Path) -> None:
    world = make_world(7, cylinders=[[1.0, 2.0, 0.075], [1.5, 2.0, 0.2], [2.0, 2.0, 0.075]])
    (read,) = load_worlds(make_file(tmp_path, world)).worlds
    built = {group.radius: group.at for group in read.build().cylinders}
    assert built == {0.075: ((1.0, 2.0), (2.0, 2.0)), 0.2: ((1.5, 2.0),)}
    assert read.start_pose().heading_deg == pytest.approx(math.degrees(1.57))
    goal = goal_on_the_map(read)
    assert (goal.x, goal.y) == pytest.approx((3.0, 0.0), abs=0.01)  # straight ahead of where it starts


def test_the_length_is_the_files_or_its_paths_or_a_straight_line(tmp_path: Path) -> None:
    bent = [[0, 0], [3, 0], [3, 4]]
    worlds = [
        make_world(1),
        make_world(2, path=bent, path_length=None),
        make_world(3, path=[], path_length=None, goal=[3, 4]),
    ]
    assert [world.length_m for world in load_worlds(make_file(tmp_path, *worlds)).worlds] == [3.0, 7.0, 5.0]


def test_what_is_not_needed_may_be_missing_and_what_is_not_known_is_passed_over(tmp_path: Path) -> None:
    least = {"id": "a-1", "cylinders": [], "start": [0, 0, 0], "goal": [5, 0, 1.57], "colour": "red"}
    file = tmp_path / "worlds.json"
    file.write_text(json.dumps({"worlds": [least]}))
    worlds = load_worlds(file)
    assert worlds.max_mps == 2.0
    assert (worlds.worlds[0].goal_tolerance, worlds.worlds[0].timeout_s) == (1.0, 100.0)
    assert worlds.worlds[0].goal == (5.0, 0.0)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"cylinders": [[0, 0]]}, "world 5: cylinders.0.2: is missing"),
        ({"cylinders": [[1, 1, -0.1]]}, "world 5: cylinders.0.2: should be greater than 0"),
        ({"start": [1, 2]}, "world 5: start.2: is missing"),
        ({"goal": "north"}, "world 5: goal: should be a list, not 'north'"),
        ({"goal": [0.0, 0.4]}, "world 5: the start lies within the tolerance of the goal"),
        ({"cylinders": [[0.05, 0, 0.1]]}, "world 5: the start (0, 0) lies in the cylinder at (0.05, 0)"),
        ({"timeout_s": float("nan")}, "world 5: timeout_s: should be"),
    ],
)
def test_a_mistake_names_the_world_and_the_value(tmp_path: Path, change: dict[str, Any], words: str) -> None:
    file = make_file(tmp_path, make_world(4), make_world(5, **change))
    with pytest.raises(ConfigError) as caught:
        load_worlds(file)
    assert f"{file}: {words}" in str(caught.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{", "is no JSON"),
        ("[]", "is no file of worlds: should be a JSON object, not a list"),
        ("{}", "is no file of worlds: it has no list of 'worlds'"),
        ('{"worlds": []}', "worlds: should have at least 1 item"),
        ("\xff", "is not a text file in UTF-8"),
    ],
)
def test_a_file_that_is_none_is_refused(tmp_path: Path, text: str, words: str) -> None:
    file = tmp_path / "worlds.json"
    file.write_bytes(text.encode("latin-1"))
    with pytest.raises(ConfigError, match=words):
        load_worlds(file)
    with pytest.raises(ConfigError, match="cannot be read"):
        load_worlds(tmp_path / "none.json")


def test_two_worlds_of_one_id_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="two worlds have the id 1"):
        load_worlds(make_file(tmp_path, make_world(1), make_world(1)))


def test_worlds_are_chosen_by_id_and_by_range(tmp_path: Path) -> None:
    worlds = load_worlds(make_file(tmp_path, *(make_world(number) for number in (1, 2, 5, 10, 12))))

    def names(only: str | None) -> list[str]:
        return [world.name for world in chosen(worlds, only)]

    assert names(None) == ["1", "2", "5", "10", "12"]
    assert names("10, 1") == ["1", "10"]
    assert names("2-10,12") == ["2", "5", "10", "12"]
    for wrong in ("3", "one", "20-30", ""):
        with pytest.raises(ConfigError, match="--only"):
            names(wrong)


def test_the_challenges_own_worlds_are_read() -> None:
    data = Path(os.environ.get("HBBA_REFERENCE_DATA") or Path(__file__).parents[4] / "shared" / "data")
    if not (data / "barn" / "worlds.json").is_file():
        pytest.skip(f"the challenge's worlds are not there: {data} (set HBBA_REFERENCE_DATA)")
    worlds = load_worlds(data / "barn" / "worlds.json")
    assert len(worlds.worlds) == 250
    assert worlds.max_mps == 2.0
    first = worlds.worlds[0]
    assert first.length_m / worlds.max_mps == pytest.approx(6.2156, abs=1e-4)
    goal = goal_on_the_map(first)
    assert math.hypot(goal.x, goal.y) == pytest.approx(10.0)
