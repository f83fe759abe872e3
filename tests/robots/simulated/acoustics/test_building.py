"""Ways of sound through a building: straight where one sees, by the door where not, and from the door's direction."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from app.robots.simulated.acoustics.auralization import SoundPath
from app.robots.simulated.acoustics.building import Building, Opening, build
from app.robots.simulated.acoustics.room import Shoebox
from app.robots.simulated.world_config import WorldConfig
from tests.robots.conftest import make_hall

WEST = Shoebox((0.0, 0.0, 0.0), (5.0, 4.0, 2.7), (0.5, 0.4))
EAST = Shoebox((5.0, 0.0, 0.0), (5.0, 4.0, 2.7), (0.5, 0.4))
DOOR = Opening((0, 1), (5.0, 2.5), (5.0, 3.5), 2.1)
TWO_ROOMS = Building([WEST, EAST], [DOOR])


def p(x: float, y: float, z: float = 1.5) -> NDArray[np.float64]:
    return np.array([x, y, z])


def whole_m(way: SoundPath, listener: NDArray[np.float64]) -> float:
    return way.before_m + float(np.linalg.norm(way.p_W - listener))


def test_within_a_room_sound_comes_straight() -> None:
    way = TWO_ROOMS.way(p(1, 1), p(4, 3))
    np.testing.assert_allclose(way.p_W, p(1, 1))
    assert (way.before_m, way.gains, way.late) == (0.0, (1.0, 1.0), 1.0)
    assert way.room == WEST


def test_through_the_open_door_it_comes_straight_too() -> None:
    source, listener = p(2, 3), p(8, 3)
    way = TWO_ROOMS.way(source, listener)
    assert way.room == EAST
    assert whole_m(way, listener) == pytest.approx(6.0)
    np.testing.assert_allclose(way.gains, 1.0, atol=1e-6)
    toward = way.p_W - listener
    np.testing.assert_allclose(toward / np.linalg.norm(toward), [-1.0, 0.0, 0.0], atol=1e-9)
    assert 0.0 < way.late < 0.7


def test_round_the_corner_it_comes_from_the_door_weaker_and_duller() -> None:
    source, listener = p(4.5, 0.5), p(6.0, 1.0)
    way = TWO_ROOMS.way(source, listener)
    edge = p(5.0, 2.6)
    expected = math.dist(source[:2], edge[:2]) + math.dist(edge[:2], listener[:2])
    assert whole_m(way, listener) == pytest.approx(expected, abs=0.02)
    low, high = way.gains
    assert high < low < 0.5
    bearing = math.atan2(way.p_W[1] - listener[1], way.p_W[0] - listener[0])
    assert bearing == pytest.approx(math.atan2(edge[1] - listener[1], edge[0] - listener[0]), abs=0.15)


def test_sound_does_not_pass_walls_without_a_door() -> None:
    way = Building([WEST, EAST]).way(p(1, 1), p(8, 3))
    assert max(way.gains) <= 1e-3
    assert way.late == 0.0


@settings(max_examples=60, deadline=None)
@given(st.tuples(st.floats(0.1, 4.9), st.floats(0.1, 3.9)), st.tuples(st.floats(5.1, 9.9), st.floats(0.1, 3.9)))
def test_no_way_is_shorter_than_the_straight_one_and_both_directions_are_alike(
    a: tuple[float, float], b: tuple[float, float]
) -> None:
    there, back = TWO_ROOMS.way(p(*a), p(*b)), TWO_ROOMS.way(p(*b), p(*a))
    assert whole_m(there, p(*b)) >= math.dist(a, b) - 1e-6
    assert whole_m(there, p(*b)) == pytest.approx(whole_m(back, p(*a)), abs=1e-6)
    np.testing.assert_allclose(there.gains, back.gains, atol=1e-9)
    assert EAST.contains(there.p_W)


def test_walking_through_the_door_changes_nothing_suddenly() -> None:
    """Loudness at the listener, step by step of 5 cm."""
    listener = p(8, 1)
    last = None
    for x in np.arange(3.0, 7.0, 0.05):
        way = TWO_ROOMS.way(p(float(x), 3.0), listener)
        level = 20 * math.log10(way.gains[0] / whole_m(way, listener))
        assert last is None or abs(level - last) < 1.0
        last = level


def test_the_laboratory_is_six_rooms_and_all_of_them_can_be_heard_from_one_another(lab: WorldConfig) -> None:
    building = build(lab)
    assert len(building.rooms) == 6
    assert len(building.openings) == 9
    middles = [np.array(room.corner) + np.array(room.size) / 2 for room in building.rooms]
    for a in middles:
        for b in middles:
            way = building.way(a, b)
            assert max(way.gains) > 1e-3
    assert building.room_at((11.0, 4.6)) == [r.name for r in lab.rooms].index("South corridor")


def test_a_world_without_rooms_is_one_that_rings_as_its_materials_do() -> None:
    hall = build(make_hall())
    assert len(hall.rooms) == 1
    assert hall.rooms[0].size == (20.0, 20.0, 2.7)
    low, high = hall.rooms[0].rt60_s
    assert 0.5 < high <= low <= 2.0
    carpeted = build(
        make_hall(floor="carpet", materials={"carpet": {"pattern": "carpet"}, "wall": {"pattern": "plaster"}})
    )
    assert carpeted.rooms[0].rt60_s[1] < high


def test_a_room_can_be_given_its_reverberation() -> None:
    world = make_hall(rooms=[{"name": "hall", "from": (0, 0), "to": (20, 20), "rt60_s": (0.9, 0.5)}])
    assert build(world).rooms[0].rt60_s == (0.9, 0.5)
