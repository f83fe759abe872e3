"""What of attention's configuration cannot be, and what is left out of a program that has only some of its modules."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.base.errors import ConfigError
from app.program.config import load_configuration
from app.program.system import System
from tests.console.program import STRATEGIES, Body, write_program

POWER = "resource: {}, full_w: 40, empty_w: 20, weight: 0.25"


def built(folder: Path, attention: str, *, strategy: str = "", partial: bool = False) -> System:
    file = write_program(folder)
    file.write_text(f"{file.read_text()}attention: {attention}\n")
    (folder / "strategies.yaml").write_text(f"{STRATEGIES}  - {strategy}\n" if strategy else STRATEGIES)
    return System(load_configuration(file), link=Body(), partial=partial)


def test_power_that_no_file_of_strategies_declares_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="there is no resource 'cpus'; did you mean 'cpu'") as refusal:
        built(tmp_path, f"{{power: {{{POWER.format('cpus')}}}}}")
    assert "program.yaml" in str(refusal.value)


def test_what_power_is_spared_of_is_weighed_in_the_problem(tmp_path: Path) -> None:
    weights = built(tmp_path, f"{{power: {{{POWER.format('cpu')}}}}}").translator.problem().weights
    assert (weights.spare, weights.spare_of) == (0.25, "cpu")


def test_safe_strategies_that_there_are_not_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="safe strategies that do not exist: wait"):
        built(tmp_path, "{safe_strategies: [wait, drive-by-hand]}")


def test_a_part_of_the_program_does_without_what_is_of_other_modules(tmp_path: Path) -> None:
    look = "{name: look, class: FindQRCodes, utility: 4, filters: {Elsewhere.images: 1}}"
    with pytest.raises(ConfigError, match="'look' filters unknown module 'Elsewhere'"):
        built(tmp_path, "{}", strategy=look)
    system = built(tmp_path, "{safe_strategies: [drive-by-hand, wait]}", strategy=look, partial=True)
    assert "Elsewhere.images" not in system.table.filters
