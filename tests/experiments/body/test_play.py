"""Plays: what is desired and when."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.base import paths
from app.base.errors import ConfigError
from app.experiments.body.play import load_play, moments
from app.program.config import load_configuration
from app.program.system import System

CLASSES = {"LookAt", "Say"}


def written(folder: Path, text: str) -> Path:
    """A play's file with ``text``."""
    path = folder / "play.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_moments_are_in_the_order_of_time_and_end_before_they_begin(tmp_path: Path) -> None:
    """What is desired beyond the play's end is left out."""
    play = load_play(
        written(
            tmp_path,
            "seconds: 10\nstop: 9\ncues:\n"
            "  - {at: 4, class: Say}\n"
            "  - {at: 1, until: 4, class: LookAt}\n"
            "  - {at: 11, class: Say}\n",
        ),
        CLASSES,
    )
    assert [(each.at, each.what, each.number) for each in moments(play)] == [
        (1, "begin", 1),
        (4, "end", 1),
        (4, "begin", 0),
        (9, "stop", 0),
    ]


@pytest.mark.parametrize(
    ("cue", "complaint"),
    [
        ("{at: 1, class: LokAt}", r"play.yaml:3.*no desire class 'LokAt'.*LookAt"),
        ("{at: 5, until: 5, class: Say}", r"play.yaml:3.*until \(5\) must be after at \(5\)"),
        ("{at: -1, class: Say}", r"play.yaml:3.*at"),
        ("{at: 1, class: Say, loud: true}", r"play.yaml:3.*loud"),
    ],
)
def test_a_bad_cue_is_refused_with_file_and_line(tmp_path: Path, cue: str, complaint: str) -> None:
    with pytest.raises(ConfigError, match=f"(?s){complaint}"):
        load_play(written(tmp_path, f"seconds: 10\ncues:\n  - {cue}\n"), CLASSES)


def test_the_play_of_the_lab_fits_the_program_of_the_lab() -> None:
    """Every desire of it is one that the program takes."""
    folder = paths.config_dir()
    system = System(load_configuration(folder / "lab.yaml"))
    play = load_play(folder / "experiments" / "body.yaml", set(system.classes))
    for cue in play.cues:
        system.classes[cue.cls].validated(cue.params)
