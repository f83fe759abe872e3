"""Posters of a tour's stops as PDF, one a page, made without a network: code, title, number and how high to hang it.

The code is 180 mm wide on either paper, at level M: more correction needs more modules, which shortens its reach.
Blocking: a page takes some hundredths of a second.
"""

from __future__ import annotations

import io
import textwrap
import unicodedata
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import segno
from matplotlib import font_manager
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from matplotlib.ft2font import FT2Font
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline
from numpy.typing import NDArray

from app.tours.model import Stop, Tour
from app.tours.paper import PAPERS, Paper
from app.tours.values import text_in

CODE_MM: Final = 180.0
#: A Kinect of 640 pixels reads a code, face on, from so many times the width of a module.
REACH: Final = 350

#: "Hang it 1.25 m high", measured at the middle of the code.
HANG: Final[Mapping[str, str]] = {
    "de": "1,25 m hoch aufhängen (Mitte des Codes)",
    "en": "Hang it 1.25 m high (middle of the code)",
    "es": "Cuélguelo a 1,25 m de altura (centro del código)",
    "fr": "À accrocher à 1,25 m de haut (milieu du code)",
    "it": "Appendere a 1,25 m di altezza (centro del codice)",
    "nl": "Op 1,25 m hoogte ophangen (midden van de code)",
    "pt": "Pendurar a 1,25 m de altura (meio do código)",
}
_FROM = {
    "de": "lesbar aus {:.1f} m",
    "en": "read from {:.1f} m",
    "es": "legible a {:.1f} m",
    "fr": "lisible à {:.1f} m",
    "it": "leggibile da {:.1f} m",
    "nl": "leesbaar vanaf {:.1f} m",
    "pt": "legível a {:.1f} m",
}

_FONT = "DejaVu Sans"
_INCH_MM, _POINTS = 25.4, 72
_POINT_MM = _INCH_MM / _POINTS
#: Printers do not reach a paper's edges.
_MARGIN_MM = 10.0
#: Characters in a line of the title, and the size of its letters (points), for one line, two, and more.
_TITLES = ((26, 30), (32, 24), (44, 16))
#: Longest part of a code's text that is printed below it.
_LONGEST_LINE = 70


class NoPosters(ValueError):
    """There is nothing to print; the message is one sentence with the reason."""


@dataclass(frozen=True, slots=True)
class Poster:
    """What one page shows; ``language`` is that of ``title``."""

    code: str
    title: str
    number: int
    language: str


def posters_of(tour: Tour, language: str | None = None, stops: Collection[str] | None = None) -> tuple[Poster, ...]:
    """The posters of ``tour`` in ``language`` (None: its first), of all stops or of those whose ids are in ``stops``.

    Stops without a poster's text have none. Raises NoPosters where that leaves nothing, and for other ids.
    """
    first = tour.languages[0]
    language = language or first
    if stops is not None and (unknown := sorted(set(stops) - {stop.id for stop in tour.stops})):
        known = ", ".join(stop.id for stop in tour.stops) or "none"
        raise NoPosters(f"the tour {tour.id} has no stop {unknown[0]!r}; there are: {known}")
    wanted = [(n, stop) for n, stop in enumerate(tour.stops, 1) if stops is None or stop.id in stops]
    found = tuple(_poster(stop, stop.poster, number, language, first) for number, stop in wanted if stop.poster)
    if not found:
        of = f"none of the stops of {tour.id} has" if len(wanted) != 1 else f"the stop {wanted[0][1].id} does not have"
        raise NoPosters(f"{of} a text for its code: set its poster, for example to HBBA:STOP/{_example(tour)}")
    return found


def posters_pdf(posters: Sequence[Poster], paper: Paper = "a4", title: str = "") -> bytes:
    """A PDF with a page for each of ``posters``; the same posters give the same bytes."""
    file = io.BytesIO()
    about = {"Title": title, "Creator": "HBBA", "Producer": None, "CreationDate": None}
    with PdfPages(file, metadata=about) as pages:
        for poster in posters:
            pages.savefig(page(poster, paper))
    return file.getvalue()


