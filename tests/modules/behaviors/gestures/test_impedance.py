"""Words and numbers for stiffness."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from app.modules.behaviors.gestures.impedance import StiffnessParameters, impedance
from tests.modules.actuation.arms import LEFT

RIGID = replace(LEFT, name="crane", compliant=False)


def given(**params: Any) -> StiffnessParameters:
    return StiffnessParameters.model_validate(params)


def test_words_are_shares_of_the_groups_own_stiffness() -> None:
    assert impedance(LEFT, given()) is None
    free, soft, stiff = (impedance(LEFT, given(stiffness=word)) for word in ("free", "soft", "stiff"))
    assert free == (0.0, 0.5), "the least damping that the group takes"
    assert soft == pytest.approx((20.0, 3.46), abs=0.01)
    assert stiff == pytest.approx((300.0, 13.4), abs=0.1)


def test_a_number_overrides_the_word_within_the_groups_range() -> None:
    assert impedance(LEFT, given(stiffness="soft", stiffness_nm=60)) == (60.0, 6.0)
    with pytest.raises(ValueError, match="a stiffness of 500 is not within 0 to 300, which left_arm takes"):
        impedance(LEFT, given(stiffness_nm=500))


def test_a_group_that_is_not_compliant_has_its_own_stiffness_alone() -> None:
    assert impedance(RIGID, given()) is None
    with pytest.raises(ValueError, match="crane is not compliant"):
        impedance(RIGID, given(stiffness="soft"))
