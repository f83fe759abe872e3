from __future__ import annotations

import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.cli import main
from app.commands.printable import one_line, printable


@given(st.text())
def test_nothing_that_steers_a_terminal_is_left(text: str) -> None:
    assert not {unicodedata.category(c) for c in one_line(text)} & {"Cc", "Cf", "Cs", "Zl", "Zp"}
    assert not {"\x1b", "\r", "\x9b", "\u202e", "\u2066"} & set(printable(text))
    assert not {"\n", "\t"} & set(one_line(text))


@given(st.text(st.characters(categories=["L", "N", "P", "S"])))
def test_what_can_be_read_stays(text: str) -> None:
    assert one_line(text) == text


def test_a_mistake_with_an_escape_code_in_it_is_printed_without(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["solve", "\x1b[31m.yaml"]) == 2
    assert r"\x1b[31m.yaml" in capsys.readouterr().err
