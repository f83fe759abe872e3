"""World of a body in lockstep: stepped by its caller, with images and sound rendered while the caller waits."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from app.messages import Audio, Image
from app.robots.config import RobotConfig
from app.robots.simulated.acoustics.ipc import LoudspeakerFrame
from app.robots.simulated.acoustics.microphone_simulator import MicrophoneSimulator
from app.robots.simulated.acoustics.soundscape import SCENES_HZ, Soundscape
from app.robots.simulated.body import TIMESTEP_S
from app.robots.simulated.camera_models import lenses, picture_formats
from app.robots.simulated.camera_rendering import CameraRenderer, open_renderers
from app.robots.simulated.contacts import ContactMonitor
from app.robots.simulated.renderer import Renderer
from app.robots.simulated.scenery.scenario_config import ScenarioConfig
from app.robots.simulated.simulation import STEPS_PER_TURN, Schedule, WorldSimulation
from app.robots.simulated.world_config import WorldConfig


class LockstepWorld(WorldSimulation):
    """A simulated world whose steps are due by ``now``; see :class:`WorldSimulation` for errors."""

    turn_s = STEPS_PER_TURN * TIMESTEP_S

    def __init__(
        self,
        robot: RobotConfig,
        world: WorldConfig,
        scenario: ScenarioConfig | None,
        send: Callable[[str, object], None],
    ) -> None:
        super().__init__(robot, world, scenario, send)
        self.contacts = ContactMonitor(self.physics)
        self._steps = 0
        self._lenses = lenses(robot)
        self._formats = picture_formats(robot)
        self._renderer: Renderer | None = None
        self._open: dict[str, CameraRenderer] = {}
        self._microphone_simulator: MicrophoneSimulator | None = None
        self._scenes = Schedule(SCENES_HZ)
        #: How many periods its newest image ended, by camera.
        self.periods: dict[str, int] = {}

    def lockstep(self, now: float, began: float) -> None:
        """Take every step that is due at ``now``, the first one ``TIMESTEP_S`` after ``began``."""
        action = self.turn(now, self._stamps(now, began), self._also)
        self.contacts.look(now)
        self.report(now, action, lambda: 1.0)

    def close(self) -> None:
        self.end()
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None

    def _stamps(self, now: float, began: float) -> Iterator[float]:
        while (stamp := began + (self._steps + 1) * TIMESTEP_S) <= now + 0.5 * TIMESTEP_S:
            self._steps += 1
            yield stamp

    def _also(self, stamp: float) -> None:
        self._see(stamp)
        if self.soundscape is not None and "microphones" in self.wanted:
            self._hear(stamp, self.soundscape)

    def play(self, audio: Audio) -> None:
        """Queue sound for the loudspeaker; dropped while no microphones are wanted."""
        if self._microphone_simulator is not None and audio.samples.size:
            self._microphone_simulator.play(LoudspeakerFrame(audio))

    def _hear(self, stamp: float, soundscape: Soundscape) -> None:
        time_s = self.physics.time_s
        if not self._scenes.due(time_s):
            return
        if self._microphone_simulator is None:  # building rooms takes a second
            self._microphone_simulator = MicrophoneSimulator(soundscape.setup)
        scene = soundscape.scene(time_s, stamp, self.physics.true_pose(), self.rims(), self.scenario_state)
        for heard in self._microphone_simulator.listen([scene]):
            self.send_sound(heard, stamp)

    def _see(self, stamp: float) -> None:
        for stream in self.cameras:
            if (snapshot := self.look(stream, stamp)) is None:
                continue
            renderer = self._renderer_of(stream)
            for _ in renderer.draw(snapshot):
                pass
            size = (self._formats[stream].height, self._formats[stream].width)
            color = np.zeros((*size, 3), dtype=np.uint8)
            depth = np.zeros(size, dtype=np.uint16) if self._formats[stream].has_depth else None
            renderer.measure(color, depth)
            frame, lens = self._lenses[stream]
            self.periods[stream] = snapshot.periods
            self.send(stream, Image(stamp, frame, color=color, depth=depth, camera=lens, X_BC=snapshot.X_BC), stamp)

    def _renderer_of(self, stream: str) -> CameraRenderer:
        """The renderer of ``stream``; OpenGL is initialized for the first image."""
        if self._renderer is None:
            self._renderer = Renderer(self.physics.model)
            self._open = open_renderers(self._renderer, self.physics.model, self.robot.streams, self.camera_rngs)
        return self._open[stream]
