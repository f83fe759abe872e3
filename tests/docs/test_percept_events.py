"""docs/percept-events.md: its names, fields and parameters are those of the module, its settings are accepted."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path

import yaml

from app import messages
from app.messages import PerceptEvent, PerceptKind
from app.modules.perception.percept_events import DECLARED, DEFAULTS, PerceptEventsSettings
from app.modules.perception.presence import Hysteresis

KINDS = [
    kind.name
    for each in vars(messages).values()
    if isinstance(kind := getattr(each, "percept_kind", None), PerceptKind)
]
PAGE = (Path(__file__).parents[2] / "docs" / "percept-events.md").read_text("utf-8")


def rows(heading: str) -> list[list[str]]:
    """The cells of the table whose first row begins with ``heading``."""
    lines = PAGE[PAGE.index(heading) :].split("\n\n")[0].splitlines()
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in (lines[0], *lines[2:])]


def test_the_names_are_those_of_each_kind() -> None:
    named = {name for row in rows("| name |")[1:] for name in re.findall(r"`([^`]+)`", row[0])}
    expected = set()
    for kind, rule in (DEFAULTS | dict.fromkeys(KINDS, DECLARED)).items():
        changes = rule.moved_m is not None or rule.turned_rad is not None
        expected |= {f"{kind}.{verb}" for verb in ("appears", "leaves", *(["changes"] if changes else []))}
    assert named == expected


def test_the_fields_are_those_of_the_message() -> None:
    shown = re.findall(r"`(\w+)`", " ".join(row[0] for row in rows("| field |")[1:]))
    assert set(shown) == {field.name for field in fields(PerceptEvent)}


def test_the_parameters_are_the_defaults() -> None:
    head, *body = rows("| parameter |")
    kinds = [cell.strip("`") for cell in head[2:]]
    rules = {**DEFAULTS, "others": DECLARED}
    assert kinds == list(rules)
    shown = {re.findall(r"`(\w+)`", row[0])[0]: row[2:] for row in body}
    assert set(shown) == set(Hysteresis.model_fields)
    for name, cells in shown.items():
        values = [None if cell == "–" else float(cell) for cell in cells]
        assert values == [getattr(rules[kind], name) for kind in kinds], name


def test_the_settings_shown_are_accepted() -> None:
    (block,) = re.findall(r"```yaml\n(.*?)```", PAGE, flags=re.DOTALL)
    settings = PerceptEventsSettings(**yaml.safe_load(block)["modules"]["PerceptEvents"]["settings"])
    assert (settings.face.off_s, settings.face.sightings, settings.code.moved_m) == (5, 3, 1)
