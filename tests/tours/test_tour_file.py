"""Files of tours: what is written is read again, and what is no tour is refused with file, line and field."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from app.base.errors import ConfigError
from app.tours.model import Tour
from app.tours.tour_file import MOST_BYTES, digest, load_tour, read_tour, tour_text
from tests.tours.tours import ARM, tour, tour_data

#: What UTF-8 can write: all that is not half a pair of surrogates.
characters = st.characters(codec="utf-8")
said = st.text(characters, max_size=40).filter(lambda text: bool(text.strip()) and any(not c.isspace() for c in text))
lines = st.text(st.characters(codec="utf-8", exclude_characters="\n\r"), max_size=40).filter(str.strip)
languages = st.sampled_from(["en", "fr", "no", "zh-hans"])
texts = st.dictionaries(languages, said, min_size=1, max_size=3)
titles = st.dictionaries(languages, lines, min_size=1, max_size=3)
words = st.dictionaries(
    languages, st.lists(st.sampled_from(["yes", "d'accord", "go on", "も"]), min_size=1, max_size=9)
)
numbers = st.floats(-900, 900)
points = st.tuples(numbers, numbers, st.floats(-9, 9)).map(list)
scalars = st.one_of(
    st.none(), st.booleans(), st.integers(), st.floats(allow_nan=False, allow_infinity=False), st.text()
)
places = st.from_regex(r"[a-z0-9-]{1,40}", fullmatch=True)
params = st.dictionaries(st.text(characters, max_size=9), scalars, max_size=3)
steps = st.fixed_dictionaries(
    {"say": texts},
    optional={
        "look": st.one_of(st.sampled_from(["visitors", "poster"]), points),
        "point": points,
        "show": st.fixed_dictionaries({"file": st.just("media/a b.mp4"), "alt": titles}),
        "gesture": st.fixed_dictionaries(
            {"class": st.just("Wave")},
            optional={"params": params},
        ),
        "wait": st.fixed_dictionaries({"at_most_s": st.floats(0.1, 600)}, optional={"words": words, "press": titles}),
    },
)
stops: st.SearchStrategy[dict[str, Any]] = st.fixed_dictionaries(
    {"id": st.from_regex(r"[a-z0-9][a-z0-9-]{0,39}", fullmatch=True), "place": places, "title": titles},
    optional={
        "do": st.lists(steps, max_size=2),
        "poster": said.map("x".__add__),
        "left_out": st.booleans(),
        "on_failure": st.just({"reach": {"then": "end"}}),
    },
)
tours: st.SearchStrategy[dict[str, Any]] = st.fixed_dictionaries(
    {"title": titles, "map": lines, "stops": st.lists(stops, max_size=3, unique_by=(lambda s: s["id"],))},
    optional={
        "home": places,
        "pace": st.fixed_dictionaries({"speed": st.floats(0.01, 1), "give_up_s": st.integers(5, 600)}),
        "schedule": st.just([{"days": ["mon", "fri"], "times": ["00:00", "12:30"]}]),
    },
)


def posters_differ(data: dict[str, Any]) -> bool:
    posters = [stop["poster"] for stop in data["stops"] if "poster" in stop]
    return len(set(posters)) == len(posters)


@settings(max_examples=50)
@given(tours.filter(posters_differ))
def test_there_and_back(data: dict[str, Any]) -> None:
    lab = tour(**data)
    text = tour_text(lab)
    back, _ = read_tour(text, "x.yaml")
    assert back == lab
    assert tour_text(back) == text
    assert digest(back) == digest(lab)
    # Others read the same in it.
    assert Tour.model_validate(yaml.safe_load(text)) == lab


def test_great_numbers_are_numbers_to_others_too() -> None:
    lab = tour(stops=[ARM | {"do": [{"gesture": {"class": "A", "params": {"a": 1e300, "b": 1e-9, "c": 2**70}}}]}])
    assert Tour.model_validate(yaml.safe_load(tour_text(lab))) == lab


def test_a_file_is_for_people_too() -> None:
    assert tour_text(tour(pace={"speed": 1, "slow_m": 2.25})).splitlines()[1:] == [
        "format: 1",
        'id: "lab-tour"',
        "title:",
        '  en: "The lab"',
        'languages: ["en"]',
        'map: "lab"',
        "pace:",
        "  speed: 1",
        "  slow_m: 2.25",
        "stops:",
        '- id: "arm"',
        '  place: "robotics-lab"',
        "  title:",
        '    en: "The arm"',
        '  poster: "HBBA:STOP/ROBOT-LAB1"',
        "  do:",
        "  - say:",
        '      en: "It yields when pushed."',
        "    point: [11.1, 9.1, 1.2]",
    ]


def test_a_digest_is_of_all_of_it() -> None:
    assert digest(tour()) == digest(tour(pace={})) != digest(tour(pace={"speed": 0.5}))


@pytest.mark.parametrize(
    ("change", "line", "words"),
    [
        (("slow_m: 2.25", "slow_m: 9"), 10, r"pace\.slow_m: should be less than wait_m \(4\), not 9"),
        (('place: "rob', 'plase: "rob'), 13, r"stops\[0\]\.plase: unknown key; did you mean 'place'\?"),
        (('en: "It', 'EN: "It'), 19, r"stops\[0\]\.do\[0\]\.say\.EN: should be a language's tag"),
        (("[11.1, 9.1, 1.2]", "[11.1, 9.1]"), 20, r"stops\[0\]\.do\[0\]\.point\[2\]: is missing"),
        (("format: 1", "format: 1\nformat: 1"), 3, "twice"),
    ],
)
def test_a_mistake_is_named_with_file_line_and_field(change: tuple[str, str], line: int, words: str) -> None:
    text = tour_text(tour(pace={"speed": 1, "slow_m": 2.25}))
    assert change[0] in text
    with pytest.raises(ConfigError, match=words) as refused:
        read_tour(text.replace(*change), "lab.yaml")
    assert (refused.value.file, refused.value.line) == ("lab.yaml", line)


def bomb() -> str:
    """Ten levels of ten aliases."""
    return "\n".join([f"a0: &a0 [{'x,' * 10}]", *(f"a{n}: &a{n} [{f'*a{n - 1},' * 10}]" for n in range(1, 10))])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "is no tour: it must be a mapping"),
        ("- 1", "is no tour: it must be a mapping"),
        ("{", "is not valid YAML"),
        ("#" * (MOST_BYTES + 1), "has more than 1 MB"),
        (bomb(), "names and values"),
        ("[" * 100, "nested too deeply"),
        ("a: &a [*a]", "a value contains itself"),
        ("a: 1", "a: unknown key; allowed: .*and 5 more mistakes"),
    ],
)
def test_what_is_no_tour_is_refused_in_a_sentence(text: str, words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        read_tour(text, "lab.yaml")


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda path: None, "cannot be read: No such file"),
        (Path.mkdir, "cannot be read: Is a directory"),
        (os.mkfifo, "is a pipe, no regular file"),
        (lambda path: path.write_bytes(b"\xff\xfe"), "is not a text file in UTF-8"),
        (lambda path: path.write_bytes(b"#" * (MOST_BYTES + 1)), "has more than 1 MB"),
    ],
)
def test_a_file_that_cannot_be_read_is_refused_in_a_sentence(
    make: Callable[[Path], object], words: str, tmp_path: Path
) -> None:
    make(tmp_path / "lab.yaml")
    with pytest.raises(ConfigError, match=words):
        load_tour(tmp_path / "lab.yaml")


def test_a_file_is_read(tmp_path: Path) -> None:
    (tmp_path / "lab.yaml").write_text(yaml.safe_dump(tour_data()), encoding="utf-8")
    found, document = load_tour(tmp_path / "lab.yaml")
    assert found == tour()
    assert document.line(("stops", 0, "place")) > 1
