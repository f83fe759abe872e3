"""From what is perceived of people to what is drawn."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from viser.transforms import SO3

from app.console.view.marks import (
    FADE_S,
    FLASH_S,
    GREY,
    MOST_ARROWS,
    MOST_FACES,
    ORANGE,
    RED,
    arrow_marks,
    assigned,
    face_marks,
    flash_mark,
    force_marks,
)
from app.messages import ExternalForce, ExternalForces, LoudNoise, PlacedFace, PlacedPercepts, PlacedSound

NOW = 100.0


def heard(track: int = 1, v_O: tuple[float, float, float] = (1.0, 0.0, 0.0)) -> PlacedSound:
    """A voice 2 m away."""
    return PlacedSound(
        track=track,
        stamp=NOW,
        azimuth=0.0,
        elevation=0.0,
        panorama=None,
        range_m=2.0,
        range_sigma_m=0.3,
        x=2.1,
        y=0.2,
        z=0.5,
        p_OA=(0.1, 0.2, 0.5),
        v_O=v_O,
        power=0.5,
        level_db=-30.0,
        active=True,
        last_active=NOW,
        speech=0.9,
    )


def seen(track: int = 1, *, camera: str = "panorama", range_m: float = 2.0, sigma_m: float = 0.2) -> PlacedFace:
    """A face to the left of the origin, with the robot towards -y of it."""
    return PlacedFace(
        track=track,
        camera=camera,
        stamp=NOW,
        azimuth=0.0,
        elevation=0.0,
        panorama=None,
        range_m=range_m,
        range_sigma_m=sigma_m,
        x=0.0,
        y=range_m,
        z=1.6,
        towards_O=-math.pi / 2,
        score=0.9,
        box=(0.0, 0.0, 1.0, 1.0),
        image=(640, 480),
    )


unit_vectors = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: math.hypot(*v) > 0.1)


@given(unit_vectors)
def test_an_arrow_points_from_the_microphones_towards_its_sound(v: tuple[float, float, float]) -> None:
    direction = np.array(v) / np.linalg.norm(v)
    arrow = arrow_marks(PlacedPercepts(NOW, sounds=(heard(v_O=tuple(direction.tolist())),)))[1]
    drawn = SO3(np.array(arrow.wxyz)).as_matrix()[:, 0]
    assert math.degrees(math.acos(min(1.0, float(drawn @ direction)))) < 0.5
    np.testing.assert_allclose(np.subtract(arrow.head, arrow.position), arrow.length * direction, atol=0.011)
    assert arrow.position == (0.1, 0.2, 0.5)


def test_louder_is_longer_and_colour_marks_a_voice() -> None:
    def arrow(**changes: Any) -> object:
        return arrow_marks(PlacedPercepts(NOW, sounds=(replace(heard(), **changes),)))[1]

    lengths = [arrow(level_db=level).length for level in (-90.0, -60.0, -40.0, -20.0, 0.0)]  # type: ignore[attr-defined]
    assert lengths == sorted(lengths)
    assert 0.3 <= lengths[0] < lengths[2] < lengths[-1] <= 1.6
    assert arrow(speech=0.9).color == RED  # type: ignore[attr-defined]
    assert arrow(speech=0.1).color == ORANGE  # type: ignore[attr-defined]
    assert arrow(speech=None).color == GREY  # type: ignore[attr-defined]
    assert arrow().text == "voice · 2.0 m"  # type: ignore[attr-defined]
    assert arrow(range_sigma_m=3.0).text == "voice"  # type: ignore[attr-defined]
    assert arrow(range_m=None, speech=0.0).text == "sound"  # type: ignore[attr-defined]


def test_an_arrow_fades_out_after_its_sound() -> None:
    silent = replace(heard(), active=False, last_active=NOW)
    opacities = []
    for late in np.linspace(0.0, FADE_S + 0.2, 20):
        marks = arrow_marks(PlacedPercepts(NOW + late, sounds=(silent,)))
        opacities.append(marks[1].opacity if marks else 0.0)
    assert opacities == sorted(opacities, reverse=True)
    assert opacities[0] == 0.9
    assert opacities[-1] == 0.0
    assert arrow_marks(PlacedPercepts(NOW + 1.0, sounds=(heard(),)))[1].opacity == 0.9


def test_what_is_not_placed_yet_is_not_drawn() -> None:
    nowhere = replace(heard(), p_OA=None, v_O=None, x=None, y=None, z=None)
    assert arrow_marks(PlacedPercepts(NOW, sounds=(nowhere,))) == {}
    assert face_marks(PlacedPercepts(NOW, faces=(replace(seen(), x=None, y=None, z=None, towards_O=None),))) == {}


def test_only_the_strongest_sounds_are_drawn() -> None:
    sounds = tuple(replace(heard(track), power=0.1 * track) for track in range(1, 7))
    assert set(arrow_marks(PlacedPercepts(NOW, sounds=sounds))) == {3, 4, 5, 6}
    sounds = (replace(heard(9), power=0.0, last_active=NOW), *[replace(s, active=False) for s in sounds])
    assert 9 in arrow_marks(PlacedPercepts(NOW, sounds=sounds))
    assert MOST_ARROWS == 4


def test_a_face_is_drawn_once_and_looks_at_the_robot() -> None:
    faces = (seen(1, camera="panorama", range_m=2.2, sigma_m=0.4), seen(1, camera="kinect", range_m=2.0, sigma_m=0.02))
    (mark,) = face_marks(PlacedPercepts(NOW, faces=faces)).values()
    assert mark.text == "Person 1 · 2.0 m"
    assert mark.position == (0.0, 2.0, 1.6)
    np.testing.assert_allclose(SO3(np.array(mark.wxyz)).as_matrix()[:, 0], [0.0, -1.0, 0.0], atol=2e-3)


def test_only_the_nearest_faces_are_drawn() -> None:
    faces = tuple(seen(track, range_m=float(track)) for track in range(1, 12))
    assert set(face_marks(PlacedPercepts(NOW, faces=faces))) == set(range(1, MOST_FACES + 1))


def test_a_noise_flashes() -> None:
    perceived = PlacedPercepts(NOW, noises=(LoudNoise(NOW - 1.5, 30.0, -10.0), LoudNoise(NOW - 0.1, 30.0, -10.0)))
    first = flash_mark(perceived)
    assert first is not None
    later = flash_mark(replace(perceived, stamp=NOW + 0.4))
    assert later is not None
    assert later.scale > first.scale
    assert later.opacity < first.opacity
    assert flash_mark(replace(perceived, stamp=NOW + FLASH_S)) is None
    assert flash_mark(PlacedPercepts(NOW)) is None


@given(st.lists(st.sets(st.integers(1, 12), max_size=4), max_size=30))
def test_a_track_keeps_its_place_and_no_two_share_one(story: list[set[int]]) -> None:
    before: dict[int, int] = {}
    for tracks in story:
        now = assigned(before, tracks, 4)
        assert now.keys() == tracks
        assert len(set(now.values())) == len(tracks)
        assert set(now.values()) <= set(range(4))
        assert all(now[track] == before[track] for track in tracks & before.keys())
        before = now


@pytest.mark.parametrize("late_s", [0.0, 0.01, 0.02])
def test_what_no_eye_could_see_is_the_same_mark(late_s: float) -> None:
    sound = replace(heard(), p_OA=(0.1001, 0.2, 0.5), v_O=(1.0, 1e-4, 0.0), level_db=-30.1)
    before = arrow_marks(PlacedPercepts(NOW, sounds=(heard(),)))
    assert arrow_marks(PlacedPercepts(NOW + late_s, sounds=(sound,))) == before


def test_a_force_is_an_arrow_from_the_hand_the_way_it_pushes() -> None:
    pushed = ExternalForce("left_hand_link", (0.3, 0.2, 0.6), (-10.0, 0.0, 0.0))
    lifted = ExternalForce("right_hand_link", (0.3, -0.2, 0.6), (0.0, 0.0, 200.0))
    arrows = force_marks(ExternalForces(NOW, (pushed, lifted)))
    assert (arrows[0].position, arrows[0].text) == ((0.3, 0.2, 0.6), "10 N")
    along = SO3(np.array(arrows[0].wxyz)).apply(np.array([arrows[0].length, 0.0, 0.0]))
    assert np.allclose(along, [-0.3, 0.0, 0.0], atol=1e-2)
    assert np.allclose(arrows[0].head, (0.0, 0.2, 0.6), atol=1e-2)
    assert arrows[1].length == 1.0, "at most a metre"
    assert force_marks(ExternalForces(NOW, ())) == {}
    assert force_marks(None) == {}
