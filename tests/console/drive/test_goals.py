"""What ends when people stop the robot."""

from __future__ import annotations

from app.attention.desires import DesireClasses, Source
from app.attention.workspace import IntentionWorkspace
from app.console.drive.goals import withdraw, withdraw_all
from app.modules.behaviors.docking.desire_classes import DOCK, UNDOCK
from app.modules.behaviors.go_to import GO_TO
from app.modules.motivations.curiosity.curiosity import EXPLORE

ROBOT, ADA = Source("motivation", "Recharge"), Source("operator", "Ada")


def workspace() -> IntentionWorkspace:
    made = IntentionWorkspace(DesireClasses([GO_TO, DOCK, UNDOCK, EXPLORE]), lambda: 0.0)
    for source in (ROBOT, ADA):
        made.add("GoTo", intensity=1, utility=1, params={"x": 1, "y": 1}, source=source)
        made.add("Dock", intensity=1, utility=1, source=source)
        made.add("Undock", intensity=1, utility=1, source=source)
        made.add("Explore", intensity=1, utility=1, source=source)
    made.add("Dock", intensity=1, utility=0, source=ADA)
    return made


def left(made: IntentionWorkspace) -> list[tuple[str, str, float]]:
    return [(desire.cls, desire.source.kind, desire.utility) for desire in made.desires()]


def test_a_goal_that_is_cancelled_takes_docking_and_exploring_along_also_the_robots_own() -> None:
    made = workspace()
    withdraw(made)
    assert left(made) == [("GoTo", "motivation", 1.0), ("Dock", "operator", 0.0)]


def test_an_emergency_stop_ends_everything_that_drives() -> None:
    made = workspace()
    withdraw_all(made)
    assert left(made) == [("Dock", "operator", 0.0)]
