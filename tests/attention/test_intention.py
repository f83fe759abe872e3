"""From a selection to filters and parameters."""

from __future__ import annotations

from app.attention.desires import Desire, Source
from app.attention.intention import divisors_of, parameters_of
from app.attention.strategies import CLOSED, Strategy

ME = Source("operator", "console")


def desired(cls: str, intensity: float, **params: object) -> Desire:
    return Desire(f"d-{cls}", cls, intensity, 1.0, False, params, ME, 0.0)


def test_where_strategies_share_a_filter_the_fastest_wins_and_the_rest_close() -> None:
    chosen = [Strategy("a", "A", 1, filters={"M.x": 4}), Strategy("b", "B", 1, filters={"M.x": 2})]
    assert divisors_of(chosen, {"M.x", "N.y"}) == {"M.x": 2, "N.y": CLOSED}


def test_a_strategys_parameters_win_over_its_desires() -> None:
    light = Strategy("light", "A", 1, filters={"M.x": 1}, parameters={"M": {"enlarge": False}})
    desires = {"A": desired("A", 4, enlarge=True, size=3)}
    assert parameters_of([light], desires) == {"M": {"enlarge": False, "size": 3}}


def test_of_two_classes_that_share_a_module_the_more_intense_has_the_last_word() -> None:
    chosen = [Strategy("a", "A", 1, filters={"M.x": 1}), Strategy("b", "B", 1, filters={"M.x": 1})]
    desires = {"A": desired("A", 5, size=1), "B": desired("B", 4, size=2, colour=1)}
    assert parameters_of(chosen, desires) == {"M": {"size": 1, "colour": 1}}
