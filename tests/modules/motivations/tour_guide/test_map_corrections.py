"""Small steps by which a map is corrected move nothing; all else does."""

from __future__ import annotations

from dataclasses import replace

import pytest

from app.maps.poster_places import Poster
from app.messages import Place
from app.modules.motivations.tour_guide.map_corrections import same_places, same_posters

DOOR, ARM = Place("door", "Door", 1.0, 2.0, 0.5), Place("arm", "Arm", 4.0, 0.0, 0.0)
POSTER = Poster(1, "P", 1.0, 4.0, None)


@pytest.mark.parametrize(
    ("now", "same"),
    [
        ((DOOR, ARM), True),
        ((replace(DOOR, x=1.09, y=1.95, heading=0.55), ARM), True),
        ((replace(DOOR, x=1.11), ARM), False),
        ((replace(DOOR, heading=0.7), ARM), False),
        ((replace(DOOR, name="Way out"), ARM), False),
        ((DOOR,), False),
        ((ARM, DOOR), False),
    ],
)
def test_places_are_the_same_within_a_decimetre(now: tuple[Place, ...], same: bool) -> None:
    assert same_places((DOOR, ARM), now) is same


@pytest.mark.parametrize(
    ("now", "same"),
    [
        ((POSTER,), True),
        ((replace(POSTER, x=1.05, y=3.95),), True),
        ((replace(POSTER, y=4.2),), False),
        ((replace(POSTER, number=2),), False),
        ((replace(POSTER, text="Q"),), False),
        ((), False),
    ],
)
def test_posters_are_the_same_within_a_decimetre(now: tuple[Poster, ...], same: bool) -> None:
    assert same_posters((POSTER,), now) is same
