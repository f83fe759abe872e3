"""Which salient direction is looked at, and for how long."""

from __future__ import annotations

import numpy as np
import pytest

from app.base.geometry import azimuth_elevation, unit_vector
from app.modules.behaviors.gaze.fixation import FixationRules, Gazing

RULES = FixationRules(hold_s=1.5, reach_s=2.0)
LEFT, RIGHT = unit_vector(1.0, 0.1), unit_vector(-1.0, 0.1)


def azimuth(gazing: Gazing) -> float | None:
    return None if gazing.v_O is None else azimuth_elevation(gazing.v_O)[0]


def test_the_most_salient_is_held_and_then_the_next_is_chosen() -> None:
    gazing = Gazing(RULES)
    assert gazing.step(0.0, reached=True) is None, "nothing to look at yet"
    gazing.take(0.0, [LEFT, RIGHT])
    assert azimuth(gazing) == pytest.approx(1.0)
    assert gazing.step(0.5, reached=False) is None
    assert gazing.step(1.0, reached=True) is None
    gazing.take(1.2, [RIGHT, LEFT])
    assert azimuth(gazing) == pytest.approx(1.0), "another does not take over meanwhile"
    assert gazing.step(2.4, reached=True) is None
    done = gazing.step(2.5, reached=True)
    assert done is not None
    assert azimuth_elevation(done)[0] == pytest.approx(1.0)
    assert gazing.v_O is None


def test_what_was_salient_before_the_fixation_is_not_chosen_again() -> None:
    gazing = Gazing(RULES)
    gazing.take(0.0, [LEFT])
    gazing.step(0.0, reached=True)
    assert gazing.step(1.5, reached=True) is not None
    gazing.take(1.4, [LEFT])
    assert gazing.v_O is None
    gazing.take(1.6, [])
    assert gazing.v_O is None
    gazing.take(1.7, [RIGHT])
    assert azimuth(gazing) == pytest.approx(-1.0)


def test_what_moves_is_followed_and_what_is_elsewhere_is_not_the_same() -> None:
    gazing = Gazing(RULES)
    gazing.take(0.0, [LEFT])
    for step in range(1, 8):
        gazing.take(0.2 * step, [RIGHT, unit_vector(1.0 + 0.1 * step, 0.1)])
    assert azimuth(gazing) == pytest.approx(1.7)
    gazing.take(1.6, [RIGHT])
    assert azimuth(gazing) == pytest.approx(1.7), "where it was last"


def test_what_the_head_does_not_reach_is_given_up_in_time() -> None:
    gazing = Gazing(RULES)
    gazing.take(10.0, [np.array([-1.0, 0.0, 0.0])])
    assert gazing.step(11.9, reached=False) is None
    assert gazing.step(12.0, reached=False) is None
    assert gazing.step(13.4, reached=False) is None
    assert gazing.step(13.5, reached=False) is not None
