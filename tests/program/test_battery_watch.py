"""Events of the battery and the capacity of power that follows its charge: values alone."""

from __future__ import annotations

import pytest

from app.attention.timeline import Timeline
from app.messages import BatteryState
from app.program.battery_watch import BatteryWatch
from app.program.config import PowerConfig

POWER = PowerConfig(full_w=60, empty_w=20, from_charge=0.5)


class Watched:
    def __init__(self, power: PowerConfig | None = POWER) -> None:
        self.timeline = Timeline(100, lambda: 0.0)
        self.capacities: list[tuple[str, float, str]] = []
        self.watch = BatteryWatch(self.timeline, power, lambda *change: self.capacities.append(change))

    def take(self, *charges: float, charging: bool = False) -> None:
        for charge in charges:
            self.watch.take(BatteryState(1.0, charge, 24.0, 0.0, charging=charging, remaining_s=60.0))

    @property
    def events(self) -> list[str]:
        return [event.subject for event in self.timeline.query(kinds={"battery"})]


def test_each_level_is_noted_once_as_the_charge_falls_though_it_wavers() -> None:
    watched = Watched()
    watched.take(0.5, 0.31, 0.299, 0.301, 0.298, 0.2, 0.149, 0.151, 0.148)
    assert watched.events == ["low", "very low"]
    texts = [event.text for event in watched.timeline.query(kinds={"battery"})]
    assert texts == ["The battery is low: 30 %", "The battery is very low: 15 %"]


def test_a_level_is_noted_again_after_the_charge_has_risen() -> None:
    watched = Watched()
    watched.take(0.29)
    watched.take(0.29, 0.5, charging=True)
    watched.take(0.5, 0.29)
    assert watched.events == ["low", "charging", "discharging", "low"]


def test_a_battery_that_begins_very_low_is_one_event() -> None:
    watched = Watched()
    watched.take(0.1, 0.09)
    assert watched.events == ["very low"]


def test_a_full_battery_is_noted_once() -> None:
    watched = Watched()
    watched.take(0.98)
    watched.take(0.98, 0.995, 1.0, 1.0, charging=True)
    assert watched.events == ["charging", "full"]


@pytest.mark.parametrize(
    ("charge", "charging", "watts"),
    [(1.0, False, 60), (0.5, False, 60), (0.25, False, 40), (0, False, 20), (0, True, 60)],
)
def test_power_falls_with_the_charge_unless_it_charges(charge: float, charging: bool, watts: float) -> None:
    watched = Watched()
    watched.take(charge, charging=charging)
    ((resource, capacity, why),) = watched.capacities
    assert (resource, capacity) == ("power", watts)
    assert f"{round(100 * charge)} %" in why


def test_the_capacity_is_set_only_when_the_charge_has_changed_noticeably() -> None:
    watched = Watched()
    watched.take(*(0.4 - 0.001 * step for step in range(45)))
    capacities = [capacity for _, capacity, _ in watched.capacities]
    assert capacities == pytest.approx([52.0, 50.4, 48.8], abs=0.2)


def test_without_a_budget_of_power_there_are_events_alone() -> None:
    watched = Watched(None)
    watched.take(0.1)
    assert watched.events == ["very low"]
    assert not watched.capacities
