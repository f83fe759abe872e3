"""Information carried along edges: against what many small motions come to."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from app.base.geometry import Pose2
from app.modules.perception.slam.information import (
    Information,
    along,
    chained,
    diagonal,
    matrix,
    packed,
    seen_from,
    variance_m2,
)

near = st.floats(-5.0, 5.0)
poses = st.builds(Pose2, near, near, st.floats(-math.pi, math.pi))
sure = st.floats(1e2, 1e5)


@st.composite
def informations(draw: st.DrawFn) -> Information:
    return packed(along(matrix(diagonal(draw(sure), draw(sure), draw(sure))), draw(st.floats(-math.pi, math.pi))))


def spread(samples: list[Pose2]) -> np.ndarray:
    return np.cov(np.array([(p.x, p.y, p.theta) for p in samples]).T)


@given(informations(), poses)
def test_seen_from_the_other_end_and_back_it_is_the_same(information: Information, X_ab: Pose2) -> None:
    back = seen_from(seen_from(information, X_ab), X_ab.inverse())
    assert np.allclose(back, information, rtol=1e-6, atol=1e-3)


@settings(max_examples=3, deadline=None)
@given(informations(), informations(), poses, poses)
def test_a_chain_is_as_unsure_as_its_samples(one: Information, other: Information, X_ab: Pose2, X_bc: Pose2) -> None:
    rng = np.random.default_rng(1)
    draws = [
        rng.multivariate_normal(np.zeros(3), 1e-4 * np.linalg.inv(matrix(information)), 1500).tolist()
        for information in (one, other)
    ]
    X_ac = X_ab @ X_bc
    ends = [X_ac.inverse() @ X_ab @ Pose2(*a) @ X_bc @ Pose2(*b) for a, b in zip(*draws, strict=True)]
    explained_each = 1e-4 * np.linalg.inv(matrix(chained(one, other, X_bc)))
    sigmas = np.sqrt(np.diag(explained_each))
    assert np.allclose(spread(ends) / np.outer(sigmas, sigmas), explained_each / np.outer(sigmas, sigmas), atol=0.2)


def test_a_turn_changes_axes_and_no_amount() -> None:
    turned = along(matrix(diagonal(4.0, 1.0, 9.0)), math.pi / 2)
    assert np.allclose(turned, np.diag([1.0, 4.0, 9.0]))
    assert math.isclose(variance_m2(packed(turned)), 1.25)
