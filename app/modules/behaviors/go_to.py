"""The desire class GoTo, which PlanAndFollowPath and GoToward serve, and their report of an arrival."""

from __future__ import annotations

from pydantic import BaseModel, Field

from app.attention.desires import DesireClass
from app.maps.places import LONGEST_ID, LONGEST_NAME
from app.maps.zones import FURTHEST_M
from app.modules.behaviors.accomplishment_reporter import AccomplishmentReporter
from app.modules.behaviors.navigation.tracking.desired_goal import goal_of
from app.modules.behaviors.navigation.tracking.path_tracker import NavigationGoal


class GoToParameters(BaseModel, extra="forbid", title="Go to a place", allow_inf_nan=False):
    x: float = Field(ge=-FURTHEST_M, le=FURTHEST_M, title="x", description="Where to, in metres on the map.")
    y: float = Field(ge=-FURTHEST_M, le=FURTHEST_M, title="y", description="Where to, in metres on the map.")
    heading: float | None = Field(
        None, ge=-7, le=7, title="Heading", description="How to stand there, in rad on the map; none: any way."
    )
    tolerance_m: float = Field(
        0.25, ge=0.05, le=5, title="Near enough", description="So many metres from there will do."
    )
    tolerance_rad: float = Field(
        0.2, ge=0.05, le=3.2, title="Turned enough", description="So many rad from the heading will do."
    )
    speed: float = Field(1.0, gt=0, le=1, title="Speed", description="Share of the robot's greatest speeds, 0 to 1.")
    place: str = Field(
        "",
        max_length=LONGEST_ID,
        title="Place",
        description="Id of the place of the map that this is; over REST it may be given alone, without coordinates.",
    )
    name: str = Field("", max_length=LONGEST_NAME, title="Name", description="What people call it.")


GO_TO = DesireClass(
    name="GoTo",
    title="Go to a place",
    description="Drive to a place on the map, around obstacles; the desire ends with the arrival.",
    parameters=GoToParameters,
    achievement=True,
)


def report_arrival(reporter: AccomplishmentReporter, goal: NavigationGoal, reason: str) -> None:
    """Report that ``goal`` is reached, for every desire of exactly that goal.

    ``reason`` is the path tracker's: why the robot is only as near as could be, "" where it is there. May be called in
    every cycle after the arrival.
    """
    words = f"arrived; {reason}" if reason else f"arrived at ({goal.pose.x:.2f}, {goal.pose.y:.2f})"
    reporter.report("done", words, lambda desire: goal_of(desire.params, goal) is goal)
