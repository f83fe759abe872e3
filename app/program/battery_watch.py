"""The battery's effects on attention and on the timeline: the capacity of power follows its charge, and what people
should know of it is an event."""

from __future__ import annotations

from collections.abc import Callable

from app.attention.timeline import Timeline
from app.messages import BatteryState
from app.program.config import PowerConfig

LOW, VERY_LOW = 0.30, 0.15
"""Charges below which people are warned."""
FULL = 0.99
STEP = 0.02
"""Change of the charge that changes the capacity, and that a charge must rise by to be warned of again."""

SetCapacity = Callable[[str, float, str], None]


class BatteryWatch:
    """Takes the states of one battery; each level below which people are warned is noted once."""

    def __init__(self, timeline: Timeline, power: PowerConfig | None, set_capacity: SetCapacity) -> None:
        """``set_capacity(resource, watts, reason)`` changes the capacity of a resource."""
        self._timeline = timeline
        self._power = power
        self._set_capacity = set_capacity
        self.reset()

    def reset(self) -> None:
        """Time has jumped: what is known is of another time."""
        self._before: BatteryState | None = None
        self._warned: set[float] = set()
        self._full = False
        self._budgeted: tuple[float, bool] | None = None

    def take(self, state: BatteryState) -> None:
        """Note what has changed, and set the capacity of power."""
        before, self._before = self._before, state
        if before is not None and state.charging != before.charging:
            self._note("charging" if state.charging else "discharging", state)
        for level in (VERY_LOW, LOW):
            if state.charge >= level + STEP:
                self._warned.discard(level)
            elif state.charge < level and level not in self._warned and not state.charging:
                # Below both at once, as at the start, the lower alone is worth a word.
                self._warned |= {each for each in (VERY_LOW, LOW) if state.charge < each}
                self._note("very low" if level == VERY_LOW else "low", state)
        full = state.charging and state.charge >= FULL
        if full and not self._full:
            self._note("full", state)
        self._full = full
        self._budget(state)

    def _note(self, what: str, state: BatteryState) -> None:
        level = _percent(state)
        text = {
            "charging": f"The battery is being charged, from {level}",
            "discharging": f"The battery is no longer charged, at {level}",
            "low": f"The battery is low: {level}",
            "very low": f"The battery is very low: {level}",
            "full": "The battery is full",
        }[what]
        data = {"charge": round(state.charge, 3), "charging": state.charging, "remaining_s": state.remaining_s}
        self._timeline.add("battery", what, text, data, stamp=state.stamp)

    def _budget(self, state: BatteryState) -> None:
        if self._power is None:
            return
        known = self._budgeted
        if known is not None and known[1] == state.charging and abs(known[0] - state.charge) < STEP:
            return
        self._budgeted = state.charge, state.charging
        watts = round(self._power.capacity_w(state.charge, charging=state.charging), 1)
        why = f"the battery is {'being charged, ' if state.charging else ''}at {_percent(state)}"
        self._set_capacity(self._power.resource, watts, why)


def _percent(state: BatteryState) -> str:
    return f"{round(100 * state.charge)} %"
