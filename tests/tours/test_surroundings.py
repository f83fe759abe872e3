"""What there is on the disk of what a tour refers to."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.maps.library import MapLibrary
from app.messages import Place
from app.speech.recognition import RecognizerConfig
from app.tours.surroundings import surroundings
from tests.maps.grids import room
from tests.tours.tours import ARM, tour

WORDS = {"wait": {"at_most_s": 5, "words": {"en": ["go on"], "fr": ["suite"]}}}
SHOW = {"show": {"file": "media/arm.jpg", "alt": {"en": "An arm"}}}


@pytest.fixture
def maps(tmp_path: Path) -> MapLibrary:
    return MapLibrary(tmp_path / "maps")


def test_places_are_those_of_the_map(maps: MapLibrary) -> None:
    lab = tour()
    before = surroundings(lab, maps=maps, folders=())
    assert "there is no map 'lab'" in before.no_map
    assert before.places is None
    maps.keep("lab", room())
    maps.keep_places("lab", [Place("dock", "The dock", 1.0, 2.0, 0.0)])
    around = surroundings(lab, maps=maps, folders=())
    assert (around.no_map, around.places) == ("", {"dock"})
    (maps.path("lab") / "places.yaml").write_text("places: 1", encoding="utf-8")
    assert "places.yaml:1: places: should be" in surroundings(lab, maps=maps, folders=()).no_map


def test_a_map_that_cannot_be_is_none(maps: MapLibrary) -> None:
    assert "a map's name has" in surroundings(tour(map="../lab"), maps=maps, folders=()).no_map


def test_media_may_be_in_either_folder(maps: MapLibrary, tmp_path: Path) -> None:
    lab, folders = tour(stops=[ARM | {"do": [SHOW]}]), [tmp_path / "own", tmp_path / "shipped"]
    assert surroundings(lab, maps=maps, folders=folders).missing == {"media/arm.jpg"}
    (tmp_path / "shipped" / "media").mkdir(parents=True)
    (tmp_path / "shipped" / "media" / "arm.jpg").touch()
    assert surroundings(lab, maps=maps, folders=folders).missing == set()


def test_words_are_looked_up_in_the_recognizers_dictionary(maps: MapLibrary, tmp_path: Path) -> None:
    (tmp_path / "words.dict").write_text("go G OW\ngo(2) G AH\nyes Y EH S\n", encoding="utf-8")
    lab = tour(stops=[ARM | {"do": [WORDS]}])
    recognizer = RecognizerConfig(path=tmp_path)
    assert surroundings(lab, maps=maps, folders=(), recognizer=recognizer).unknown_words == {
        "en": {"on"},
        "fr": {"suite"},
    }
    other = RecognizerConfig.model_validate({"class": "package.module:Other"})
    assert surroundings(lab, maps=maps, folders=(), recognizer=other).unknown_words is None
    (tmp_path / "words.dict").unlink()
    assert surroundings(lab, maps=maps, folders=(), recognizer=recognizer).unknown_words is None
