"""docs/writing-a-module.md, run: its module, its test, its wiring, its desire class and its strategies."""

from __future__ import annotations

import importlib
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from app.attention.strategies import load_strategies
from app.modules.desire_classes import desire_classes
from app.runtime.channel_table import ChannelSpec
from app.runtime.clock import VirtualClock
from app.runtime.graph import Graph, ModuleSpec
from app.yaml_source import load_yaml

ROOT = Path(__file__).parents[2]
PYTHON = {"approach.py", "test_approach.py", "desire_classes.py"}
YAML = {"channels.yaml", "lab.yaml", "strategies/approach.yaml"}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Every block of the page in a file of the name its first line gives."""
    text = (ROOT / "docs" / "writing-a-module.md").read_text("utf-8")
    blocks = dict(re.findall(r"```(?:python|yaml)\n# (\S+)\n(.*?)```", text, flags=re.DOTALL))
    assert blocks.keys() == PYTHON | YAML
    for name, block in blocks.items():
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(block, "utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    yield tmp_path
    for name in PYTHON:
        sys.modules.pop(name.removesuffix(".py"), None)


def imported(name: str) -> ModuleType:
    sys.modules.pop(name, None)
    return importlib.import_module(name)


def test_the_pages_module_passes_the_pages_test(folder: Path) -> None:
    imported("approach")
    tests = [value for name, value in vars(imported("test_approach")).items() if name.startswith("test_")]
    assert tests
    for test in tests:
        test()


def test_the_module_is_short(folder: Path) -> None:
    source = (folder / "approach.py").read_text("utf-8")
    module = source[source.index("class ApproachSettings") :]
    assert len([line for line in module.splitlines() if line.strip()]) <= 30


def test_the_page_wires_into_the_lab_and_its_strategies_can_be_attended(folder: Path) -> None:
    imported("approach")
    page = imported("desire_classes")
    modules: dict[str, Any] = load_yaml(ROOT / "config" / "lab.yaml").data["modules"]
    channels: dict[str, Any] = load_yaml(ROOT / "config" / "channels.yaml").data
    modules |= load_yaml(folder / "lab.yaml").data["modules"]
    channels |= load_yaml(folder / "channels.yaml").data
    graph = Graph(
        clock=VirtualClock(),
        channels={name: ChannelSpec.model_validate(spec) for name, spec in channels.items()},
        modules={name: ModuleSpec.model_validate(spec) for name, spec in modules.items()},
        services={},
    )
    classes = [desire_class.name for desire_class in (*desire_classes(), page.APPROACH)]
    files = [ROOT / "config" / "strategies" / "lab.yaml", folder / "strategies" / "approach.yaml"]
    table = load_strategies(files, classes=classes, ports=graph.ports())
    assert [s.name for s in table.strategies if s.cls == "Approach"] == ["approach-1", "approach-4"]
    assert page.APPROACH.validated(None) == {"speed_mps": 0.2}
    assert table.filters <= set(graph.filters.names())
