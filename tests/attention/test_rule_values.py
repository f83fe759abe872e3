from __future__ import annotations

import math
from typing import Any

import pytest

from app.attention.rule_values import InvalidTest, NoValue, check_place, check_test, passes, places_of, resolved
from app.messages import BatteryState, LoudNoise, PerceptEvent, SoundSource, SoundSources, TimelineEvent, TourProgress

FACE = PerceptEvent(3.0, "face.appears", "face", "7", "kinect", 2.5, 0.9, (1.5, -2.0, 1.6), None)


def heard(speech: float, *, active: bool = True) -> SoundSources:
    source = SoundSource(1, (1.0, 0.0, 0.0), 0.1, -30.0, active, speech, 2.0, 1.0)
    return SoundSources(1.0, (0.0, 0.0, 0.8), (source,))


VOICE = {"sources": {"any": {"active": True, "speech": {"not": {"below": 0.5}}}}}


@pytest.mark.parametrize(
    ("value", "test", "outcome"),
    [
        (FACE, {}, True),
        (FACE, {"subject": "7", "confidence": {"at_least": 0.9}}, True),
        (FACE, {"subject": ["6", "7"]}, True),
        (FACE, {"subject": {"not": ["6", "7"]}}, False),
        (FACE, {"confidence": {"above": 0.9}}, False),
        (FACE, {"p_OP": {"0": {"above": 1, "below": 2}, "1": {"at_most": -2}}}, True),
        (FACE, {"p_OP": {"9": {"above": 1}}}, False),
        (FACE, {"heading": {"above": 0}}, False),
        (FACE, {"heading": {"not": {"above": 0}}}, True),
        (FACE, {"heading": {"is": None}}, True),
        (heard(0.9), VOICE, True),
        (heard(0.1), VOICE, False),
        (heard(0.9, active=False), VOICE, False),
        (heard(math.nan), VOICE, True),
        (heard(math.nan), {"sources": {"any": {"speech": {"above": 0}}}}, False),
        (SoundSources(1.0, (0.0, 0.0, 0.0), ()), VOICE, False),
        (TimelineEvent(1, 2.0, "tour", "lab", "", {"state": "led", "n": 1}), {"data": {"state": "led"}}, True),
        (TimelineEvent(1, 2.0, "tour", "lab", "", {"n": 1}), {"data": {"n": True}}, False),
        ({"yes": True}, {"yes": 1}, False),
    ],
)
def test_a_test_passes_what_it_says(value: Any, test: Any, outcome: bool) -> None:
    assert passes(value, test) is outcome


@pytest.mark.parametrize(
    ("kind", "test", "path", "message"),
    [
        (PerceptEvent, {"subjet": "7"}, ("subjet",), "did you mean 'subject'"),
        (PerceptEvent, {"confidence": {"over": 1}}, ("confidence", "over"), "allowed: above"),
        (PerceptEvent, {"confidence": {"above": "much"}}, ("confidence", "above"), "must be a number"),
        (PerceptEvent, {"confidence": {"above": math.inf}}, ("confidence", "above"), "must be a number"),
        (SoundSources, {"sources": {"any": {"loud": 1}}}, ("sources", "any", "loud"), "unknown field"),
        (SoundSources, {"sources": {"speech": 1}}, ("sources", "speech"), "by its number from 0, or by `any`"),
        (LoudNoise, [{"ratio": {"above": 1}}, {"ration": 1}], (1, "ration"), "did you mean 'ratio'"),
    ],
)
def test_a_test_that_cannot_be_is_refused_where_it_is(kind: Any, test: Any, path: Any, message: str) -> None:
    with pytest.raises(InvalidTest, match=message) as refusal:
        check_test(kind, test)
    assert refusal.value.path == path


@pytest.mark.parametrize(
    ("kind", "test"),
    [
        (SoundSources, VOICE),
        (BatteryState, {"charge": {"below": 0.3}}),
        (TimelineEvent, {"kind": "tour", "data": {"anything": {"at": {"all": 1}}}}),
        (TourProgress, {}),
    ],
)
def test_a_test_that_fits_is_not_refused(kind: Any, test: Any) -> None:
    check_test(kind, test)


def test_parameters_take_values_of_the_event() -> None:
    params = {"x": "{p_OP.0}", "text": "Hello {subject}, {confidence}", "deep": [{"who": "{subject}"}], "n": 3}
    assert resolved(params, FACE) == {"x": 1.5, "text": "Hello 7, 0.9", "deep": [{"who": "7"}], "n": 3}
    assert sorted(places_of(params)) == ["confidence", "p_OP.0", "subject", "subject"]
    for name in ("heading", "p_OP.7", "nothing"):
        with pytest.raises(NoValue, match=name):
            resolved(f"at {{{name}}}", FACE)
    check_place(PerceptEvent, "p_OP.0")
    with pytest.raises(InvalidTest, match="unknown field"):
        check_place(PerceptEvent, "position")
