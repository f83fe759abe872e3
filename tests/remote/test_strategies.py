"""Strategies for modules elsewhere, and where the solver lets them run."""

from __future__ import annotations

from app.attention.problem import SelectionProblem
from app.attention.solver import solve
from app.attention.strategies import CLOSED, Resource, Strategy, StrategyTable, exclusive
from app.messages import Desire, Source
from app.remote.settings import NodeSettings
from app.remote.strategies import Elsewhere, Stream, differs, with_nodes

LOOK = Strategy(
    "look",
    "Faces",
    4.0,
    filters={"Faces.images": 2.0},
    parameters={"Faces": {"fine": True}, "Ego": {"gain": 2}},
    costs={"cpu": 60.0, "power": 3.0},
)
DRIVE = Strategy("drive", "Drive", 8.0, filters={"Teleop.twist": 1.0}, costs={"cpu": 1.0})
BOTH = Strategy("both", "Drive", 8.0, filters={"Teleop.twist": 1.0, "Faces.images": 1.0})
HOME = StrategyTable((LOOK, DRIVE, BOTH), {"cpu": Resource("cpu", 44.0), "power": Resource("power", 60.0)})


def node(name: str, **settings: object) -> Elsewhere:
    streams = {"Faces.images": Stream(15.0, 100e3, True), "Faces.odometry": Stream(100.0, 200.0, False)}
    return Elsewhere(name, NodeSettings.model_validate({"modules": ["Faces"], **settings}), streams)


def test_a_strategy_elsewhere_has_the_stand_ins_filters_and_closes_those_at_home() -> None:
    table = with_nodes(HOME, [node("desk", speed=2.0)])
    there = table["look@desk"]
    assert there.filters == {"Faces@desk.images": 2.0, "Faces.images": CLOSED}
    assert there.parameters == {"Faces@desk": {"fine": True}, "Ego": {"gain": 2}}
    assert there.utility == LOOK.utility
    # 7.5 images a second of 0.1 MB, and odometry: 0.77 MB/s; 6 ms for each image at home.
    assert there.costs == {"cpu": 4.5, "power": 3.0, "cpu@desk": 30.0, "bandwidth@desk": 0.77}
    assert table.resources["cpu@desk"].capacity == 100.0


def test_only_strategies_whose_filters_are_all_of_the_nodes_modules_go_there() -> None:
    names = [strategy.name for strategy in with_nodes(HOME, [node("desk")]).strategies]
    assert names == ["look", "drive", "both", "look@desk"]


def test_one_place_excludes_the_others() -> None:
    table = with_nodes(HOME, [node("desk"), node("attic")])
    home, desk, attic = table["look"], table["look@desk"], table["look@attic"]
    assert exclusive(home, desk)
    assert exclusive(home, attic)
    assert exclusive(desk, attic)


def _selected(table: StrategyTable, **capacities: float) -> tuple[str, ...]:
    source = Source("operator", "test")
    desire = Desire("d", "Faces", intensity=5.0, utility=1.0, security=False, params={}, source=source, created=0.0)
    problem = SelectionProblem({"Faces": desire}, table.strategies, {**table.capacities(), **capacities})
    return solve(problem).strategies


def test_the_solver_chooses_where() -> None:
    table = with_nodes(HOME, [node("desk")])
    assert _selected(table) == ("look@desk",)
    assert _selected(table, **{"cpu@desk": 0.0}) == ()
    assert _selected(table, **{"bandwidth@desk": 0.5}) == ()
    assert _selected(table, **{"cpu@desk": 0.0, "cpu": 100.0}) == ("look",)


def test_a_strategy_that_costs_nothing_goes_nowhere_without_its_computer() -> None:
    free = StrategyTable((Strategy("look", "Faces", 4.0, filters={"Faces.images": 1.0}),), HOME.resources)
    table = with_nodes(free, [node("desk")])
    assert table["look@desk"].costs["cpu@desk"] > 0


def test_sizes_that_hardly_differ_change_no_costs() -> None:
    assert not differs(None, 200e3)
    assert not differs(160e3, 200e3)
    assert not differs(240e3, 200e3)
    assert differs(400e3, 200e3)
    assert differs(100e3, 200e3)
