"""Which percept is looked at: the nearest, the one that was chosen, the named one; and when it is given up."""

from __future__ import annotations

import numpy as np
import pytest

from app.modules.behaviors.gaze.target_choice import Candidate, ChoiceRules, TargetChoice

RULES = ChoiceRules(keep_s=2.0, give_up_s=10.0, smoothing_s=0.0)


def candidate(name: str, x: float, rank: float | None = None) -> Candidate:
    return Candidate(name, np.array([x, 0.0, 1.0]), x if rank is None else rank)


def choice(wanted: str = "", rules: ChoiceRules = RULES) -> TargetChoice:
    return TargetChoice("a face", wanted, rules, now=0.0)


def followed(made: TargetChoice) -> tuple[str, float]:
    assert made.target is not None
    return made.target.name, float(made.target.p_OP[0])


def test_the_nearest_is_taken_and_kept_though_another_comes_nearer() -> None:
    made = choice()
    made.see(1.0, [candidate("1", 3.0), candidate("2", 2.0)])
    assert followed(made) == ("2", 2.0)
    made.see(1.1, [candidate("1", 0.5), candidate("2", 2.1)])
    assert followed(made) == ("2", 2.1)


def test_an_unseen_one_stays_for_a_while_before_another_is_taken() -> None:
    made = choice()
    made.see(1.0, [candidate("1", 2.0)])
    made.see(2.9, [candidate("2", 1.0)])
    assert followed(made) == ("1", 2.0)
    made.see(3.1, [candidate("2", 1.0)])
    assert followed(made) == ("2", 1.0)


def test_one_that_is_better_by_the_margin_takes_over() -> None:
    made = choice(rules=ChoiceRules(margin=6.0, smoothing_s=0.0))
    made.see(1.0, [candidate("1", 1.0, rank=-60.0)])
    made.see(1.1, [candidate("1", 1.0, rank=-60.0), candidate("2", 2.0, rank=-64.0)])
    assert followed(made)[0] == "1"
    made.see(1.2, [candidate("1", 1.0, rank=-60.0), candidate("2", 2.0, rank=-67.0)])
    assert followed(made)[0] == "2"


def test_only_the_wanted_one_counts() -> None:
    made = choice("7")
    made.see(1.0, [candidate("1", 1.0)])
    assert made.target is None
    made.see(1.1, [candidate("1", 1.0), candidate("7", 4.0)])
    assert followed(made) == ("7", 4.0)


def test_it_is_given_up_with_a_reason_and_taken_up_again() -> None:
    made = choice("7")
    assert made.problem(9.9) == ""
    assert made.problem(10.0) == "it gave up: a face 7 was not perceived within 10 s"
    made.see(11.0, [candidate("7", 1.0)])
    assert made.problem(20.9) == ""
    assert made.problem(21.0) == "it gave up: a face 7 has not been perceived for 10 s"


def test_places_are_smoothed_and_a_jump_is_taken_at_once() -> None:
    made = choice(rules=ChoiceRules(smoothing_s=0.1, jump_m=0.5))
    made.see(1.0, [candidate("1", 2.0)])
    made.see(1.1, [candidate("1", 2.2)])
    assert followed(made)[1] == pytest.approx(2.0 + 0.2 * (1 - np.exp(-1)))
    made.see(1.2, [candidate("1", 4.0)])
    assert followed(made)[1] == 4.0


def test_a_message_that_comes_late_changes_nothing() -> None:
    made = choice()
    made.see(1.0, [candidate("1", 2.0)])
    made.see(0.9, [candidate("1", 5.0)])
    assert followed(made) == ("1", 2.0)
