"""Expressions as poses: blends, variants, mouth, gaze, blinks and reactions, within what joints can do."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.link import JointLimits
from app.modules.behaviors.face.animation import BLINK_S, FaceAnimation, FaceState, Novelty
from app.modules.behaviors.face.expression import (
    CALM,
    EXPRESSIONS,
    JOINTS,
    REACTION_S,
    TURN_S,
    VARIANT_S,
    VARIANTS,
    Expression,
    alternation,
    expressed,
    reaction,
    with_blink,
    with_gaze,
    with_mouth,
)
from app.robots.config import load_robot_config
from app.speech.visemes import Viseme

ROBOT = load_robot_config(Path(__file__).parents[4] / "config" / "robots" / "irl1_tr.yaml")
LIMITS = ROBOT.groups["face"].joints
LIDS, UPPER, LOWER = (JOINTS.index(name) for name in ("eyelids_joint", "upper_lip_joint", "lower_lip_joint"))
LEFT_CORNER = JOINTS.index("left_mouth_corner_joint")

weights = st.fixed_dictionaries({}, optional={name: st.floats(0, 1) for name in EXPRESSIONS})
times = st.floats(0, 1e6)


def limits_of(name: str) -> JointLimits:
    return LIMITS[[joint.name for joint in LIMITS].index(name)]


def test_the_body_has_the_nine_joints_and_every_expression_is_within_their_positions() -> None:
    assert {joint.name for joint in LIMITS} == set(JOINTS)
    for pose in (CALM, *itertools.chain(*VARIANTS.values())):
        for name, position in zip(JOINTS, pose, strict=True):
            assert limits_of(name).lower <= position <= limits_of(name).upper, name


def test_variants_alternate_every_five_seconds_with_a_smooth_turn() -> None:
    assert alternation(TURN_S) == alternation(VARIANT_S) == 0
    assert alternation(VARIANT_S + TURN_S) == alternation(2 * VARIANT_S) == 1
    assert alternation(VARIANT_S + TURN_S / 2) == pytest.approx(0.5)
    np.testing.assert_allclose(expressed({"sad": 1}, 3.0), VARIANTS["sad"][0])
    np.testing.assert_allclose(expressed({"sad": 1}, 8.0), VARIANTS["sad"][1])
    steps = np.diff([alternation(0.01 * step) for step in range(3000)])
    assert np.abs(steps).max() <= 0.01 * 1.5 / TURN_S + 1e-9


@given(weights, times)
def test_a_blend_is_convex(blend: dict[Expression, float], time: float) -> None:
    corners = [CALM, *(expressed({name: 1}, time) for name in EXPRESSIONS)]
    total = max(1.0, sum(blend.values()))
    shares = [blend.get(name, 0.0) / total for name in EXPRESSIONS]
    shares = [1 - sum(shares), *shares]
    pose = expressed(blend, time)
    np.testing.assert_allclose(pose, np.average(corners, axis=0, weights=shares), atol=1e-9)
    assert (pose >= np.min(corners, axis=0) - 1e-9).all()
    assert (pose <= np.max(corners, axis=0) + 1e-9).all()


@given(st.floats(-1, 10))
def test_a_reaction_is_largest_at_once_and_dies_away(age_s: float) -> None:
    now, later = reaction(age_s), reaction(age_s + 0.1)
    if age_s < 0 or age_s >= REACTION_S:
        assert not now.any()
    if age_s >= 0:
        assert (np.abs(later) <= np.abs(now)).all()
    np.testing.assert_allclose(reaction(REACTION_S / 2), reaction(0.0) / 4)


def test_the_mouth_of_each_viseme_is_another_and_an_open_one_the_widest() -> None:
    opened = {viseme: with_mouth(CALM, viseme.value)[[UPPER, LOWER]].sum() for viseme in Viseme}
    assert max(opened, key=lambda viseme: opened[viseme]) is Viseme.OPEN
    assert opened[Viseme.CLOSED] == 0
    assert len({tuple(with_mouth(CALM, viseme.value)) for viseme in Viseme}) == len(Viseme)
    happy, sad = (with_mouth(expressed({name: 1}, 3.0), "open") for name in ("happy", "sad"))
    assert happy[LEFT_CORNER] > 0.3 > -0.2 > sad[LEFT_CORNER], "it is happy and sad while it speaks"


def test_eyes_look_where_they_are_to_and_lids_follow_them_down() -> None:
    gazing = with_gaze(CALM, 0.3, -0.2)
    assert tuple(gazing[[2, 3]]) == (0.3, -0.2)
    assert gazing[LIDS] > CALM[LIDS] == with_gaze(CALM, 0.3, 0.2)[LIDS]


def test_a_blink_closes_the_eyes_of_any_expression() -> None:
    for pose in (CALM, VARIANTS["sad"][1]):
        assert with_blink(pose, 1.0)[LIDS] == pytest.approx(limits_of("eyelids_joint").upper)
        assert (with_blink(pose, 0.0) == pose).all()


moments = st.lists(
    st.tuples(
        st.floats(0.0, 0.5),
        weights,
        st.none() | st.tuples(st.floats(-3, 3), st.floats(-2, 2)),
        st.none() | st.sampled_from([*(viseme.value for viseme in Viseme), "unknown"]),
        st.booleans(),
    ),
    max_size=40,
)


@given(moments, st.integers(0, 1000))
def test_whatever_is_asked_of_it_no_joint_moves_faster_or_further_than_it_can(
    script: list[tuple[float, dict[Expression, float], tuple[float, float] | None, str | None, bool]], seed: int
) -> None:
    limits = [limits_of(name) for name in JOINTS]
    animation, again = FaceAnimation(limits, seed), FaceAnimation(limits, seed)
    time, detected, before = 0.0, None, animation.pose
    for elapsed_s, blend, gaze, viseme, detects in script:
        time += elapsed_s
        detected = time if detects else detected
        state = FaceState(time, blend, gaze, viseme, detected)
        pose = animation.step(state)
        for joint, was, position in zip(limits, before, pose, strict=True):
            assert joint.lower <= position <= joint.upper
            assert abs(position - was) <= joint.velocity * elapsed_s + 1e-9
        assert (again.step(state) == pose).all(), "the same seed, the same face"
        before = pose


def lids(seed: int, seconds: float, rate_hz: float = 30.0) -> np.ndarray:
    animation = FaceAnimation([limits_of(name) for name in JOINTS], seed)
    poses = [animation.step(FaceState(step / rate_hz, {})) for step in range(round(seconds * rate_hz))]
    return np.array([pose[LIDS] for pose in poses])


def test_it_blinks_now_and_then_and_shortly() -> None:
    shut = lids(3, 120.0) > 0.9
    begins = np.flatnonzero(shut[1:] & ~shut[:-1]) / 30
    gaps = np.diff(begins)
    assert 20 <= len(begins) <= 60
    assert gaps.min() >= 2.0 - 0.05
    assert gaps.max() <= 6.0 + 0.05
    assert gaps.std() > 0.5, "at random"
    assert shut.sum() / 30 / len(begins) < BLINK_S
    assert (lids(3, 20.0) != lids(4, 20.0)).any(), "another seed, other moments"


def test_an_expression_comes_and_goes_smoothly() -> None:
    animation = FaceAnimation([limits_of(name) for name in JOINTS], 1)
    animation.step(FaceState(0.0, {}))
    corners = [animation.step(FaceState(0.1 * step, {"happy": 1.0}))[LEFT_CORNER] for step in range(1, 11)]
    assert corners == sorted(corners)
    assert corners[0] < corners[2] < corners[-1] == pytest.approx(VARIANTS["happy"][0][LEFT_CORNER])
    animation.step(FaceState(1.2, {}))
    assert animation.step(FaceState(2.0, {}))[LEFT_CORNER] == pytest.approx(CALM[LEFT_CORNER])


def test_what_was_seen_a_moment_ago_is_not_new() -> None:
    novelty = Novelty()
    assert not novelty.any_new([], 0.0)
    assert novelty.any_new([1], 0.0)
    assert not novelty.any_new([1], 1.0)
    assert novelty.any_new([1, 2], 2.0)
    assert not novelty.any_new([2], 3.0)
    assert novelty.any_new([1], 4.5), "it was gone for more than two seconds"
