"""JSON within bounds."""

from __future__ import annotations

import json

import pytest

from app.base.json_source import BeyondBounds, load_json


def test_a_value_is_that_of_the_library() -> None:
    text = '{"a": [1, -2.5, null, {"b": "\\u00e9"}]}'
    assert load_json(text) == json.loads(text)
    assert load_json(text, of_pairs=len) == 1
    with pytest.raises(json.JSONDecodeError):
        load_json("{")


@pytest.mark.parametrize("digits", [251, 5_000])
def test_a_number_of_hundreds_of_digits_is_refused(digits: int) -> None:
    with pytest.raises(BeyondBounds, match=f"a number has {digits} digits; at most 250 are read"):
        load_json('{"a": [' + "9" * digits + "]}")
    assert load_json("9" * 250) == 10**250 - 1


@pytest.mark.parametrize("depth", [65, 900, 100_000])
@pytest.mark.parametrize(("begin", "end"), [("[", "]"), ('{"a":', "}")])
def test_what_is_nested_too_deeply_is_refused(depth: int, begin: str, end: str) -> None:
    with pytest.raises(BeyondBounds, match="at most 64 deep"):
        load_json(begin * depth + "1" + end * depth)
    assert load_json(begin * 64 + "1" + end * 64) != 1
    assert len(load_json("[" + "[[]]," * 1000 + "1]")) == 1001
