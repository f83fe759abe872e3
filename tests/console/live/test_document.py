"""docs/live-stream.md says what crosses the stream: every type, every field, every word a program may compare with."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args

import msgspec
import pytest

from app.console.live import protocol
from app.messages import EventKind
from app.program.system import System
from app.runtime.freshness import FreshnessState
from app.runtime.supervisor import Status
from tests.console.live.whole_stream import heard, say_everything
from tests.console.program import Body, build

DOCUMENT = Path(__file__).parents[3] / "docs" / "live-stream.md"
#: Described elsewhere (REST, JSON Schema) or free by nature.
FOREIGN = {"asked", "costs", "data", "desires", "divisors", "filters", "parameters", "reasons", "schema", "use"}


@pytest.fixture
def text() -> str:
    """The page."""
    return DOCUMENT.read_text("utf-8")


@pytest.fixture
def built(tmp_path: Path) -> tuple[System, Body]:
    """A program with everything that the stream can carry."""
    return build(tmp_path, recorder=True)


def table(text: str, heading: str) -> dict[str, str]:
    """The rows of the table below ``heading`` by type."""
    section = text.split(f"## {heading}\n")[1].split("\n## ")[0]
    return dict(re.findall(r"^\| `(\w+)` \| (.*) \|$", section, flags=re.MULTILINE))


def names(value: Any) -> Iterator[str]:
    """Every field's name in a frame, at any depth."""
    if isinstance(value, dict):
        for name, inner in value.items():
            yield name
            if name not in FOREIGN:
                yield from names(inner)
    elif isinstance(value, list):
        for inner in value:
            yield from names(inner)


async def test_every_type_and_field_from_the_robot_is_described(
    text: str, url: str, system: System, body: Body
) -> None:
    rows = table(text, "From the robot to the page")
    say_everything(system, body)

    def known(frame: dict[str, Any]) -> None:
        assert frame["type"] in rows

    frames = await heard(url, system, set(rows), known)
    assert frames["perceived"]["faces"]
    assert frames["perceived"]["sounds"]
    assert frames["perceived"]["noises"]
    assert frames["navigation"]["path"]
    assert frames["zones"]["zones"]
    for kind, frame in frames.items():
        listed = set(re.findall(r"\w+", rows[kind]))
        assert set(names(frame)) - {"type"} <= listed, kind


def test_every_type_and_field_from_the_page_is_described(text: str) -> None:
    rows = table(text, "From the page to the robot")
    messages = {struct.__struct_config__.tag: struct for struct in get_args(protocol.FromPage)}
    assert rows.keys() == messages.keys()
    for kind, struct in messages.items():
        assert {field.name for field in msgspec.structs.fields(struct)} <= set(re.findall(r"`(\w+)`", rows[kind])), kind


def test_every_word_that_a_program_may_compare_with_is_there(text: str) -> None:
    words = set(re.findall(r"`(\w+)`", text))
    for known in (EventKind, FreshnessState, Status):
        assert set(get_args(known)) <= words