def page(poster: Poster, paper: Paper) -> Figure:
    """One page, as wide and high as the paper."""
    width, height = PAPERS[paper]
    figure = Figure(figsize=(width / _INCH_MM, height / _INCH_MM))
    axes: Any = figure.add_axes((0, 0, 1, 1), xlim=(0, width), ylim=(0, height))
    axes.axis("off")
    modules = modules_of(poster.code)
    left, bottom = (width - CODE_MM) / 2, (height - CODE_MM) / 2
    outline = _outline(modules, CODE_MM / len(modules), left, bottom)
    axes.add_patch(PathPatch(outline, facecolor="black", edgecolor="none", linewidth=0, antialiased=False))
    lines, size = _title(poster.title, (width - 2 * _MARGIN_MM) / _POINT_MM)
    above, below = (height + CODE_MM) / 2, bottom
    text = {"ha": "center", "va": "center", "family": _FONT, "parse_math": False}
    axes.text(width / 2, (above + height) / 2, "\n".join(lines), size=size, weight="bold", **text)
    axes.text(width / 2, below * 0.72, str(poster.number), size=34, weight="bold", **text)
    language = poster.language.partition("-")[0]
    hang, reach = HANG.get(language, HANG["en"]), _FROM.get(language, _FROM["en"]).format(reach_m(poster.code))
    axes.text(width / 2, below * 0.42, hang, size=15, **text)
    code = poster.code if len(poster.code) <= _LONGEST_LINE else poster.code[: _LONGEST_LINE - 1] + "…"
    shown = code if is_drawable(code) else ""
    axes.text(width / 2, below * 0.24, " · ".join(filter(None, (shown, reach))), size=9, color="0.3", **text)
    return figure


def modules_of(code: str) -> NDArray[np.bool_]:
    """The modules (N, N) of the code with the text ``code``, True where black, without the quiet zone."""
    return np.array([[bool(cell) for cell in row] for row in _qr(code).matrix])


def reach_m(code: str) -> float:
    """From how far (m) the robot reads a poster with this text, face on."""
    modules: int = _qr(code).symbol_size(border=0)[0]
    return REACH * CODE_MM / 1000 / modules


def is_drawable(text: str) -> bool:
    """Whether the font that comes with matplotlib has all characters of ``text``, one after another from the left."""
    return all(
        ord(character) in _glyphs() and unicodedata.bidirectional(character) not in ("R", "AL", "AN")
        for character in text
    )


def _poster(stop: Stop, code: str, number: int, language: str, fallback: str) -> Poster:
    used = language if language in stop.title else fallback
    title = text_in(stop.title, language, fallback)
    return Poster(code, title if is_drawable(title) else stop.id, number, used)


def _example(tour: Tour) -> str:
    return tour.stops[0].id.upper() if tour.stops else "ARM"


def _qr(code: str) -> Any:
    # Bytes of Latin-1, which segno prefers, are taken for Chinese where there are many accents in a row.
    return segno.make(code, error="m", micro=False, boost_error=False, encoding=None if code.isascii() else "utf-8")


def _glyphs() -> Collection[int]:
    return FT2Font(font_manager.findfont(_FONT)).get_charmap()


def _title(title: str, width: float) -> tuple[list[str], float]:
    """Lines, and the size of their letters, so that none is wider than ``width`` (both in points)."""
    wrapped = [(textwrap.wrap(title, length), size) for length, size in _TITLES]
    lines, size = next((each for most, each in enumerate(wrapped, 1) if len(each[0]) <= most), wrapped[-1])
    font = FT2Font(font_manager.findfont(font_manager.FontProperties(family=_FONT, weight="bold")))
    font.set_size(size, _POINTS)
    widest = 0.0
    for line in lines:
        font.set_text(line)
        widest = max(widest, font.get_width_height()[0] / 64)
    return lines, size * min(1.0, width / max(widest, 1.0))


def _outline(modules: NDArray[np.bool_], side: float, left: float, bottom: float) -> Outline:
    """The black of ``modules`` as one outline: a rectangle for each run in a row."""
    corners: list[tuple[float, float]] = []
    for row, cells in enumerate(modules):
        edges = np.flatnonzero(np.diff(np.concatenate(([False], cells, [False])).astype(np.int8)))
        top = bottom + (len(modules) - row) * side
        for begin, end in edges.reshape(-1, 2).tolist():
            x0, x1 = left + begin * side, left + end * side
            corners += [(x0, top - side), (x1, top - side), (x1, top), (x0, top), (x0, top - side)]
    codes = [Outline.MOVETO, Outline.LINETO, Outline.LINETO, Outline.LINETO, Outline.CLOSEPOLY]
    return Outline(corners, codes * (len(corners) // 5))
