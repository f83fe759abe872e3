"""The whole program follows a person who walks 10 m with a pause, on a kept map, in virtual time."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from tests.scenery.followed_walk import followed, walk

pytestmark = pytest.mark.slow


def test_it_keeps_its_distance_on_a_walk_with_turns_and_a_pause_and_touches_nothing(tmp_path: Path) -> None:
    moments = followed(tmp_path, walk(0.3, (3.0, 0.0), (3.0, 3.2), 8.0, (7.0, 3.2), (7.0, 1.5), 6.0), 58.0)
    walked = [moment for moment in moments if moment.at_s >= 5.0]
    assert math.dist((walked[-1].person.x, walked[-1].person.y), (7.0, 1.5)) < 0.1, "they are there"
    assert all(abs(moment.distance_m - 1.2) <= 0.4 for moment in walked), [moment.distance_m for moment in walked]
    assert walked[-1].turned_rad < 0.2
    assert walked[-1].touches == 0
    assert walked[-1].driven_m > 6
    assert walked[-1].outcome == "done"
