"""ExternalForceEstimator: forces on the hands, from the joints of the arms.

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ ExternalForceEstimator  in   joints  JointState with efforts (N m), 30 Hz               │
    │                         out  forces  ExternalForces (N in base_link), as joints come    │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

A hand none of whose joints feels more than ``least_nm`` has no force: friction, noise and the arm's own inertia, when
it speeds up, are below. A body that does not measure efforts gives none.
"""

from __future__ import annotations

from pydantic import Field

from app.base.errors import ConfigError
from app.base.kinematic_model import KinematicModel, load_model
from app.messages import ExternalForces, JointState
from app.modules.perception.external_force import felt_efforts, force_on
from app.modules.stream_module import robot_link
from app.runtime.errors import ModuleFailed
from app.runtime.module import Module, ModuleContext, Settings


class ExternalForceEstimatorSettings(Settings):
    """Settings of ExternalForceEstimator."""

    links: tuple[str, ...] = Field(
        min_length=1, description="links of the model at whose origins forces are looked for"
    )
    least_nm: float = Field(2.0, gt=0, description="what a joint must feel, N m")


class ExternalForceEstimator(Module):
    """Estimates the forces on links that joints with measured efforts carry."""

    title = "External force estimator"
    Settings = ExternalForceEstimatorSettings
    settings: ExternalForceEstimatorSettings

    _model: KinematicModel

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.joints = self.input("joints", JointState)
        self.forces = self.output("forces", ExternalForces)
        self.on(self.joints, self._estimate)
        self._before: JointState | None = None

    async def start(self) -> None:
        """Read the body's model. Raises ModuleFailed for a body without one of the links."""
        try:
            self._model = await self.compute(load_model, robot_link(self).description.model_path)
            for link in self.settings.links:
                self._model.pose(link)
        except ConfigError as failure:
            raise ModuleFailed(str(failure)) from None
        except KeyError as unknown:
            raise ModuleFailed(f"{self.name} cannot estimate a force: {unknown.args[0]}") from None

    async def _estimate(self, joints: JointState) -> None:
        before, self._before = self._before, joints
        if not joints.efforts:
            return
        positions = dict(zip(joints.names, joints.positions, strict=True))
        speeds: dict[str, float] = {}
        if before is not None and before.names == joints.names and before.stamp < joints.stamp:
            moved = zip(joints.names, joints.positions, before.positions, strict=True)
            speeds = {name: (now - then) / (joints.stamp - before.stamp) for name, now, then in moved}
        felt = felt_efforts(self._model, dict(zip(joints.names, joints.efforts, strict=True)), speeds)
        touched = [
            link
            for link in self.settings.links
            if any(abs(felt.get(name, 0.0)) > self.settings.least_nm for name in self._model.moved_by(link))
        ]
        forces = (force_on(self._model, link, positions, felt) for link in touched)
        self.forces.publish(ExternalForces(joints.stamp, tuple(force for force in forces if force is not None)))
