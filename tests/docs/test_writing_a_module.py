"""docs/writing-a-module.md, followed as a reader would: its files are put where it says, checked, and driven."""

from __future__ import annotations

import importlib
import re
import shutil
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
import yaml

import app.modules.behaviors
from app import cli
from app.attention.desires import DesireClass, Source
from app.base import paths
from app.base.errors import ConfigError
from app.experiments.world_run import WorldRun, run_in_world
from app.messages import Exploitation
from app.program.config import Configuration, load_configuration
from app.program.system import System
from app.robots.config import RobotConfig
from app.robots.factory import load_body
from tests.distributions import announce
from tests.robots.conftest import make_hall

ROOT = Path(__file__).parents[2]
MODULE = "app/modules/behaviors/approach.py"
TEST = "tests/modules/behaviors/test_approach.py"
PROGRAM = "config/lab.yaml"
STRATEGIES = "config/strategies/approach.yaml"
CHANNELS = "config/channels.yaml"
IMPORTED = "app.modules.behaviors.approach"
#: Of the hall: where its wall ahead begins.
WALL_X = 19.9
#: What drives, and what it needs; the others take long to start and move nothing here.
DRIVING = ("Hokuyo", "WheelOdometry", "Teleop", "MobileBaseControl", "Approach")


@pytest.fixture
def blocks() -> dict[str, str]:
    """The page's blocks by the file that their first line names."""
    text = (ROOT / "docs" / "writing-a-module.md").read_text("utf-8")
    return dict(re.findall(r"```(?:python|yaml)\n# (\S+)\n(.*?)```", text, flags=re.DOTALL))


