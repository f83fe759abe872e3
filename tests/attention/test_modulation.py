"""Ignored desires are raised: bounded, back again, and without swinging, with attention's own decisions."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.attention.desires import Desire, effective
from app.attention.emotions import Effects, EmotionDynamics, Fates, strongest
from app.attention.modulation import STEP, ModulationLimits, Modulator
from app.attention.solver import solve
from app.attention.strategies import Strategy
from app.messages import Emotion, Modulation
from tests.attention import thesis
from tests.attention.setting import ME, RIVALS

BEAT_S = 2.0
ANGER = {cls: Effects({"anger": -0.02}, {"anger": 0.05}) for cls in ("GoTo", "Teleoperation")}
WHEELS = {"wheels": 1.0}


@dataclass
class Robot:
    """Feels, is raised and decides; all but ``blocked`` classes are exploited as soon as something is selected."""

    desires: tuple[Desire, ...]
    dynamics: EmotionDynamics
    modulator: Modulator | None
    strategies: tuple[Strategy, ...] = RIVALS.strategies
    capacities: Mapping[str, float] = field(default_factory=lambda: WHEELS)
    blocked: frozenset[str] = frozenset()
    now: float = 0.0
    raised: dict[str, Modulation] = field(default_factory=dict)
    selected: tuple[str, ...] = ()
    served: frozenset[str] = frozenset()
    _solved: object = None

    def beat(self) -> tuple[str, ...]:
        """One beat; what is selected then."""
        wanted = {
            cls: effective(msgspec.structs.replace(desire, modulation=self.raised.get(desire.id)))
            for cls, desire in strongest(self.desires).items()
        }
        asked = {cls: (desire.id, desire.intensity) for cls, desire in wanted.items()}
        if asked != self._solved:
            problem = thesis.problem(wanted.values(), self.strategies, self.capacities, self.selected)
            self.selected, self._solved = solve(problem).strategies, asked
            at_work = {each.cls for each in self.strategies if each.name in self.selected}
            self.served = frozenset(cls for cls, desire in wanted.items() if cls in at_work and desire.utility > 0)
        exploited = self.served - self.blocked
        positive = frozenset(cls for cls, desire in wanted.items() if desire.utility > 0)
        self.dynamics.advance(BEAT_S, Fates(exploited, positive - exploited))
        self.now += BEAT_S
        if self.modulator is not None:
            intended = [wanted[cls].id for cls in self.served]
            self.raised = self.modulator.update(self.now, self.desires, intended, self.dynamics.shares)
        return self.selected

    def run(self, seconds: float) -> list[tuple[str, ...]]:
        return [self.beat() for _ in range(round(seconds / BEAT_S))]


def rivals(**limits: float) -> Robot:
    """Two that want the same wheels; the goal is a little less desired."""
    desires = (thesis.desire("GoTo", 4), thesis.desire("Teleoperation", 5))
    return Robot(desires, EmotionDynamics(ANGER), Modulator(ModulationLimits(**limits)))


def switches(selections: list[tuple[str, ...]]) -> int:
    return sum(a != b for a, b in itertools.pairwise(selections))


def test_neglect_makes_room_for_a_desire_once_and_goes() -> None:
    robot = rivals()
    selections = robot.run(600)
    assert selections[0] == selections[-1] == ("teleop",)
    assert ("goto",) in selections
    assert switches(selections) == 2
    assert robot.raised == {}


def test_a_rise_is_bounded_visible_and_in_steps() -> None:
    robot = rivals(most=0.8)
    seen = set()
    for _ in range(100):
        robot.beat()
        seen |= {(cls, each.by, each.emotion) for cls, each in robot.raised.items()}
    assert seen == {("d-GoTo", by, "anger") for by in (STEP, 2 * STEP, 3 * STEP)}
    assert robot.selected == ("teleop",), "0.75 is not enough"


@pytest.mark.parametrize(("again_s", "more"), [(100, 2), (10_000, 0)])
def test_it_is_raised_again_only_after_desires_have_changed_and_a_while_has_gone_by(again_s: float, more: int) -> None:
    robot = rivals(again_s=again_s)
    assert switches(robot.run(600)) == 2
    assert switches(robot.run(2000)) == 0
    robot.desires = (*robot.desires, thesis.desire("DetectNoises", 1))
    assert switches(robot.run(600)) == more


def test_what_is_just_replaced_is_not_ignored_yet() -> None:
    robot = rivals(settle_s=30)
    robot.run(28)
    assert robot.dynamics.intensity("anger") > 0.8
    assert robot.raised == {}
    robot.run(4)
    assert robot.raised != {}


@pytest.mark.parametrize(("utility", "security"), [(0, False), (1, True)])
def test_inhibition_and_security_are_left_alone(utility: float, security: bool) -> None:
    desire = thesis.desire("GoTo", 4, utility, security=security)
    shares: dict[Emotion, dict[str, float]] = {"anger": {"GoTo": 1.0}}
    modulator = Modulator()
    assert all(modulator.update(now, [desire], [], shares) == {} for now in range(0, 100, 10))
    assert effective(msgspec.structs.replace(desire, modulation=Modulation(2.0, "anger"))).intensity == 4


def test_a_weaker_desire_of_a_class_is_not_raised_and_joy_raises_nothing() -> None:
    weak, strong = (Desire(id_, "GoTo", i, 1, False, {}, ME, 0.0) for id_, i in (("weak", 3), ("strong", 4)))
    modulator = Modulator()
    for now in (0.0, 10.0):
        raised = modulator.update(now, [weak, strong], [], {"anger": {"GoTo": 0.6}, "joy": {"GoTo": 1.0}})
    assert raised == {"strong": Modulation(1.0, "anger")}
    modulator.clear()
    assert modulator.update(20.0, [weak, strong], [], {"anger": {"GoTo": 1.0}}) == {}


#: The thesis's, with wheels that only one may turn.
TABLE = tuple(
    replace(each, costs={**each.costs, "wheels": 1}) if each.cls in ANGER else each for each in thesis.TABLE_4_4
)
CLASSES = tuple(dict.fromkeys(strategy.cls for strategy in TABLE))
WANTED = ("GoTo", "Teleoperation", "LocateVoices", "LocateFaces")
#: Not so unlike that a rise makes no difference.
whim = st.tuples(st.floats(3, 5), st.sampled_from([1.0, 1.0, 4.0, 8.0, 0.0]), st.integers(0, 9).map(lambda n: n == 9))
whims = st.fixed_dictionaries(dict.fromkeys(WANTED, whim), optional={cls: whim for cls in CLASSES if cls not in WANTED})
effects = st.builds(
    lambda gain, loss, emotion: Effects({emotion: -loss}, {emotion: gain}),
    st.floats(0.01, 0.1), st.floats(0.005, 0.1), st.sampled_from(["anger", "sadness", "fear"]),
)  # fmt: skip


@settings(max_examples=40, deadline=None)
@given(
    whims,
    whims,
    st.fixed_dictionaries(dict.fromkeys(CLASSES, effects)),
    st.frozensets(st.sampled_from(CLASSES), max_size=2),
    st.floats(1, 8),
    st.floats(40, 120),
)
def test_whatever_is_desired_selections_settle(
    first: Mapping[str, tuple[float, float, bool]],
    then: Mapping[str, tuple[float, float, bool]],
    table: Mapping[str, Effects],
    blocked: frozenset[str],
    most: float,
    cpu: float,
) -> None:
    """After a change of desires, nothing changes for good: not the selection, and what is raised only falls."""

    def desires(of: Mapping[str, tuple[float, float, bool]]) -> tuple[Desire, ...]:
        return tuple(thesis.desire(cls, round(i, 3), u, security=z) for cls, (i, u, z) in of.items())

    robot = Robot(
        desires(first),
        EmotionDynamics(table, 0.002),
        Modulator(ModulationLimits(most, settle_s=4, again_s=10)),
        TABLE,
        {"cpu": round(cpu, 1), **WHEELS},
        blocked,
    )
    robot.run(60)
    robot.desires = desires(then)
    selections = robot.run(1600)
    assert all(0 < each.by <= most for each in robot.raised.values())
    # Each class rises once, without effect until it is selected, and falls in so many steps.
    assert switches(selections) <= len(then) * (most / STEP + 2)
    assert switches(selections[-300:]) == 0
