"""A program in the simulated world, with the world's ground truth for measurements."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from app.base import paths
from app.base.errors import ConfigError
from app.experiments.world_run import able
from app.program.config import Configuration, load_configuration
from app.program.system import System
from app.robots.config import RobotConfig
from app.robots.factory import create_link, create_lockstep, load_body
from app.robots.simulated.link import SimulatedLink
from app.robots.simulated.lockstep import LockstepLink
from app.runtime.clock import RealClock, VirtualClock


@dataclass(frozen=True, slots=True)
class SimulatedProgram:
    """A ``configuration``, its ``body`` with ground truth, and the ``scenario`` of its world."""

    configuration: Configuration
    body: RobotConfig
    scenario: Path

    def system(self) -> tuple[System, SimulatedLink]:
        """A program, as context manager, and its body. Raises ConfigError."""
        clock = RealClock()
        link = create_link(self.body, clock.offset)
        assert isinstance(link, SimulatedLink)
        return System(self.configuration, link=link, body=self.body, clock=clock), link

    def virtual_system(self, *, recorded: bool) -> tuple[System, LockstepLink]:
        """A program, as context manager, on a loop of virtual time, with its body and all sensors in step.

        Only if ``recorded`` it has Recorders. Raises ConfigError.
        """
        clock = VirtualClock(float(round(RealClock().now())))
        link = create_lockstep(self.body, clock, cameras=True, microphones=True)
        configuration = able(self.configuration, link, recorders=recorded)
        system = System(configuration, link=link, body=self.body, clock=clock, partial=True, reproducible=True)
        return system, link


def simulated_body(configuration: Configuration) -> RobotConfig:
    """The program's body. Raises ConfigError for one that is not simulated."""
    robot = configuration.path(configuration.program.robot)
    body = load_body(robot)
    if not isinstance(body, RobotConfig):
        raise ConfigError("is no simulated robot, and experiments need a world whose truth is known", str(robot))
    return body


def simulated_program(config: Path | None = None, scenario: Path | None = None) -> SimulatedProgram:
    """The program of ``config`` (default: the lab) in ``scenario`` (default: the trial). Raises ConfigError."""
    configuration = load_configuration(config or paths.config_dir() / "lab.yaml")
    body = simulated_body(configuration)
    scenario = (scenario or paths.config_dir() / "scenarios" / "trial.yaml").resolve()
    return SimulatedProgram(
        configuration, body.model_copy(update={"scenario": scenario, "ground_truth": True}), scenario
    )