@pytest.fixture
def checkout(tmp_path: Path, blocks: dict[str, str], monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder with the configuration and the page's module, class and strategies, put where the page says."""
    assert blocks.keys() == {MODULE, TEST, PROGRAM, STRATEGIES, CHANNELS}
    shutil.copytree(paths.config_dir(), tmp_path / "config")
    for name in (MODULE, TEST, STRATEGIES):
        written(tmp_path / name, blocks[name])
    with (tmp_path / CHANNELS).open("a", encoding="utf-8") as channels:
        channels.write(f"\n{blocks[CHANNELS]}")
    # The new module lies in the project's own package.
    monkeypatch.setattr(
        app.modules.behaviors, "__path__", [*app.modules.behaviors.__path__, str((tmp_path / MODULE).parent)]
    )
    yield tmp_path
    sys.modules.pop(IMPORTED, None)
    vars(app.modules.behaviors).pop("approach", None)


def written(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, "utf-8")
    return path


def test_the_page_begins_with_a_skeleton_that_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (ROOT / "docs" / "writing-a-module.md").read_text("utf-8")
    named = re.search(r"^hbba (new \w+ \w+) --in ~/robots$", text, flags=re.MULTILINE)
    assert named is not None
    assert cli.main([*named[1].split(), "--in", str(tmp_path)]) == 0
    (package,) = tmp_path.iterdir()
    _, entered, steps = text.partition(f"cd ~/robots/{package.name}\n")
    assert entered
    readme = re.findall(r"^    (.+)$", (package / "README.md").read_text("utf-8"), flags=re.MULTILINE)
    assert [line.split("  #")[0].strip() for line in steps.partition("```")[0].splitlines()] == readme
    announce(package)
    monkeypatch.syspath_prepend(str(package))
    (name,) = re.findall(r"^hbba check (\w+)$", text, flags=re.MULTILINE)
    capsys.readouterr()
    assert cli.main(["check", name]) == 0
    assert "program, no mistake found" in capsys.readouterr().out
    assert f"hbba run --config {name} " in text


def merged(checkout: Path, block: str) -> Path:
    """The lab's program with the block's modules and strategies in the place of those of the same name."""
    path = checkout / PROGRAM
    program = yaml.safe_load(path.read_text("utf-8"))
    page = yaml.safe_load(block)
    program["modules"] |= page["modules"]
    program["strategies"] = page.get("strategies", program["strategies"])
    return written(path, yaml.safe_dump(program, sort_keys=False, allow_unicode=True))


def without_strategies(block: str) -> str:
    return block[block.index("modules:") :]


def driving(program: Path) -> tuple[Configuration, RobotConfig]:
    """What of the program drives, and its body 2 m before the wall of a hall."""
    configuration = load_configuration(program)
    modules = {name: spec for name, spec in configuration.program.modules.items() if name in DRIVING}
    body = load_body(configuration.path(configuration.program.robot))
    assert isinstance(body, RobotConfig)
    start = body.start.model_copy(update={"x": WALL_X - 2.0, "y": 10.0, "heading_deg": 0.0})
    return (
        replace(configuration, program=configuration.program.model_copy(update={"modules": modules})),
        body.model_copy(update={"start": start}),
    )


def test_the_pages_module_passes_the_pages_test(checkout: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend((checkout / TEST).parent)
    try:
        tests = [v for name, v in vars(importlib.import_module("test_approach")).items() if name.startswith("test_")]
        assert tests
        for test in tests:
            test()
    finally:
        sys.modules.pop("test_approach", None)


def test_the_module_is_short(blocks: dict[str, str]) -> None:
    source = blocks[MODULE]
    module = source[source.index("class ApproachSettings") :]
    assert len([line for line in module.splitlines() if line.strip()]) <= 30


def test_what_the_page_changes_is_what_it_marks_as_new(blocks: dict[str, str]) -> None:
    page = blocks[PROGRAM]
    module = re.compile(r"  Approach: +# new, with all below it\n(?:    .*\n)+")
    kept = "".join(line for line in module.sub("", page).splitlines(keepends=True) if "# new" not in line)
    assert kept.count("pproach") == 0
    base = yaml.safe_load(kept)["modules"]["MobileBaseControl"]
    lab = yaml.safe_load((ROOT / PROGRAM).read_text("utf-8"))
    assert base == lab["modules"]["MobileBaseControl"]
    assert yaml.safe_load(kept)["strategies"] == lab["strategies"]


def test_the_pages_program_is_in_order_and_its_strategies_can_be_attended(
    checkout: Path, blocks: dict[str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    program = merged(checkout, blocks[PROGRAM])
    assert cli.main(["check", str(program)]) == 0
    said = capsys.readouterr()
    assert said.out.endswith("program, no mistake found\n")
    assert "closed" not in said.err
    system = System(load_configuration(program))
    assert [s.name for s in system.table.strategies if s.cls == "Approach"] == ["approach-1", "approach-4"]
    approach = system.classes["Approach"]
    assert isinstance(approach, DesireClass)
    assert approach.validated(None) == {"speed_mps": 0.2}
    assert system.cautions == ()
    base = system.graph.modules["MobileBaseControl"].context.inputs
    assert {name for name, port in base.items() if port.connected} == set(base)
    assert {"scans", "odometry", "operator", "path", "toward", "approach"} <= set(base)


@pytest.mark.slow
def test_the_pages_robot_waits_for_a_desire_and_the_monitor_stops_it(checkout: Path, blocks: dict[str, str]) -> None:
    # A careless module: it would drive into the wall by itself.
    configuration, body = driving(merged(checkout, blocks[PROGRAM].replace("stop_m: 0.8", "stop_m: 0.0")))

    async def script(run: WorldRun) -> tuple[float, float, float, str]:
        reports: list[Exploitation] = []
        run.system.graph.channel("exploitation").observe(reports.append)
        begin = run.link.true_pose().x
        await run.system.clock.sleep(3.0)
        undesired = run.link.true_pose().x - begin
        run.system.workspace.add("Approach", intensity=8, utility=1, source=Source("operator", "a test"))
        await run.system.clock.sleep(3.0)
        desired = run.link.true_pose().x - begin
        await run.system.clock.sleep(12.0)
        return undesired, desired, run.link.true_pose().x, reports[-1].limited

    undesired, desired, x, limited = run_in_world(configuration, body, script, world=make_hall())
    assert undesired == pytest.approx(0.0, abs=1e-3)
    assert desired > 0.3
    assert limited.startswith("stopped: something")
    assert WALL_X - 0.5 < x < WALL_X - max(corner_x for corner_x, _ in body.footprint)


@pytest.mark.slow
def test_a_reader_who_forgets_the_line_of_strategies_is_warned_and_the_robot_stands(
    checkout: Path, blocks: dict[str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    program = merged(checkout, without_strategies(blocks[PROGRAM]))
    assert cli.main(["check", str(program)]) == 0
    said = capsys.readouterr()
    assert said.out.endswith("no mistake found, 2 warnings\n")
    line = program.read_text("utf-8").splitlines().index("      twist: approach_twist") + 1
    assert said.err.startswith(f"{program}:{line}: no strategy opens Approach.twist")
    assert "MobileBaseControl.approach" in said.err
    assert "`strategies`" in said.err
    assert "no strategy serves Approach, a class of Approach" in said.err
    configuration, body = driving(program)

    async def script(run: WorldRun) -> tuple[float, bool]:
        begin = run.link.true_pose().x
        offered = run.system.graph.modules["Approach"].context.outputs["twist"]
        await run.system.clock.sleep(5.0)
        return run.link.true_pose().x - begin, offered.offered > 0

    moved, spoke = run_in_world(configuration, body, script, world=make_hall())
    assert spoke, "it asked to drive, as its scans are not kept from it"
    assert moved == pytest.approx(0.0, abs=1e-3)


def test_a_program_whose_base_loses_its_scans_is_refused(checkout: Path, blocks: dict[str, str]) -> None:
    inputs = re.sub(
        r"inputs:\n(      \w+: \w+.*\n)+", "inputs: {teleop: teleop_twist, approach: approach_twist}\n", blocks[PROGRAM]
    )
    alone = re.sub(r"        - \{input: (path|toward).*\n", "", inputs)
    program = merged(checkout, alone)
    with pytest.raises(ConfigError, match="no input scans") as refused:
        System(load_configuration(program))
    lines = program.read_text("utf-8").splitlines()
    base = lines.index("  MobileBaseControl:")
    assert refused.value.line == base + 1 + lines[base:].index("    inputs:")
    assert "collision_monitor: off" in str(refused.value)
