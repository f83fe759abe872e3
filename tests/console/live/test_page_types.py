"""What the console sends is what the page declares, in ``web/src/protocol/types.ts``."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from app.program.system import System
from app.robots.config import circle
from app.runtime.module import Caution
from tests.console.live.whole_stream import heard, say_everything
from tests.console.live_client import page
from tests.console.page_types import PageTypes
from tests.console.program import Body, build

ROOT = Path(__file__).parents[3]


@pytest.fixture
def types() -> PageTypes:
    """The page's declarations."""
    return PageTypes.read()


@pytest.fixture
def kinds() -> list[str]:
    """Every type of frame from the robot that the document names; `playback` and `jump` are of recordings."""
    text = (ROOT / "docs" / "live-stream.md").read_text("utf-8")
    section = text.split("## From the robot to the page\n")[1].split("\n## ")[0]
    return re.findall(r"^\| `(\w+)` \|", section, flags=re.MULTILINE)


@pytest.fixture
def built(tmp_path: Path) -> tuple[System, Body]:
    """A program with everything that the stream reports, on a body with an outline."""
    system, body = build(tmp_path, recorder=True)
    body.description = replace(body.description, footprint=circle(0.28))
    system.cautions = (Caution("A title", "a sentence", "lab.yaml:1"),)
    return system, body


async def test_the_console_sends_what_the_page_declares(
    types: PageTypes, kinds: list[str], url: str, system: System, body: Body
) -> None:
    say_everything(system, body)
    frames = await heard(url, system, set(kinds), lambda frame: None)
    assert {kind: said for kind, frame in frames.items() if (said := types.problems(frame, "FromRobot"))} == {}
    hello = frames["hello"]
    assert hello["robot"]["cautions"] == [{"title": "A title", "text": "a sentence", "where": "lab.yaml:1"}]
    assert types.problems(hello, "Hello") == []
    assert hello["robot"]["footprint"] == [[round(x, 4), round(y, 4)] for x, y in circle(0.28)]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda robot: robot.pop("footprint"), ["Hello.robot.footprint is missing"]),
        (lambda robot: robot.update(colour="red"), ["Hello.robot.colour is not declared"]),
        (lambda robot: robot.update(name=1), ["Hello.robot.name is no string: 1"]),
        (lambda robot: robot["footprint"].append([1.0]), ["Hello.robot.footprint[16] is no list of 2: [1.0]"]),
    ],
)
async def test_a_drift_is_seen(types: PageTypes, url: str, change: Any, said: list[str]) -> None:
    async with page(url) as ann:
        hello = await ann.until("hello")
    change(hello["robot"])
    assert types.problems(hello, "Hello") == said
