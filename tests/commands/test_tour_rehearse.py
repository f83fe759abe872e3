"""``hbba tour rehearse``: what it refuses before it plays, and how it says what was found."""

from __future__ import annotations

from pathlib import Path

import pytest

from app import cli
from app.commands.tour_rehearse import report
from app.maps.library import MapLibrary
from app.messages import Place
from app.rehearsal.result import Rehearsal, RehearsalProblem, RehearsedState, Subtitle
from app.tours.tour_file import tour_text
from tests.maps.grids import room
from tests.tours.tours import tour


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A tour on the map ``lab``, which is not there yet."""
    monkeypatch.setenv("HBBA_TOURS", str(tmp_path / "tours"))
    monkeypatch.setenv("HBBA_MAPS", str(tmp_path / "maps"))
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "arm-tour.yaml"
    file.write_text(tour_text(tour(id="arm-tour", languages=["en", "fr"])), encoding="utf-8")
    return file


def test_what_cannot_be_rehearsed_is_refused_in_one_sentence(
    file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["tour", "rehearse", str(file), "--language", "de"]) == 2
    assert "arm-tour is not in 'de'; there are: en, fr" in capsys.readouterr().err
    assert cli.main(["tour", "rehearse", str(file)]) == 2
    assert "there is no map 'lab'" in capsys.readouterr().err
    maps = MapLibrary(tmp_path / "maps")
    maps.keep("lab", room())
    maps.keep_places("lab", [Place("elsewhere", "Elsewhere", 1.0, 2.0, 0.0)])
    assert cli.main(["tour", "rehearse", str(file)]) == 2
    assert "none of the places of the tour arm-tour is on the map lab" in capsys.readouterr().err
    assert cli.main(["tour", "rehearse", "no-tour"]) == 2
    assert "there is no file no-tour" in capsys.readouterr().err


def test_states_sentences_and_problems_are_said_in_order() -> None:
    found = Rehearsal(
        "arm-tour",
        "en",
        outcome="the tour is over",
        duration_s=75.5,
        driven_m=12.3,
        stops=("arm",),
        states=(
            RehearsedState(0.0, "leading", "arm", ""),
            RehearsedState(20.0, "presenting", "arm", ""),
            RehearsedState(75.5, "going_home", "", "the last stop is over"),
        ),
        subtitles=(Subtitle(21.0, 24.0, "It yields\nwhen pushed.", "en"),),
        path=(),
        problems=(
            RehearsalProblem("warning", "arm", "stops[0].do[0].say has no text in fr: en is said"),
            RehearsalProblem("error", "arm", "arm: not reached", 61.0),
        ),
    )
    assert report(found) == [
        "0:00  leading (arm)",
        "0:20  presenting (arm)",
        "0:21      “It yields when pushed.”",
        "1:15  going home: the last stop is over",
        "warning: stops[0].do[0].say has no text in fr: en is said",
        "error: 1:01: arm: not reached",
        "arm-tour: 1:15 min, 12 m, stops presented: 1; the tour is over",
    ]
    assert not found.can_be_led
