"""Codes that carry their interaction: their form, its bounds, and that none is obeyed that no author accepted."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.tours.codes import (
    ALPHANUMERIC,
    Accepted,
    CarriedText,
    Code,
    CodeError,
    SayCode,
    StopCode,
    accepted,
    is_capitals,
    obeys_codes,
    parse,
)
from app.tours.model import Tour
from tests.tours.tours import ARM, tour

ids = st.from_regex(r"[a-z0-9][a-z0-9-]{0,39}", fullmatch=True)
languages = st.sampled_from(["en", "fr", "de-ch", "zh-hans"])
words = st.text(st.characters(categories=["L", "N", "P", "S", "Zs"]), min_size=1, max_size=40).filter(str.strip)
says = st.builds(CarriedText, languages, words)
codes = st.one_of(st.builds(StopCode, ids, says), st.builds(StopCode, ids), st.builds(SayCode, says))


@given(codes)
def test_there_and_back(code: Code) -> None:
    assert parse(str(code)) == code


@given(st.one_of(st.text(), st.text().map("HBBA:".__add__), st.text().map("HBBA:STOP/".__add__)))
def test_whatever_is_read_is_a_code_or_a_text_or_refused_in_a_sentence(text: str) -> None:
    try:
        code: Code | CodeError | None = parse(text)
    except CodeError as refusal:
        code = refusal
    assert (code is None) == (text[:5].upper() != "HBBA:")
    assert str(code).isprintable()


@given(st.text())
def test_no_text_is_obeyed_that_the_author_did_not_name(text: str) -> None:
    lab = tour()
    assert accepted(text, lab) is None or text == lab.stops[0].poster
    for begin in ("HBBA:STOP/ARM/EN/", "HBBA:SAY/EN/", "hbba:stop/arm"):
        assert accepted(begin + text, lab) is None


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("HBBA:", r"STOP/ or SAY/, not ''"),
        ("HBBA:GOTO/1,2", "not 'GOTO'"),
        ("HBBA:STOP/", "a stop's id"),
        ("HBBA:STOP/THE ARM", "a stop's id .* not 'THE ARM'"),
        ("HBBA:STOP/ſtop", "a stop's id"),
        ("HBBA:STOP/ARM/HELLO", "LANGUAGE/TEXT"),
        ("HBBA:SAY/EN", "LANGUAGE/TEXT"),
        ("HBBA:SAY/EN/ ", "must not be empty"),
        ("HBBA:SAY/EN/a\nb", "on one line"),
        ("HBBA:SAY/EN/a\u202eb", "control characters"),
        ("HBBA:SAY/EN/" + "é" * 150, "at most 300 bytes"),
        ("HBBA:" + "X" * 100_000, "at most 300 bytes"),
    ],
)
def test_what_is_malformed_is_refused_with_what_is_allowed(text: str, words: str) -> None:
    with pytest.raises(CodeError, match=words):
        parse(text)


def test_codes_of_others_are_text() -> None:
    assert [parse(text) for text in ("", "tour:robotics lab", "https://example.org", "HBB", "XHBBA:STOP/ARM")] == [
        None
    ] * 5


def test_a_stops_poster_leads_to_it_and_what_is_accepted_is_said() -> None:
    lab = tour(accept=["HBBA:SAY/FR/Bonjour !", "HBBA:STOP/ARM", "https://example.org", "HBBA:NONSENSE"])
    (arm,) = lab.stops
    assert accepted(str(arm.poster), lab) == Accepted(arm, None)
    assert accepted("HBBA:SAY/FR/Bonjour !", lab) == Accepted(None, CarriedText("fr", "Bonjour !"))
    assert accepted("HBBA:STOP/ARM", lab) == Accepted(arm, None)
    assert [accepted(text, lab) for text in ("https://example.org", "HBBA:NONSENSE", "HBBA:SAY/FR/Salut")] == [None] * 3
    left_out = Tour.model_validate(lab.model_dump() | {"stops": [ARM | {"left_out": True}]})
    assert accepted(str(arm.poster), left_out) is None
    assert accepted("HBBA:STOP/ARM", left_out) is None


def test_what_a_stops_code_carries_is_accepted_with_it() -> None:
    carries = "HBBA:STOP/ARM/EN/IT YIELDS."
    says = CarriedText("en", "IT YIELDS.")
    lab = tour(accept=[carries, "HBBA:STOP/LEG/EN/NOT HERE."])
    assert accepted(carries, lab) == Accepted(lab.stops[0], says)
    assert accepted("HBBA:STOP/LEG/EN/NOT HERE.", lab) is None
    posted = tour(stops=[ARM | {"poster": carries}])
    assert accepted(carries, posted) == Accepted(posted.stops[0], says)
    other = tour(stops=[ARM | {"poster": "HBBA:SAY/EN/HELLO."}])
    assert accepted("HBBA:SAY/EN/HELLO.", other) == Accepted(other.stops[0], None)


def test_a_tour_without_posters_and_further_codes_obeys_none() -> None:
    assert obeys_codes(tour())
    assert not obeys_codes(tour(stops=[ARM | {"left_out": True}]))
    assert not obeys_codes(tour(stops=[ARM | {"poster": None}]))
    assert obeys_codes(tour(stops=[ARM | {"poster": None}], accept=["HBBA:SAY/EN/HELLO."]))


def test_the_shortest_codes_are_of_capitals() -> None:
    assert is_capitals("HBBA:STOP/ROBOT-LAB1")
    assert not is_capitals("tour:lab")
    assert all(is_capitals(character) for character in ALPHANUMERIC)
