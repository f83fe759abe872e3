"""The desire for the dock: when it comes, how it grows, when it goes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from app.attention.desires import Desire, DesireClasses
from app.attention.timeline import Timeline
from app.attention.workspace import IntentionWorkspace
from app.messages import Accomplishment, BatteryState
from app.modules.behaviors.docking.desire_classes import DOCK
from app.modules.motivations.recharge import RechargeSettings, intensity_at
from app.runtime.clock import run_virtual
from tests.modules.fakes import Bench

MODULE = "app.modules.motivations.recharge:Recharge"
SETTINGS = RechargeSettings()


class Robot:
    """The module, and a battery at any charge."""

    def __init__(self, settings: Mapping[str, Any] | None = None) -> None:
        self.workspace = IntentionWorkspace(DesireClasses([DOCK]), lambda: self.bench.clock.now())
        self.timeline = Timeline(100, lambda: self.bench.clock.now())
        services = {IntentionWorkspace: self.workspace, Timeline: self.timeline}
        self.bench = Bench(MODULE, inputs={"battery": BatteryState}, services=services, settings=settings)

    async def at(self, charge: float, *, charging: bool = False) -> Desire | None:
        """The desire for the dock once the module has heard of this charge."""
        state = BatteryState(self.bench.clock.now(), charge, 24.0, -2.0, charging=charging, remaining_s=None)
        self.bench.feed("battery", state)
        await self.bench.clock.sleep(1.0)
        return self.workspace.wanted("Dock")


def test_it_comes_below_a_quarter_grows_as_the_charge_falls_and_goes_when_full() -> None:
    async def main() -> None:
        robot = Robot()
        async with robot.bench:
            assert await robot.at(0.26) is None
            first = await robot.at(0.24)
            assert first is not None
            assert (first.intensity, first.utility, first.source.kind) == (2.0, 1.0, "motivation")
            more = await robot.at(0.15)
            assert more is not None
            assert (more.id, more.intensity) == (first.id, 5.0)
            urgent = await robot.at(0.03)
            assert urgent is not None
            assert urgent.intensity == 8.0
            charging = await robot.at(0.5, charging=True)
            assert charging is not None
            assert charging.intensity == 2.0
            assert await robot.at(0.96, charging=True) is None
            assert await robot.at(0.94) is None

    run_virtual(main())


def test_a_dock_that_was_not_reached_asks_for_help_and_is_tried_again_later() -> None:
    async def main() -> None:
        robot = Robot({"again_s": 60})
        async with robot.bench:
            first = await robot.at(0.2)
            assert first is not None
            now = robot.bench.clock.now()
            robot.workspace.accomplish(Accomplishment(now, first.id, "Docking", "failed", "no dock is seen"))
            assert await robot.at(0.2) is None
            (event,) = robot.timeline.query(kinds={"battery"})
            assert event.text == "Could not dock: no dock is seen. Please help the robot to its dock"
            assert await robot.at(0.2) is None
            await robot.bench.clock.sleep(60.0)
            again = await robot.at(0.2)
            assert again is not None
            assert again.id != first.id

    run_virtual(main())


def test_one_that_people_withdraw_comes_again_later_and_it_takes_its_own_along() -> None:
    async def main() -> None:
        robot = Robot({"again_s": 60})
        async with robot.bench:
            first = await robot.at(0.2)
            assert first is not None
            robot.workspace.remove(first.id)
            assert await robot.at(0.2) is None
            await robot.bench.clock.sleep(60.0)
            assert await robot.at(0.2) is not None
        assert robot.workspace.wanted("Dock") is None

    run_virtual(main())


@given(charges=st.lists(st.floats(0, 1), min_size=1, max_size=30))
def test_intensity_is_of_the_scale_and_never_less_for_less_charge(charges: list[float]) -> None:
    intensity = 0.0
    for charge in charges:
        intensity = intensity_at(charge, intensity, SETTINGS)
        assert intensity == 0.0 or SETTINGS.least <= intensity <= SETTINGS.most
    wanted = [intensity_at(charge, SETTINGS.least, SETTINGS) for charge in sorted(charges)]
    assert wanted == sorted(wanted, reverse=True)


@pytest.mark.parametrize("wrong", [{"low": 0.96}, {"urgent": 0.3}, {"least": 8, "most": 4}])
def test_charges_that_do_not_rise_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ValidationError, match="must rise"):
        RechargeSettings(**wrong)
