from __future__ import annotations

import numpy as np

from app.modules.perception.loud_noises import LoudnessRule
from benchmarks.lab_noise import RATE, blocks, script
from benchmarks.noises import events_of_ours, events_of_the_plain_rule, listen, score


def test_a_noise_is_found_once_and_all_else_is_wrong() -> None:
    truth = np.array([1.0, 5.0, 9.0])
    assert score(np.array([0.992, 5.2]), truth) == (1.0, 2 / 3)
    assert score(np.array([1.0, 1.1, 3.0, 9.5]), truth) == (1 / 4, 1 / 3)
    assert score(np.array([]), truth) == (0.0, 0.0)


def test_the_laboratory_is_the_same_for_the_same_seed_and_ours_hears_its_claps() -> None:
    plan = script(5, 50.0)
    first, again = (next(blocks(plan)) for _ in range(2))
    assert len(first) == 10 * RATE
    np.testing.assert_array_equal(first, again)
    assert not first[: round(0.3 * RATE)].any(), "the microphone is not on yet"
    hour = listen(plan)
    right, found = score(events_of_ours(hour, LoudnessRule()), plan.truth)
    assert len(plan.truth) >= 2
    assert min(right, found) == 1.0
    assert events_of_the_plain_rule(hour, LoudnessRule())[0] < 1.0, "the plain rule tells the switching on"
