"""Contacts of the body with anything but the floor: ground truth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from app.base.geometry import Pose2

if TYPE_CHECKING:  # MuJoCo looks for its OpenGL library when it is imported
    from app.robots.simulated.body import RobotSimulation

APART_S = 0.5
"""Time (s) without contact after which a touch of the same object is a new contact."""
FLOOR = "floor"


@dataclass(frozen=True, slots=True)
class Contact:
    """The body began to touch ``what`` at ``stamp`` (robot's clock, s), standing at ``X_WB``.

    ``at``: where on the body's surface (m, world). ``what`` names the shape, or its body where it has no name: a wall,
    ``crate3.0``, ``person0/trunk``.
    """

    stamp: float
    what: str
    at: tuple[float, float, float]
    X_WB: Pose2


class ContactMonitor:
    """Records contacts of a simulation; call :meth:`look` every few steps: the shortest contact lasts longer."""

    def __init__(self, simulation: RobotSimulation) -> None:
        self._simulation = simulation
        model = simulation.model
        of_robot = model.body_rootid[model.geom_bodyid] == model.body_rootid[simulation.base_body]
        self._of_robot = of_robot
        self._obstacle = ~of_robot
        self._obstacle[model.geom(FLOOR).id] = False
        self._last: dict[int, float] = {}
        self._found: list[Contact] = []

    @property
    def found(self) -> tuple[Contact, ...]:
        """Contacts so far, in order."""
        return tuple(self._found)

    def look(self, stamp: float) -> None:
        """Record current contacts."""
        contacts = self._simulation.data.contact
        pairs = contacts.geom
        touching = self._obstacle[pairs] & self._of_robot[pairs[:, ::-1]]
        if not touching.any():
            return
        for index in np.flatnonzero(touching.any(axis=1)):
            geom = int(pairs[index][touching[index]][0])
            if stamp - self._last.get(geom, -np.inf) > APART_S:
                x, y, z = (float(v) for v in contacts.pos[index])
                self._found.append(Contact(stamp, self._name(geom), (x, y, z), self._simulation.true_pose()))
            self._last[geom] = stamp

    def _name(self, geom: int) -> str:
        model = self._simulation.model
        name = str(model.geom(geom).name)
        if name:
            return name
        body = str(model.body(int(model.geom_bodyid[geom])).name)
        return "a wall" if body == "world" else body
