"""Tours for tests."""

from __future__ import annotations

from typing import Any

from app.tours.model import Tour

ARM: dict[str, Any] = {
    "id": "arm",
    "place": "robotics-lab",
    "title": {"en": "The arm"},
    "poster": "HBBA:STOP/ROBOT-LAB1",
    "do": [{"say": {"en": "It yields when pushed."}, "point": [11.1, 9.1, 1.2]}],
}


def tour_data(**more: Any) -> dict[str, Any]:
    """A tour as a file holds it, with ``more`` keys or other values."""
    return {
        "format": 1,
        "id": "lab-tour",
        "title": {"en": "The lab"},
        "languages": ["en"],
        "map": "lab",
        "stops": [ARM],
    } | more


def tour(**more: Any) -> Tour:
    """The same as a Tour."""
    return Tour.model_validate(tour_data(**more))
