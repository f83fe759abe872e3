"""Client of the microphones' process in the control loop: starts the process on demand and sends it the world's
state."""

from __future__ import annotations

import contextlib
import os
import pickle
import socket
import subprocess
import sys
from typing import Any

from app.base.child_processes import python
from app.base.geometry import Pose2
from app.messages import Audio
from app.robots.simulated.acoustics.ipc import LoudspeakerFrame, MicrophoneFrame
from app.robots.simulated.acoustics.soundscape import Soundscape
from app.robots.simulated.image_ring import create_memory
from app.robots.simulated.link_protocol import Socket
from app.robots.simulated.scenery.scenario_state import ScenarioState

_LATE_S = 0.1
"""Greatest delay (s) of sound behind the world, below the delay at which the microphones' process drops frames."""
_PAUSE_S = 0.3
_RESTART_S = 2.0
_UPDATE_S = 10.0


class AcousticsClient:
    """Renders ``soundscape`` in a process of its own; never waits. Call :meth:`update` often and :meth:`receive` when
    :attr:`descriptors` are readable."""

    def __init__(self, soundscape: Soundscape) -> None:
        self._soundscape = soundscape
        pickled = pickle.dumps(soundscape.setup, protocol=5)
        self._setup = create_memory(len(pickled))
        with open(os.dup(self._setup), "wb") as memory:
            memory.write(pickled)
        self._socket: Socket | None = None
        self._process: subprocess.Popen[bytes] | None = None
        self._not_before_s = 0.0
        self._lost = 0
        self._updated_s = -_UPDATE_S
        self._scene_s = 0.0
        self._heard_s: float | None = None

    @property
    def descriptors(self) -> list[int]:
        """Descriptors for ``select``; none without the process."""
        return [] if self._socket is None else [self._socket.fileno()]

    def update(
        self, time_s: float, stamp: float, X_WB: Pose2, rims_mps: tuple[float, float], scenario_state: ScenarioState
    ) -> None:
        """Send the world's state at ``time_s`` (simulated); starts the process if it does not run."""
        if self._socket is None:
            if time_s < self._not_before_s:
                return
            self._start()
            assert self._socket is not None
        if time_s - self._scene_s > _PAUSE_S:  # there was no demand meanwhile
            self._heard_s = None
        self._scene_s = time_s
        self._socket.send(self._soundscape.scene(time_s, stamp, X_WB, rims_mps, scenario_state))
        self._socket.flush()
        if self._socket.closed:
            self._lose(time_s)

    def play(self, audio: Audio) -> None:
        """Sound for the loudspeaker; dropped without the process."""
        if self._socket is not None and audio.samples.size:
            self._socket.send(LoudspeakerFrame(audio))
            self._socket.flush()

    def receive(self, time_s: float) -> list[MicrophoneFrame]:
        if self._socket is None:
            return []
        frames: list[MicrophoneFrame] = []
        for heard in self._socket.receive():
            if isinstance(heard, MicrophoneFrame):
                frames.append(heard)
                self._heard_s = (heard.audio.first_sample + len(heard.audio.samples)) / heard.audio.rate
                self._lost += heard.lost
        if self._lost and time_s - self._updated_s > _UPDATE_S:
            print(f"the microphones lost {self._lost} frames: the computer is too slow", file=sys.stderr, flush=True)
            self._updated_s, self._lost = time_s, 0
        if self._socket.closed:
            self._lose(time_s)
        return frames

    @property
    def late(self) -> bool:
        """Whether sound is overdue for the states sent so far."""
        return self._socket is not None and self._heard_s is not None and self._scene_s - self._heard_s > _LATE_S

    def close(self) -> None:
        if self._socket is not None:
            self._socket.close()
            self._socket = None
        if self._process is not None:
            try:
                self._process.wait(0.1)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
            self._process = None
        if self._setup >= 0:
            os.close(self._setup)
            self._setup = -1

    def _start(self) -> None:
        ours, theirs = socket.socketpair()
        for end in (ours, theirs):
            with contextlib.suppress(OSError):
                end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 1 << 18)
        try:
            self._process = subprocess.Popen(
                python("-m", "app.robots.simulated.acoustics.process", str(theirs.fileno()), str(self._setup)),
                pass_fds=(theirs.fileno(), self._setup),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                env=os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
            )
        finally:
            theirs.close()
        self._socket = Socket(ours)

    def _lose(self, time_s: float) -> None:
        assert self._socket is not None
        self._socket.close()
        self._socket, self._heard_s = None, None
        status: Any = None
        if self._process is not None:
            with contextlib.suppress(subprocess.TimeoutExpired):
                status = self._process.wait(0.05)
        self._process = None
        self._not_before_s = time_s + _RESTART_S
        print(f"the microphones' process ended (status {status}); it is started again", file=sys.stderr, flush=True)
