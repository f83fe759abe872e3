"""Settings of behaviors that drive on the map around obstacles: PlanAndFollowPath and Follow."""

from __future__ import annotations

from pydantic import Field

from app.modules.behaviors.navigation.costmap.inflation import CostSettings
from app.modules.behaviors.navigation.costmap.local_costmap import CostmapSettings
from app.modules.behaviors.navigation.recovery.recovery_behaviors import RecoverySettings
from app.modules.behaviors.navigation.tracking.control_cycle import CONTROLLERS, ControlCycleSettings
from app.modules.behaviors.navigation.tracking.path_tracker import PathTrackerSettings
from app.runtime.module import Settings


class PlanAndFollowPathSettings(Settings):
    """Settings of PlanAndFollowPath; they depend on the body's speed, while its sizes and limits come from the body."""

    period_s: float = Field(0.1, gt=0, le=0.2, description="one control cycle")
    controller: str = Field(
        "mppi", pattern=f"^({'|'.join(CONTROLLERS)})$", description="unless the strategy gives another"
    )
    fresh_s: float = Field(0.3, gt=0, le=1, description="greatest age of a scan or image to drive by")
    replan_s: float = Field(1.0, gt=0, le=10, description="period of planning")
    blocked_replan_s: float = Field(
        0.3, gt=0, le=10, description="period of planning while an obstacle blocks the path"
    )
    costmap_m: float = Field(4.0, ge=2, le=20, description="side of the costmap around the robot")
    costmap_resolution_m: float = Field(0.025, ge=0.01, le=0.1)
    keep_s: float = Field(45.0, gt=0, description="how long an unseen stationary obstacle is kept")
    unknown: str = Field("costly", pattern="^(free|costly|blocked)$", description="cost of paths through unknown space")
    closeness: float = Field(
        6.0, ge=0, description="surcharge per metre of path beside an obstacle, in metres of open floor"
    )
    reach_m: float = Field(0.75, gt=0, le=3, description="distance beyond which an obstacle adds no cost")
    stuck_s: float = Field(2.0, gt=0, description="time without progress before recovery")
    wait_s: float = Field(2.0, ge=0, description="duration of the first recovery action, waiting")
    ask_s: float = Field(15.0, gt=0, description="time for people to help before the next round of recovery")
    corner_share: float = Field(0.6, gt=0, le=1, description="share of the speed beside blind corners; 1: no reduction")
    people_m: float = Field(
        0.0, ge=0, le=0.3, description="radius kept clear around leg candidates that the map does not have; 0: none"
    )
    taken_s: float = Field(
        30.0, ge=0, description="time for a goal where something stands that the map does not have to go; 0: no wait"
    )
    rounds: int = Field(2, ge=1, description="rounds of all recovery actions before people are asked")

    def of_control_cycle(self) -> ControlCycleSettings:
        """What the control cycle takes of them."""
        return ControlCycleSettings(
            costmap=CostmapSettings(
                size_m=self.costmap_m,
                memory_m=max(8.0, 1.5 * self.costmap_m),
                resolution_m=self.costmap_resolution_m,
                keep_s=self.keep_s,
            ),
            path_tracker=PathTrackerSettings(corner_share=self.corner_share, taken_s=self.taken_s),
            recovery=RecoverySettings(stuck_s=self.stuck_s, wait_s=self.wait_s, rounds=self.rounds, ask_s=self.ask_s),
            fresh_s=self.fresh_s,
            people_m=self.people_m,
        )

    def of_costs(self) -> CostSettings:
        """What planners take of them."""
        return CostSettings(unknown=self.unknown, closeness=self.closeness, reach_m=self.reach_m)
