"""The layout that viewers import shows topics that there are."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from app.base import paths
from app.modules.viewers.foxglove_server import FoxgloveServer
from app.modules.viewers.topics import ShownTopics
from app.program.config import load_configuration

LAYOUT = paths.config_dir() / "foxglove_layout.json"
#: Beside those of channels.
OTHERS = {"/robot_description"}


@pytest.fixture(scope="module")
def types() -> dict[str, str]:
    channels = load_configuration(paths.config_dir() / "lab.yaml").channels
    shown = FoxgloveServer.default_inputs(channels)
    return ShownTopics({name: channels[name].message_type for name in shown}).types


def test_every_topic_of_the_layout_is_advertised(types: dict[str, str]) -> None:
    named = {text.partition(".")[0] for text in strings(json.loads(LAYOUT.read_text("utf-8"))) if text.startswith("/")}
    assert len(named) > 8
    assert named <= set(types) | OTHERS


def test_every_panel_has_its_place() -> None:
    layout = json.loads(LAYOUT.read_text("utf-8"))
    placed = {text for text in strings(layout["layout"]) if "!" in text}
    assert placed == set(layout["configById"])


def test_the_layout_is_in_the_folder_that_the_docs_name() -> None:
    assert f"config/{LAYOUT.name}" in Path(__file__).parents[3].joinpath("docs/viewers.md").read_text("utf-8")


def strings(value: Any) -> Iterator[str]:
    """All strings in ``value``, keys included."""
    if isinstance(value, dict):
        for key, each in value.items():
            yield key
            yield from strings(each)
    elif isinstance(value, list):
        for each in value:
            yield from strings(each)
    elif isinstance(value, str):
        yield value
