"""The world of a body in lockstep: turned by its caller, pictures drawn and sound made while the caller waits."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from app.messages import Image
from app.robots.config import RobotConfig
from app.robots.simulated.acoustics.microphone_array import Ear
from app.robots.simulated.acoustics.soundscape import SCENES_HZ, Soundscape
from app.robots.simulated.body import TIMESTEP_S
from app.robots.simulated.camera_models import lenses, picture_formats
from app.robots.simulated.camera_rendering import Eye, open_eyes
from app.robots.simulated.contacts import ContactWatch
from app.robots.simulated.renderer import Painter
from app.robots.simulated.scenery.scenario_config import ScenarioConfig
from app.robots.simulated.simulation import STEPS_PER_TURN, LivingWorld, Schedule
from app.robots.simulated.world_config import WorldConfig


class LockstepWorld(LivingWorld):
    """A living world whose steps are due when ``now`` says so; see :class:`LivingWorld` for what it raises."""

    turn_s = STEPS_PER_TURN * TIMESTEP_S

    def __init__(
        self,
        robot: RobotConfig,
        world: WorldConfig,
        scenario: ScenarioConfig | None,
        send: Callable[[str, object], None],
    ) -> None:
        super().__init__(robot, world, scenario, send)
        self.contacts = ContactWatch(self.simulation)
        self._steps = 0
        self._lenses = lenses(robot)
        self._formats = picture_formats(robot)
        self._painter: Painter | None = None
        self._open: dict[str, Eye] = {}
        self._ear: Ear | None = None
        self._scenes = Schedule(SCENES_HZ)

    def lockstep(self, now: float, began: float) -> None:
        """Take every step that is due at ``now``, the first one ``TIMESTEP_S`` after ``began``."""
        action = self.turn(now, self._stamps(now, began), self._also)
        self.contacts.look(now)
        self.report(now, action, lambda: 1.0)

    def close(self) -> None:
        """Stop the wheels and let go of the drawing."""
        self.end()
        if self._painter is not None:
            self._painter.close()
            self._painter = None

    def _stamps(self, now: float, began: float) -> Iterator[float]:
        while (stamp := began + (self._steps + 1) * TIMESTEP_S) <= now + 0.5 * TIMESTEP_S:
            self._steps += 1
            yield stamp

    def _also(self, stamp: float) -> None:
        self._see(stamp)
        if self.soundscape is not None and "microphones" in self.wanted:
            self._hear(stamp, self.soundscape)

    def _hear(self, stamp: float, soundscape: Soundscape) -> None:
        time_s = self.simulation.time_s
        if not self._scenes.due(time_s):
            return
        if self._ear is None:  # rooms take a second to be made
            self._ear = Ear(soundscape.setup)
        scene = soundscape.scene(time_s, stamp, self.simulation.true_pose(), self.rims(), self.stage)
        for heard in self._ear.listen([scene]):
            self.send("microphones", heard.audio, stamp)

    def _see(self, stamp: float) -> None:
        for stream in self.eyes:
            if (snapshot := self.look(stream, stamp)) is None:
                continue
            eye = self._eye(stream)
            for _ in eye.draw(snapshot):
                pass
            size = (self._formats[stream].height, self._formats[stream].width)
            color = np.zeros((*size, 3), dtype=np.uint8)
            depth = np.zeros(size, dtype=np.uint16) if self._formats[stream].has_depth else None
            eye.measure(color, depth)
            frame, lens = self._lenses[stream]
            self.send(stream, Image(stamp, frame, color=color, depth=depth, camera=lens, X_BC=snapshot.X_BC), stamp)

    def _eye(self, stream: str) -> Eye:
        """The camera of ``stream``; OpenGL is made ready for the first picture anybody wants."""
        if self._painter is None:
            self._painter = Painter(self.simulation.model)
            self._open = open_eyes(self._painter, self.simulation.model, self.robot.streams, self.eye_rngs)
        return self._open[stream]
