"""Posters: the robot's own decoder reads the very page that is printed, and everything fits on it."""

from __future__ import annotations

import re
import zlib
from typing import Any

import cv2
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from numpy.typing import NDArray

from app.modules.perception.qr_codes import decode
from app.tours.paper import PAPERS, Paper
from app.tours.posters import (
    CODE_MM,
    HANG,
    NoPosters,
    Poster,
    is_drawable,
    modules_of,
    page,
    posters_of,
    posters_pdf,
    reach_m,
)
from tests.tours.tours import ARM, tour

ROBOT_LAB = Poster("HBBA:STOP/ROBOT-LAB1", "The arm", 1, "en")
LONG = Poster("HBBA:SAY/FR/" + "é" * 144, "Ceci est un titre de cent signes, " * 3, 99, "fr")

WIDE = Poster("X" * 300, "W" * 100, 100, "nl")


def pixels(poster: Poster, paper: Paper, dots_per_mm: float = 2.0) -> NDArray[np.uint8]:
    """The page as a printer draws it, grey."""
    canvas = FigureCanvasAgg(page(poster, paper))
    canvas.figure.set_dpi(dots_per_mm * 25.4)
    canvas.draw()
    return np.asarray(cv2.cvtColor(np.asarray(canvas.buffer_rgba()), cv2.COLOR_RGBA2GRAY), np.uint8)


@pytest.mark.parametrize("paper", PAPERS)
@pytest.mark.parametrize("poster", [ROBOT_LAB, LONG], ids=["short", "long"])
def test_the_robot_reads_what_is_printed(poster: Poster, paper: Paper) -> None:
    drawn = pixels(poster, paper)
    ((text, corners),) = decode(drawn)
    assert text == poster.code
    # As wide as it should be, and its middle is the page's, which hangs 1.25 m high.
    width, height = PAPERS[paper]
    assert np.ptp(corners, axis=0) / 2 == pytest.approx([CODE_MM, CODE_MM], abs=2)
    assert corners.mean(axis=0) / 2 == pytest.approx([width / 2, height / 2], abs=1)


@pytest.mark.parametrize("paper", PAPERS)
@pytest.mark.parametrize("poster", [ROBOT_LAB, LONG, WIDE], ids=["short", "long", "wide"])
def test_nothing_is_cut_off_or_written_over_the_code(poster: Poster, paper: Paper) -> None:
    ink = pixels(poster, paper) < 128
    border = 2 * 5
    inside = ink[border:-border, border:-border]
    assert inside.sum() == ink.sum(), "5 mm at the paper's edges stay white: printers do not reach them"
    height = PAPERS[paper][1]
    above, below = round(height - CODE_MM), round(height + CODE_MM)
    for quiet in (ink[above - 12 : above - 2], ink[below + 2 : below + 12]):
        assert not quiet.any(), "5 mm around the code stay white"
    assert ink[:above].any()
    assert ink[below:].any()


def test_the_modules_are_those_of_level_m_with_the_least_there_can_be() -> None:
    assert modules_of("HBBA:STOP/ROBOT-LAB1").shape == (21, 21)
    assert reach_m("HBBA:STOP/ROBOT-LAB1") == pytest.approx(3.0)
    assert modules_of("x" * 26).shape == (25, 25)
    assert reach_m("x" * 26) == pytest.approx(2.52)


def test_a_pdf_has_a_page_for_each_poster_and_is_the_same_each_time() -> None:
    pdf = posters_pdf([ROBOT_LAB, LONG], "letter", "The lab")
    assert pdf.startswith(b"%PDF-")
    assert len(re.findall(rb"/Type /Page\b", pdf)) == 2
    boxes = [[float(n) for n in box.split()] for box in re.findall(rb"/MediaBox \[([^\]]*)\]", pdf)]
    assert boxes == [pytest.approx([0, 0, 612, 792], abs=0.1)] * 2
    assert pdf == posters_pdf([ROBOT_LAB, LONG], "letter", "The lab")
    drawn = b"".join(zlib.decompress(part) for part in re.findall(rb"stream\r?\n(x.*?)\r?\nendstream", pdf, re.DOTALL))
    runs = sum(int(np.count_nonzero(np.diff(row.astype(int), prepend=0) == 1)) for row in modules_of(ROBOT_LAB.code))
    assert drawn.count(b" m\n") >= runs, "modules are drawn as outlines"


def test_titles_are_in_the_language_that_is_asked_for() -> None:
    lab = tour(languages=["en", "fr"], stops=[ARM | {"title": {"en": "The arm", "fr": "Le bras"}}])
    assert posters_of(lab) == (ROBOT_LAB,)
    assert posters_of(lab, "fr") == (Poster("HBBA:STOP/ROBOT-LAB1", "Le bras", 1, "fr"),)
    assert posters_of(lab, "de") == (ROBOT_LAB,)


def test_numbers_are_those_of_the_stops() -> None:
    stops = [ARM | {"id": "a", "poster": None}, ARM | {"id": "b"}, ARM | {"id": "c", "poster": "x"}]
    lab = tour(stops=stops)
    assert [poster.number for poster in posters_of(lab)] == [2, 3]
    assert [poster.number for poster in posters_of(lab, stops=["c"])] == [3]


@pytest.mark.parametrize(
    ("stops", "wanted", "words"),
    [
        ([ARM], ["leg"], "the tour lab-tour has no stop 'leg'; there are: arm"),
        ([ARM | {"poster": None}], None, "the stop arm does not have a text for its code: .* HBBA:STOP/ARM"),
        ([], None, "none of the stops of lab-tour has a text"),
    ],
)
def test_where_there_is_nothing_to_print_it_says_why(stops: list[Any], wanted: list[str] | None, words: str) -> None:
    with pytest.raises(NoPosters, match=words):
        posters_of(tour(stops=stops), stops=wanted)


def test_a_title_that_the_font_does_not_have_is_replaced_by_the_id() -> None:
    assert is_drawable("Œuvre à 5 € · Ω Ж")
    assert not is_drawable("漢字")
    assert not is_drawable("مرحبا")
    (poster,) = posters_of(tour(stops=[ARM | {"title": {"en": "漢字"}}]))
    assert poster.title == "arm"
    pixels(Poster("漢字$x$", "$\\frac{1$", 1, "xx"), "a4")


def test_what_is_written_can_be_drawn() -> None:
    assert all(is_drawable(words) and len(words) < 60 for words in HANG.values())
