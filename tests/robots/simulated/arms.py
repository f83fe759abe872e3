"""A simulated body whose arms are commanded, stepped by hand through its own guard: no process, no camera."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from app.messages import GroupStatus, JointCommand
from app.robots.config import RobotConfig
from app.robots.simulated.body import TIMESTEP_S, build_simulation
from app.robots.simulated.joint_servos import JointServos
from app.robots.simulated.odometry import TrueBase
from app.robots.simulated.simulation import STEPS_PER_TURN
from app.robots.simulated.world_config import WorldConfig

LEFT_ARM = ("left_shoulder_pitch_joint", "left_shoulder_roll_joint", "left_upper_arm_joint", "left_elbow_joint")
#: The hand in front and aside, the elbow bent.
BENT = (-0.5, 0.3, 0.2, -0.9)


class Arms:
    """The body ``robot`` in ``world``, with the physics' own clock."""

    def __init__(self, robot: RobotConfig, world: WorldConfig) -> None:
        self.physics = build_simulation(robot, world, TrueBase(0.10, 0.10, 0.44))
        self.servos = JointServos(self.physics, robot.groups.values())
        self.e_stop: str | None = None
        #: Force (N, in the world) at the middle of the left hand, where it holds things.
        self.force: NDArray[np.float64] = np.zeros(3)

    @property
    def now(self) -> float:
        return self.physics.time_s

    def run(self, seconds: float, *commands: JointCommand, each: Callable[[], None] = lambda: None) -> None:
        """Step, with ``commands`` given afresh at every decision of the guard; ``each`` is called then."""
        for _ in range(round(seconds / (STEPS_PER_TURN * TIMESTEP_S))):
            for given in commands:
                self.servos.accept(
                    JointCommand(
                        self.now, given.group, given.names, given.positions, stiffness=given.stiffness,
                        damping=given.damping,
                    )
                )  # fmt: skip
            self.servos.decide(self.now, self.e_stop)
            self.servos.step()
            for _ in range(STEPS_PER_TURN):
                self._push()
                self.physics.step()
            each()

    def positions(self) -> Mapping[str, float]:
        """True positions (rad, m) of the joints by name."""
        return dict(zip(self.physics.joints, self.physics.joint_positions().tolist(), strict=True))

    def hand(self) -> NDArray[np.float64]:
        """The left hand's place (3,) in the world (m)."""
        return self.physics.data.body("robot/left_hand_link").xpos.copy()

    def status(self, group: str) -> GroupStatus:
        """The guard's state of ``group``."""
        return next(status for status in self.servos.status(self.now) if status.group == group)

    def _push(self) -> None:
        body = self.physics.model.body("robot/left_forearm_link").id
        data = self.physics.data
        data.xfrc_applied[body, :3] = self.force
        data.xfrc_applied[body, 3:] = np.cross(self.hand() - data.xipos[body], self.force)


def left_arm(
    positions: tuple[float, ...] = BENT, stiffness: float | None = None, damping: float | None = None
) -> JointCommand:
    """A command to the left arm, its four joints alike."""
    return JointCommand(
        0.0, "left_arm", LEFT_ARM, positions, stiffness=() if stiffness is None else (stiffness,) * 4,
        damping=() if damping is None else (damping,) * 4,
    )  # fmt: skip
