"""A simulated body in the program's own process, whose world steps on the program's clock. On a ``VirtualClock`` a
whole program runs faster than real time and deterministically: time stops during computations, and the world steps (250
Hz, as in the link's process) between the program's callbacks. Guard, physics, odometry, laser, people and joints are
those of the link's process (``simulation.py``). For tests and experiments; ``hbba run`` uses the separate process, for
a guard in the program's own process protects from little.

    configuration = load_configuration(paths.config_dir() / "lab.yaml")
    body = load_body(configuration.path(configuration.program.robot))

    async def script(run: WorldRun) -> Pose2:
        run.link.command(Twist(run.system.clock.now(), 0.3, 0.0))     # or desires: run.system.workspace.add(...)
        await run.system.clock.sleep(0.2)                             # 50 turns of the world
        return run.link.true_pose()                                   # ground truth, for experiments only

    pose = run_in_world(configuration, body, script)                  # app.experiments.world_run

``kinect`` and ``panorama`` exist only with ``cameras``, and ``microphones`` only with ``microphones``: images and sound
are then rendered while time is stopped, and arrive with their step. The loudspeaker is heard by the microphones alone.
"""

from __future__ import annotations

import asyncio
import os
from typing import TYPE_CHECKING

from app.base.errors import ConfigError
from app.base.geometry import Pose2
from app.link import LinkFailed
from app.messages import Audio, JointCommand, PersonTruth, Twist
from app.robots.config import RobotConfig
from app.robots.simulated import link_protocol
from app.robots.simulated.camera_models import picture_formats
from app.robots.simulated.contacts import Contact
from app.robots.simulated.gl import GlUnavailable, check_gl, gl_environment
from app.robots.simulated.link import SimulatedBody
from app.robots.simulated.scenery.scenario_config import ScenarioConfig
from app.robots.simulated.world_config import WorldConfig
from app.runtime.clock import Clock

if TYPE_CHECKING:  # MuJoCo looks for its OpenGL library when it is imported
    from app.robots.simulated.lockstep_world import LockstepWorld


class LockstepLink(SimulatedBody):
    """Implements ``app.link.RobotLink`` for a robot in a world that steps on ``clock``."""

    def __init__(
        self,
        robot: RobotConfig,
        world: WorldConfig,
        clock: Clock,
        scenario: ScenarioConfig | None = None,
        *,
        cameras: bool = False,
        microphones: bool = False,
    ) -> None:
        super().__init__(without_threads(robot, cameras=cameras, microphones=microphones), world, scenario)
        self._clock = clock
        self._simulation: LockstepWorld | None = None
        self._turning: asyncio.Task[None] | None = None

    # Ground truth for tests and experiments; modules do not know this class.

    def true_pose(self) -> Pose2:
        """``X_WB`` now; the start before :meth:`start`."""
        return self._simulation.physics.true_pose() if self._simulation is not None else self.start_pose

    @property
    def people(self) -> tuple[PersonTruth, ...]:
        return self._simulation.scenario_state.people if self._simulation is not None else ()

    def let_pass(self) -> None:
        """The robot asks those who follow it to let it pass: what is said is heard by no person here."""
        if self._simulation is not None:
            self._simulation.scenario_state.let_pass()

    @property
    def contacts(self) -> tuple[Contact, ...]:
        """All contacts of the body with anything but the floor since :meth:`start`."""
        return self._simulation.contacts.found if self._simulation is not None else ()

    # app.link.RobotLink

    async def start(self) -> None:
        """Build the world and start it. Raises LinkFailed, having released everything."""
        if self._turning is not None:
            if not self._turning.done():
                raise LinkFailed("The simulated robot runs already.")
            await self.stop()
        if picture_formats(self._robot) and (problem := check_gl()):
            raise LinkFailed(problem)
        for name, value in gl_environment().items():
            os.environ.setdefault(name, value)
        # Building a world takes a second of real time, but no simulated time
        try:
            simulation = await asyncio.to_thread(self._build)
        except (ConfigError, GlUnavailable) as failure:
            raise LinkFailed(str(failure)) from None
        for stream, rate_hz in self._receivers.rates.items():
            simulation.demand(stream, rate_hz)
        if self._e_stop is not None:
            simulation.accept(link_protocol.EStopRequest(self._e_stop))
        self._simulation = simulation
        self._turning = asyncio.create_task(self._turn(self._simulation), name="world in lockstep")

    async def stop(self) -> None:
        turning, self._turning = self._turning, None
        simulation, self._simulation = self._simulation, None
        if turning is not None:
            turning.cancel()
            await asyncio.wait({turning})
        if simulation is not None:
            simulation.close()

    async def wait_failed(self) -> LinkFailed:
        if self._turning is None:
            return LinkFailed("The simulated robot was not started.")
        turning = self._turning
        await asyncio.wait({turning})
        error = None if turning.cancelled() else turning.exception()
        failure = LinkFailed(f"The simulated world stopped: {error or 'it was ended'}.")
        failure.__cause__ = error
        return failure

    def command(self, command: Twist | JointCommand) -> None:
        """Give a command."""
        self._send(link_protocol.request(command))

    def play(self, audio: Audio) -> None:
        """Play one frame through the loudspeaker, which a body with microphones has."""
        if self._simulation is not None:
            self._simulation.play(audio)

    def _send(self, frame: object) -> None:
        if self._simulation is not None:
            self._simulation.accept(frame)

    def _deliver(self, stream: str, message: object) -> None:
        periods = self._simulation.periods.get(stream, 1) if self._simulation is not None else 1
        self._receive(stream, message, periods)

    def _build(self) -> LockstepWorld:
        from app.robots.simulated.lockstep_world import LockstepWorld

        return LockstepWorld(self._robot, self._world, self._scenario, self._deliver)

    async def _turn(self, simulation: LockstepWorld) -> None:
        began, turns = self._clock.now(), 0
        while True:
            turns += 1
            await self._clock.sleep_until(began + turns * simulation.turn_s)
            simulation.lockstep(self._clock.now(), began)


def without_threads(robot: RobotConfig, *, cameras: bool, microphones: bool = False) -> RobotConfig:
    """``robot`` without cameras unless ``cameras``, without microphones and loudspeaker unless ``microphones``."""
    removed: dict[str, None] = {}
    if not microphones:
        removed |= {"microphones": None}
    if not cameras:
        removed |= {"kinect": None, "panorama": None}
    streams = robot.streams.model_copy(update=removed)
    loudspeaker = robot.loudspeaker if microphones else None
    return robot.model_copy(update={"streams": streams, "loudspeaker": loudspeaker, "guard_log": None})
