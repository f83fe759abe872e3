"""What a program says of other computers: each mistake is found before anything starts, with its line."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.attention.strategies import CLOSED
from app.base.errors import ConfigError
from app.program.config import load_configuration
from app.program.nodes import node_of
from app.program.system import System
from tests.console.program import Body
from tests.remote.program import STRATEGIES, build, write


def _replaced(program: Path, old: str, new: str) -> Path:
    text = program.read_text()
    assert old in text
    program.write_text(text.replace(old, new))
    return program


def test_a_program_has_stand_ins_and_their_strategies(tmp_path: Path) -> None:
    system = build(write(tmp_path / "robot", 7447))
    stand_in = system.graph.modules["Darkness@desk"]
    assert set(stand_in.context.inputs) == {"images"}
    assert set(stand_in.context.outputs) == {"darkness"}
    assert system.table["look@desk"].filters == {"Darkness@desk.images": 1.0, "Darkness.images": CLOSED}
    assert {"cpu@desk", "bandwidth@desk"} <= set(system.table.resources)
    # Attention has its filter: closed, until the node is there and a strategy opens it.
    assert system.graph.filters.divisors()["Darkness@desk.images"] == CLOSED


def test_a_program_that_no_node_may_join_has_none_of_it(tmp_path: Path) -> None:
    """As a replay, or an experiment: of the same configuration."""
    system = System(load_configuration(write(tmp_path / "robot", 7447)), link=Body())
    assert set(system.graph.modules) == {"Darkness"}
    assert set(system.table.resources) == {"cpu"}


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("[Darkness]", "[Darknes]", r"program\.yaml:\d+: .*there is no module 'Darknes'"),
        ("StuckDetector", "Homebody", r"program\.yaml:\d+: .*Darkness can run on the robot's own computer alone"),
        ("tcp/127.0.0.1", "tcp/0.0.0.0", r"program\.yaml:\d+: .*leaves this computer unencrypted"),
        ("desk:", "my desk:", r"program\.yaml:\d+: .*is named by letters"),
    ],
)
def test_mistakes_are_named_with_their_line(tmp_path: Path, old: str, new: str, words: str) -> None:
    program = _replaced(write(tmp_path / "robot", 7447), old, new)
    with pytest.raises(ConfigError, match=words):
        build(program)


def test_a_module_that_no_strategy_chooses_goes_nowhere(tmp_path: Path) -> None:
    program = write(tmp_path / "robot", 7447)
    (tmp_path / "robot" / "strategies.yaml").write_text(STRATEGIES.partition("strategies:")[0])
    with pytest.raises(ConfigError, match="no strategy has filters of Darkness alone"):
        build(program)


def test_a_node_is_one_of_the_programs_computers(tmp_path: Path) -> None:
    program = write(tmp_path / "robot", 7447)
    assert node_of(load_configuration(program), None)[0] == "desk"
    with pytest.raises(ConfigError, match="no computer 'attic'; there is: desk"):
        node_of(load_configuration(program), "attic")
    _replaced(program, program.read_text().partition("nodes:")[2], " null\n")
    with pytest.raises(ConfigError, match="declares no other computers"):
        node_of(load_configuration(program), None)
