"""Desire classes come with the modules that serve or need them."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from pydantic import BaseModel

from app.attention.desires import DesireClass
from app.base import paths
from app.base.errors import ConfigError
from app.modules.behaviors.teleop import TELEOPERATION
from app.program.config import load_configuration
from app.program.desire_classes import desire_classes
from app.runtime.module import Module

OURS = DesireClass("Dance", "Dance", "Dance to the music.")


class DanceParameters(BaseModel):
    """Another definition's."""


def program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, **declared: tuple[Any, ...]) -> Path:
    """The file of a program of one module for each of ``declared``, which declares that."""
    made = ModuleType("dances")
    for name, classes in declared.items():
        setattr(made, name, type(name, (Module,), {"desire_classes": classes}))
    monkeypatch.setitem(sys.modules, "dances", made)
    for name in ("robot", "strategies", "channels"):
        (tmp_path / f"{name}.yaml").write_text("{}\n", "utf-8")
    lines = [f"  {name}: {{class: dances:{name}}}" for name in declared]
    head = ["robot: robot.yaml", "channels: channels.yaml", "strategies: [strategies.yaml]", "modules:"]
    file = tmp_path / "dances.yaml"
    file.write_text("\n".join([*head, *lines, ""]), "utf-8")
    return file


def test_a_programs_classes_are_those_of_its_modules() -> None:
    lab = desire_classes(load_configuration(paths.config_dir() / "lab.yaml"))
    assert lab["Teleoperation"] is TELEOPERATION
    webcam = desire_classes(load_configuration(paths.config_dir() / "webcam.yaml"))
    assert "FindQRCodes" in webcam
    assert "GoTo" not in webcam


def test_modules_of_one_class_share_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    same = DesireClass("Dance", "Dance", "Dance to the music.")
    file = program(tmp_path, monkeypatch, Waltz=(OURS,), Tango=(same,), Still=())
    assert list(desire_classes(load_configuration(file)).values()) == [OURS]


def test_modules_that_are_left_out_count(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    configuration = load_configuration(program(tmp_path, monkeypatch, Waltz=(OURS,), Still=()))
    configuration.program.modules.pop("Waltz")
    assert list(desire_classes(configuration)) == ["Dance"]


def test_another_definition_of_the_same_name_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    other = DesireClass("Dance", "Dance", "Dance to the music.", DanceParameters)
    file = program(tmp_path, monkeypatch, Waltz=(OURS,), Tango=(other,))
    with pytest.raises(ConfigError, match="Tango and Waltz declare different desire classes called 'Dance'") as refused:
        desire_classes(load_configuration(file))
    assert refused.value.line == 6


def test_what_is_no_desire_class_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = program(tmp_path, monkeypatch, Waltz=("Dance",))
    with pytest.raises(ConfigError, match="holds 'Dance', which is no DesireClass") as refused:
        desire_classes(load_configuration(file))
    assert refused.value.line == 5
