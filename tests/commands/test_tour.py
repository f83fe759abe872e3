"""``hbba tour``: tours listed, checked with file, line and field, and printed."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from app import cli
from app.maps.library import MapLibrary
from app.messages import Place
from app.tours.model import Tour
from app.tours.tour_file import tour_text
from tests.maps.grids import room
from tests.tours.tours import ARM, tour


@pytest.fixture(autouse=True)
def folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Empty folders of tours and maps, the current one among them."""
    monkeypatch.setenv("HBBA_TOURS", str(tmp_path / "tours"))
    monkeypatch.setenv("HBBA_MAPS", str(tmp_path / "maps"))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write(file: Path, content: Tour) -> Path:
    file.parent.mkdir(exist_ok=True)
    file.write_text(tour_text(content), encoding="utf-8")
    return file


def test_tours_are_listed_with_those_of_the_program(folders: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write(folders / "tours" / "arm-tour.yaml", tour(id="arm-tour", title={"en": "The \x1b[31m arm"}))
    (folders / "tours" / "broken.yaml").write_text("format: 2", encoding="utf-8")
    assert cli.main(["tour"]) == 0
    head, *rows = capsys.readouterr().out.splitlines()
    assert head.split() == ["ID", "TITLE", "MAP", "STOPS"]
    assert [row.split()[0] for row in rows] == ["arm-tour", "broken", "lab-tour"]
    assert "\x1b" not in rows[0]
    assert "broken.yaml:1: " in rows[1]
    assert "comes with the program" in rows[2]
    assert cli.main(["tour", "list", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)["tours"]
    assert [(each["id"], each["shipped"], each["stops"]) for each in listed] == [
        ("arm-tour", False, 1),
        ("broken", False, 0),
        ("lab-tour", True, 3),
    ]


def test_problems_name_file_line_and_field(folders: Path, capsys: pytest.CaptureFixture[str]) -> None:
    maps = MapLibrary(folders / "maps")
    maps.keep("lab", room())
    maps.keep_places("lab", [Place("robotics-lab", "Robotics lab", 1.0, 2.0, 0.0)])
    show = {"say": {"en": "Look!"}, "show": {"file": "arm.jpg", "alt": {"en": "An arm"}}}
    good = write(folders / "here" / "good.yaml", tour(stops=[ARM | {"do": [show]}]))
    bad = write(folders / "tours" / "bad.yaml", tour(id="bad", home="dock"))
    worse = folders / "worse.yaml"
    worse.write_text(good.read_text(encoding="utf-8").replace("robotics-lab", "Robotics lab"), encoding="utf-8")

    assert cli.main(["tour", "check", str(good), "bad"]) == 1
    warning, verdict, error, refusal = capsys.readouterr().out.splitlines()
    assert warning.startswith(f"{good}:18: warning: stops[0].do[0].show.file: there is no file arm.jpg")
    assert verdict == f"{good}: can run here"
    assert error.startswith(f"{bad}:8: error: home: the map lab has no place 'dock'; allowed: robotics-lab")
    assert refusal == f"{bad}: cannot run here"
    (good.parent / "arm.jpg").touch()

    assert cli.main(["tour", "check", "--json", str(good), "bad", str(worse), "none"]) == 2
    out, err = capsys.readouterr()
    first, second, third, fourth = json.loads(out)["tours"]
    assert first == {"tour": str(good), "mistake": None, "problems": []}
    assert [(problem["field"], problem["severity"]) for problem in second["problems"]] == [("home", "error")]
    assert third["mistake"].startswith(f"{worse}:10: stops[0].place: should be a place's id")
    assert fourth["mistake"] == "there is no file none; there is no tour 'none'; there are: bad, lab-tour"
    assert err.splitlines() == [third["mistake"], fourth["mistake"]]


def test_the_schema_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["tour", "schema"]) == 0
    schema: dict[str, Any] = json.loads(capsys.readouterr().out)
    assert schema["$schema"].endswith("2020-12/schema")
    assert "stops" in schema["properties"]


def test_posters_are_printed(folders: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["tour", "posters", "lab-tour", "office", "--paper", "letter", "--language", "fr"]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "3  Le bureau: tour:office, read from 3.0 m",
        "lab-tour-posters.pdf: 1 page",
    ]
    assert (folders / "lab-tour-posters.pdf").read_bytes().startswith(b"%PDF-")
    for arguments, words in (
        (["lab-tour", "kitchen"], "the tour lab-tour has no stop 'kitchen'; there are: workshop"),
        (["lab-tour", "--out", str(folders)], "cannot be written: Is a directory"),
        (["lab-tour", "--out", "none/a.pdf"], "there is no such folder"),
    ):
        assert cli.main(["tour", "posters", *arguments]) == 2
        assert words in capsys.readouterr().err


def test_posters_are_reported_as_json(folders: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["tour", "posters", "lab-tour", "office", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["file"] == "lab-tour-posters.pdf"
    (poster,) = report["posters"]
    assert poster["code"] == "tour:office"
    assert poster["read_from_m"] > 1
