"""The lab's configuration against the modules it names: class paths, ports, types, strategies and parameters."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import pytest

from app.attention.desires import DesireClass, Source
from app.attention.problem import SelectionProblem
from app.attention.solver import solve
from app.attention.strategies import Strategy, StrategyTable
from app.attention.strategy_file import load_strategies
from app.attention.workspace import IntentionWorkspace
from app.base.yaml_source import load_yaml
from app.link import RobotLink
from app.modules.motivations.scenario_coordinator import USUAL
from app.modules.motivations.tour_guide.perceptions import perceptions
from app.program.config import load_configuration
from app.program.desire_classes import desire_classes
from app.runtime.channel_table import ChannelSpec
from app.runtime.clock import VirtualClock, run_virtual
from app.runtime.graph import Graph, ModuleSpec
from app.tours.tour_file import load_tour
from tests.modules.actuation.arms import link
from tests.modules.motivations.tour_guide.run import Run

CONFIG = Path(__file__).parents[2] / "config"
CLASSES = desire_classes(load_configuration(CONFIG / "lab.yaml"))


def lab_graph() -> Graph:
    lab = load_yaml(CONFIG / "lab.yaml").data
    channels = load_yaml(CONFIG / "channels.yaml").data
    clock = VirtualClock()
    return Graph(
        clock=clock,
        channels={name: ChannelSpec.model_validate(spec) for name, spec in channels.items()},
        modules={name: ModuleSpec.model_validate(spec) for name, spec in lab["modules"].items()},
        services={
            RobotLink: link(),
            IntentionWorkspace: IntentionWorkspace(CLASSES, clock.now),
        },
    )


@pytest.fixture(scope="module")
def table() -> StrategyTable:
    return load_strategies([CONFIG / "strategies" / "lab.yaml"], classes=CLASSES, ports=lab_graph().ports())


def test_every_class_has_strategies_and_every_strategy_can_be_attended(table: StrategyTable) -> None:
    assert set(table.classes) == set(CLASSES)
    graph = lab_graph()

    async def main() -> None:
        graph.attend(table.filters)

    run_virtual(main())


def of_class(table: StrategyTable, cls: str) -> list[Strategy]:
    return [strategy for strategy in table.strategies if strategy.cls == cls]


@pytest.mark.parametrize("cls", ["FindQRCodes", "Telepresence"])
def test_half_the_rate_is_half_the_utility_and_half_the_cost(table: StrategyTable, cls: str) -> None:
    full, *rest = of_class(table, cls)
    assert min(full.filters.values()) == 1
    # As many scans at any rate: an image is placed by one that is no older than 0.1 s, however few images there are.
    constant = {"QRCodeDetector.scans"}
    for strategy in rest:
        divisor = min(phi for port, phi in strategy.filters.items() if port not in constant)
        assert strategy.filters == {
            port: share if port in constant else divisor * share for port, share in full.filters.items()
        }
        assert strategy.utility == full.utility / divisor
        assert strategy.costs["cpu"] == pytest.approx(full.costs["cpu"] / divisor)
        assert strategy.name == full.name.replace("-1", f"-{divisor:.0f}")


@pytest.mark.parametrize(("fine", "full_utility"), [(True, 8), (False, 4)])
def test_faces_are_looked_for_finely_or_not_in_both_cameras_at_each_rate(
    table: StrategyTable, fine: bool, full_utility: float
) -> None:
    strategies = [s for s in of_class(table, "LocateFaces") if s.parameters["FaceDetector"] == {"fine": fine}]
    assert len(strategies) == (4 if fine else 3), "none so weak that nobody's desire is fulfilled"
    full = strategies[0].costs["cpu"]
    for strategy, divisor in zip(strategies, (1, 2, 4, 8), strict=False):
        assert strategy.name.endswith(f"-{divisor}")
        assert strategy.filters == {"FaceDetector.images": divisor, "FaceDetector.panorama": divisor}
        assert strategy.utility == full_utility / divisor
        assert strategy.costs["cpu"] == pytest.approx(full / divisor)


def test_voices_are_located_at_full_rate_by_more_microphones_or_fewer(table: StrategyTable) -> None:
    strategies = of_class(table, "LocateVoices")
    assert all(strategy.filters == {"VoiceLocalizer.audio": 1} for strategy in strategies), "they exclude each other"
    parameters = [strategy.parameters["VoiceLocalizer"] for strategy in strategies]
    assert [(p["microphones"], p["separation"]) for p in parameters] == [(8, True), (8, False), (4, False), (2, False)]
    for better, worse in pairwise(strategies):
        assert better.utility > worse.utility
        assert better.costs["cpu"] > worse.costs["cpu"]


def test_full_rate_for_all_does_not_fit_but_each_alone_does(table: StrategyTable) -> None:
    full = {cls: of_class(table, cls)[0].costs.get("cpu", 0.0) for cls in table.classes}
    capacity = table.capacities()["cpu"]
    assert capacity < sum(full.values())
    # Faces in every full picture of both cameras are for a larger computer.
    assert max(cost for cls, cost in full.items() if cls != "LocateFaces") <= capacity
    assert min(strategy.costs["cpu"] for strategy in of_class(table, "LocateFaces")) <= capacity


def test_while_voices_are_located_faces_are_looked_for_half_as_often(table: StrategyTable) -> None:
    workspace = IntentionWorkspace(CLASSES, lambda: 0.0)

    def chosen() -> set[str]:
        selection = solve(SelectionProblem(workspace.strongest(), table.strategies, table.capacities()))
        return {name for name in selection.strategies if name != "drive-by-hand"}

    for cls in ("FindQRCodes", "LocateFaces", "DetectNoises", "Teleoperation", "Telepresence"):
        workspace.add(cls, intensity=4 if cls == "Telepresence" else 8, utility=1, source=Source("operator", "ada"))
    assert chosen() == {"find-qr-codes-1", "locate-near-faces-1", "detect-noises", "telepresence-1"}
    workspace.add("LocateVoices", intensity=8, utility=1, source=Source("operator", "ada"))
    assert chosen() == {
        "find-qr-codes-1", "locate-near-faces-2", "detect-noises", "telepresence-1", "locate-voices-8-separated",
    }  # fmt: skip


def test_going_somewhere_pulls_in_slam_and_gets_cheaper_where_the_computer_is_wanted_for_more(
    table: StrategyTable,
) -> None:
    workspace = IntentionWorkspace(CLASSES, lambda: 0.0)

    def chosen(capacity: float) -> set[str]:
        capacities = {**table.capacities(), "cpu": capacity}
        return set(solve(SelectionProblem(workspace.strongest(), table.strategies, capacities)).strategies)

    workspace.add("GoTo", intensity=8, utility=1, params={"x": 1, "y": 2}, source=Source("operator", "ada"))
    assert chosen(40) == {"plan-and-follow-1", "slam-40"}, "nobody desires SLAM, but a pose is needed"
    ways = [next(name for name in chosen(capacity) if not name.startswith("slam")) for capacity in (40, 12.6, 9, 5)]
    assert ways == ["plan-and-follow-1", "plan-and-follow-2", "plan-and-pursue-4", "go-toward"]


def test_no_way_to_map_is_worse_and_costs_more_than_another_and_the_thesiss_rate_is_among_them(
    table: StrategyTable,
) -> None:
    strategies = of_class(table, "SLAM")
    by_cost = sorted(strategies, key=lambda strategy: strategy.costs["cpu"])
    for cheaper, dearer in pairwise(by_cost):
        assert cheaper.costs["cpu"] < dearer.costs["cpu"]
        assert cheaper.utility < dearer.utility
    assert 40 in {strategy.filters["SLAM2D.scans"] for strategy in strategies}
    sparse = [strategy for strategy in strategies if strategy.parameters]
    assert {strategy.parameters["SLAM2D"]["rays"] for strategy in sparse} == {3}
    full = {strategy.filters["SLAM2D.scans"]: strategy for strategy in strategies if not strategy.parameters}
    for strategy in sparse:
        assert strategy.costs["cpu"] < full[strategy.filters["SLAM2D.scans"]].costs["cpu"]


def test_what_is_desired_at_the_start_is_all_served(table: StrategyTable) -> None:
    workspace = IntentionWorkspace(CLASSES, lambda: 0.0)
    for desire in USUAL:
        workspace.add(
            desire.cls, intensity=desire.intensity, utility=desire.utility, security=desire.security,
            source=Source("motivation", "start"),
        )  # fmt: skip
    chosen = solve(SelectionProblem(workspace.strongest(), table.strategies, table.capacities())).strategies
    assert {table[name].cls for name in chosen} == {desire.cls for desire in USUAL}
    assert "slam-1" in chosen


@pytest.mark.parametrize("cls", ["Teleoperation", "Rest"])
def test_driving_by_hand_and_lowering_an_arm_cost_nothing(table: StrategyTable, cls: str) -> None:
    assert not of_class(table, cls)[0].costs


@pytest.mark.parametrize("desire_class", CLASSES.values(), ids=lambda c: c.name)
def test_every_class_has_words_and_every_parameter_a_default_but_what_it_is_about(desire_class: DesireClass) -> None:
    assert desire_class.title
    assert desire_class.description.endswith(".")
    schema = desire_class.parameters.model_json_schema()
    required = schema.get("required", [])
    place: dict[str, object] = {"x": 1.0, "y": 1.0}
    text: dict[str, object] = {"text": "Hello."}
    question: dict[str, object] = {"question": "Why?"}
    heading: dict[str, object] = {"heading": 1.0}
    needed = dict.fromkeys(("GoTo", "PointAt", "Reach"), place)
    needed |= {"Say": text, "Ask": question, "RotateToHeading": heading}
    # A point or a place: neither alone is required.
    either: dict[str, dict[str, object]] = {"LookAt": place}
    values = needed.get(desire_class.name, {})
    assert required == list(values)
    defaults = desire_class.validated(values | either.get(desire_class.name, {}))
    for name, prop in schema.get("properties", {}).items():
        assert prop["description"].endswith("."), name
        assert name in defaults


def test_whatever_the_guide_wishes_can_be_desired_in_the_lab() -> None:
    tour, _ = load_tour(CONFIG / "tours" / "lab-tour.yaml")
    run, wished = Run(tour.model_copy(update={"home": "dock"})), set()
    run.started().see(towards=1.0)
    for state in ("confirming", "leading", "presenting", "listening", "parting", "going_home", "idle"):
        run.until(state).see(people=0, stuck_since=run.view.now - 30)
        for wish in (*run.wishes(), *perceptions(run.progress, run.scene)):
            CLASSES[wish.cls].validated(wish.params)
            wished.add(wish.cls)
        run.see(people=2)
    searching = Run(tour).started().until("leading").see(people=0, driven_m=6.0, behind=1.0, back=(1.0, 2.0))
    for state in ("waiting", "searching"):
        assert searching.progress.state == state
        for wish in (*searching.wishes(), *perceptions(searching.progress, searching.scene)):
            CLASSES[wish.cls].validated(wish.params)
        searching.see(after_s=10.0)
    assert wished >= {"GoTo", "RotateToHeading", "Say", "ListenForWords", "LocateFaces", "SLAM", "DetectNoises"}
