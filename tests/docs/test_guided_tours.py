"""docs/guided-tours.md: its example is a tour, its tables say what the program does."""

from __future__ import annotations

import re
from pathlib import Path
from typing import get_args

from app.base import paths
from app.messages import TourButton, TourState
from app.modules.behaviors.face.expression import EXPRESSIONS
from app.tours.checks import Surroundings, check
from app.tours.codes import parse
from app.tours.model import MOST_STEPS, MOST_STOPS, Stop, Tour
from app.tours.posters import modules_of, reach_m
from app.tours.steps import Step
from app.tours.tour_file import MOST_BYTES, load_tour, read_tour
from app.tours.values import LONGEST_CODE, MOST_LANGUAGES

PAGE = (Path(__file__).parents[2] / "docs" / "guided-tours.md").read_text("utf-8")
(EXAMPLE,) = re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL)


def rows(heading: str) -> list[list[str]]:
    """The cells of the rows of the table under ``heading``, without its head."""
    lines = re.findall(r"^\|.*\|$", PAGE[PAGE.index(f"# {heading}\n") :].split("\n#")[0], re.MULTILINE)
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


def test_the_example_is_a_tour_that_lacks_nothing_of_itself() -> None:
    tour, _ = read_tour(EXAMPLE, "example")
    assert check(tour, Surroundings()) == ()
    shipped, _ = load_tour(paths.config_dir() / "tours" / "lab-tour.yaml")
    assert check(shipped, Surroundings()) == ()


def test_every_key_is_explained() -> None:
    explained = {name for row in rows("The file") for name in re.findall(r"`(\w+)`", row[0])}
    assert explained <= {*Tour.model_fields, *Stop.model_fields}
    needed = {"format", "id", "title", "languages", "stops", "do", "poster"}
    assert {*Tour.model_fields, *Stop.model_fields} - explained == needed
    assert [row[0].strip("`") for row in rows("Steps")] == list(Step.model_fields)
    assert {*EXPRESSIONS, "calm"} == set(re.findall(r"`(\w+)`", next(r[1] for r in rows("Steps") if "expr" in r[0])))


def test_figures_are_the_programs() -> None:
    texts = ["HBBA:STOP/ROBOT-LAB1", "x" * 26, "x" * 60, "x" * LONGEST_CODE]
    expected = [[str(len(modules_of(text))), f"{reach_m(text):.1f} m"] for text in texts]
    assert [row[1:] for row in rows("Posters")] == expected
    limits = f"{MOST_BYTES // 10**6} MB, {MOST_STOPS} stops, {MOST_STEPS} steps each, {MOST_LANGUAGES} languages"
    assert limits in PAGE
    assert f"up to {LONGEST_CODE} bytes" in PAGE


def test_the_codes_shown_are_codes() -> None:
    codes = [row[0].strip("`") for row in rows("Codes that carry their interaction")]
    assert len(codes) == 3
    assert [str(parse(code)) for code in codes] == codes


def test_every_state_and_button_is_described() -> None:
    for heading, described in (("The guide", TourState), ("Leading a tour", TourButton)):
        words = {word for first, *_ in rows(heading) for word in re.findall(r"`(\w+)`", first)}
        assert words == set(get_args(described)), heading
