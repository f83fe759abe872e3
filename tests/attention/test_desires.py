"""Desire classes: a wrong parameter is refused at the door, with words."""

from __future__ import annotations

import pytest
from pydantic import BaseModel, Field

from app.attention.desires import (
    DesireClass,
    DesireClasses,
    InvalidDesire,
    UnknownDesireClass,
    checked_number,
)


class Goal(BaseModel):
    x: float
    y: float
    theta: float = Field(0.0, ge=-3.15, le=3.15)


GOTO = DesireClass("GoTo", "Go to", "Drive to a place.", Goal)
DANCE = DesireClass("Dance", "Dance", "Move to music.")


def test_parameters_are_completed_and_made_json() -> None:
    assert GOTO.validated({"x": 1, "y": "2.5"}) == {"x": 1.0, "y": 2.5, "theta": 0.0}
    assert DANCE.validated(None) == {}


@pytest.mark.parametrize(
    ("params", "field", "words"),
    [
        ({"x": 1}, "params.y", "is missing"),
        ({"x": 1, "y": 1, "z": 1}, "params.z", "allowed: theta, x, y"),
        ({"x": 1, "y": 1, "theta": 9}, "params.theta", "less than or equal to 3.15, not 9"),
        ({"x": "far", "y": 1}, "params.x", "'far'"),
    ],
)
def test_wrong_parameters_are_named(params: dict[str, object], field: str, words: str) -> None:
    with pytest.raises(InvalidDesire) as caught:
        GOTO.validated(params)
    assert caught.value.field == field
    assert words in caught.value.message


def test_unknown_class_names_those_there_are() -> None:
    classes = DesireClasses([GOTO, DANCE])
    assert list(classes) == ["GoTo", "Dance"]
    assert "GoTo" in classes
    with pytest.raises(UnknownDesireClass, match=r"did you mean 'GoTo'.*allowed: Dance, GoTo"):
        classes["Goto"]
    with pytest.raises(ValueError, match="two desire classes"):
        DesireClasses([GOTO, GOTO])


@pytest.mark.parametrize("value", [0, -1, 8.001, float("nan"), float("inf"), True, "4", None])
def test_intensities_out_of_range(value: object) -> None:
    with pytest.raises(InvalidDesire, match=r"from 0\.001 to 8"):
        checked_number("intensity", value, above=0)


def test_numbers_are_rounded_to_thousandths() -> None:
    assert checked_number("intensity", 1.23456, above=0) == 1.235
    assert checked_number("utility", 0) == 0
