"""Confidence as utility: bounded, with hysteresis, and forgotten."""

from __future__ import annotations

import math

import pytest

from app.attention.confidence import Confidences, factors, remarks
from app.attention.strategies import CLOSED, Strategy

TABLE = (
    Strategy("see", "See", 8, {}, {"Eye.images": 2}),
    Strategy("watch", "Watch", 4, {}, {"Eye.images": 1, "Ear.audio": 1}),
    Strategy("walk", "Walk", 4, {}, {"Legs.twist": 1, "Eye.images": CLOSED}),
)


def heard(*values: float, least: float = 0.25) -> Confidences:
    """Once a second."""
    confidences = Confidences(least)
    for now, value in enumerate(values):
        confidences.take("Eye", now, value, "it is dark")
    return confidences


def test_a_lower_level_counts_once_it_lasts() -> None:
    assert heard(1, 0.5, 0.5).levels() == {}
    assert heard(1, 0.5, 0.5, 0.5).levels() == {"Eye": (0.5, "it is dark")}
    assert heard(0.5, 0.5, 1, 0.5, 0.5).levels() == {}, "it did not last"


def test_little_makes_no_difference_and_there_is_a_least() -> None:
    assert heard(*[0.9] * 10).levels() == {}
    assert heard(*[0.0] * 10).levels() == {"Eye": (0.25, "it is dark")}
    assert heard(*[math.nan] * 10).levels() == {}


def test_it_comes_back_whole() -> None:
    assert heard(*[0.5] * 5, *[1] * 4).levels() == {}
    assert heard(*[0.9] * 3, *[0.5] * 4, *[0.6] * 4).levels() == {"Eye": (0.5, "it is dark")}


def test_a_perception_that_falls_silent_is_trusted_again() -> None:
    confidences = heard(*[0.5] * 5)
    confidences.expire(20)
    assert confidences.levels()
    confidences.expire(40)
    assert confidences.levels() == {}


def test_those_that_open_it_produce_less() -> None:
    levels = {"Eye": (0.5, "it is dark"), "Ear": (0.4, "it is noisy")}
    assert factors(TABLE, levels) == {"see": 0.5, "watch": 0.4}
    assert remarks(TABLE, levels) == {"See": "Eye works at 50 %: it is dark", "Watch": "Ear works at 40 %: it is noisy"}


def test_a_least_confidence_that_cannot_be_is_refused() -> None:
    with pytest.raises(ValueError, match="over 0"):
        Confidences(0)
