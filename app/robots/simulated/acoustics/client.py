"""The control loop's end of the microphones: starts their process when somebody listens, tells it of the world."""

from __future__ import annotations

import contextlib
import os
import pickle
import socket
import subprocess
import sys
from collections.abc import Iterator
from typing import Any

from app.errors import ConfigError
from app.geometry import Pose2, Pose3
from app.messages import Audio, SoundTruth
from app.robots.config import LoudspeakerConfig, MicrophonesConfig
from app.robots.model import RobotModel
from app.robots.simulated.acoustics.orders import Heard, Played, Scene, Setup, Sounding
from app.robots.simulated.acoustics.sounds import PEAK_DB_SPL, VARIANTS, Key, Library
from app.robots.simulated.acoustics.synthesis import MAKERS
from app.robots.simulated.image_ring import create_memory
from app.robots.simulated.scenario_config import LONGEST_SOUND_S, ScenarioConfig
from app.robots.simulated.stage import Cue, Stage
from app.robots.simulated.wire import Socket
from app.robots.simulated.world_config import WorldConfig

AFTER_S = 0.3
"""How long a sound is told of after its end: its way, of up to 100 m."""
_RESTART_S = 2.0
_TELL_S = 10.0


class Acoustics:
    """Never waits. Raises ConfigError from the beginning for a sound there is not, or that would be cut off.

    ``listening`` starts and stops it; then call :meth:`tell` often and :meth:`receive` when :attr:`descriptors` can be
    read.
    """

    def __init__(
        self,
        config: MicrophonesConfig,
        loudspeaker: LoudspeakerConfig | None,
        world: WorldConfig,
        model: RobotModel,
        scenario: ScenarioConfig | None,
        wheels: tuple[str, str],
        seed: int,
    ) -> None:
        self._library = Library(config.rate, config.sensitivity_db)
        try:
            clips = (
                {key: self._library.at(key) for key in _keys(self._library, scenario)} if scenario is not None else {}
            )
        except ConfigError as failure:
            assert scenario is not None
            raise ConfigError(f"the scenario {scenario.name!r}: {failure.message}") from None
        looping = {sound.clip for sound in scenario.sounds if sound.loop} if scenario is not None else set()
        for (name, _), clip in clips.items():
            if clip.seconds > LONGEST_SOUND_S and name not in looping:
                raise ConfigError(
                    f"{name!r} lasts {clip.seconds:.0f} s; {LONGEST_SOUND_S:g} s are the most without a loop"
                )
        setup = Setup(
            config=config,
            loudspeaker=loudspeaker,
            world=world,
            X_BM=model.pose(config.link),
            X_BS=model.pose(loudspeaker.link) if loudspeaker is not None else Pose3.identity(),
            p_BW=tuple(_place(model.pose(model.joints[wheel].child)) for wheel in wheels),  # type: ignore[arg-type]
            clips={key: (clip.samples, clip.level) for key, clip in clips.items()},
            seed=seed,
        )
        pickled = pickle.dumps(setup, protocol=5)
        self._setup = create_memory(len(pickled))
        with open(os.dup(self._setup), "wb") as memory:
            memory.write(pickled)
        self._socket: Socket | None = None
        self._process: subprocess.Popen[bytes] | None = None
        self._not_before_s = 0.0
        self._lost = 0
        self._told_s = -_TELL_S

    @property
    def descriptors(self) -> list[int]:
        """What to wait for with ``select``; none while nobody listens."""
        return [] if self._socket is None else [self._socket.fileno()]

    def tell(self, time_s: float, stamp: float, X_WB: Pose2, rims_mps: tuple[float, float], stage: Stage) -> None:
        """Tell how the world is at ``time_s`` (simulated); starts the process if it does not run."""
        if self._socket is None:
            if time_s < self._not_before_s:
                return
            self._start()
            assert self._socket is not None
        headings = {person.name: person.heading for person in stage.people}
        sounds = tuple(
            Sounding(
                cue.name, self._key(cue), cue.begin_s, cue.gain_db, cue.loop, stage.place(cue), _mouth(cue, headings)
            )
            for cue in stage.cues
            if self._heard_still(cue, time_s)
        )
        self._socket.send(Scene(time_s, stamp, X_WB, rims_mps, sounds))
        self._socket.flush()
        if self._socket.closed:
            self._lose(time_s)

    def play(self, audio: Audio) -> None:
        """Sound for the loudspeaker; swallowed while nobody listens, for then nobody hears it."""
        if self._socket is not None and audio.samples.size:
            self._socket.send(Played(audio))
            self._socket.flush()

    def receive(self, time_s: float) -> list[Audio]:
        """The frames that have arrived."""
        if self._socket is None:
            return []
        frames: list[Audio] = []
        for heard in self._socket.receive():
            if isinstance(heard, Heard):
                frames.append(heard.audio)
                self._lost += heard.lost
        if self._lost and time_s - self._told_s > _TELL_S:
            print(f"the microphones lost {self._lost} frames: the computer is too slow", file=sys.stderr, flush=True)
            self._told_s, self._lost = time_s, 0
        if self._socket.closed:
            self._lose(time_s)
        return frames

    def truth(self, time_s: float, stamp: float, stage: Stage) -> tuple[SoundTruth, ...]:
        """Every scripted sound that is being given off."""
        return tuple(
            SoundTruth(
                name=cue.name,
                kind=cue.kind,
                person=cue.person,
                p_WS=stage.place(cue),
                began=stamp - (time_s - cue.begin_s),
                active=self._library.at(self._key(cue)).active(time_s - cue.begin_s, cue.loop),
            )
            for cue in stage.cues
            if self._heard_still(cue, time_s, 0.0)
        )

    def close(self) -> None:
        """End the process."""
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

    def _key(self, cue: Cue) -> Key:
        return self._library.key(cue.clip, cue.person if cue.kind == "speech" else cue.name)

    def _heard_still(self, cue: Cue, time_s: float, after_s: float = AFTER_S) -> bool:
        if cue.begin_s > time_s:
            return False
        return cue.loop or time_s < cue.begin_s + self._library.at(self._key(cue)).seconds + after_s

    def _start(self) -> None:
        ours, theirs = socket.socketpair()
        for end in (ours, theirs):
            with contextlib.suppress(OSError):
                end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 1 << 18)
        try:
            self._process = subprocess.Popen(
                [
                    sys.executable,
                    "-m",
                    "app.robots.simulated.acoustics.process",
                    str(theirs.fileno()),
                    str(self._setup),
                ],
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
        self._socket = None
        status: Any = None
        if self._process is not None:
            with contextlib.suppress(subprocess.TimeoutExpired):
                status = self._process.wait(0.05)
        self._process = None
        self._not_before_s = time_s + _RESTART_S
        print(f"the microphones' process ended (status {status}); it is started again", file=sys.stderr, flush=True)


def _keys(library: Library, scenario: ScenarioConfig) -> Iterator[Key]:
    """Every sound that ``scenario`` can ask for."""
    names = {sound.clip for sound in scenario.sounds} | ({scenario.footsteps.clip} if scenario.footsteps else set())
    for person in scenario.people:
        if any(step.clap is not None for step in person.script):
            names.add("clap")
        for step in person.script:
            if step.say is not None:
                yield library.key(step.say, person.name)
    for sound in scenario.sounds:
        if sound.kind == "speech" and sound.person:
            yield library.key(sound.clip, sound.person)
    for name in sorted(names):
        spoken = name not in MAKERS and library.key(name, " ") != library.key(name)
        if name in PEAK_DB_SPL or spoken:
            yield from ((name, variant) for variant in range(VARIANTS))
        else:
            yield library.key(name)


def _place(X_BF: Pose3) -> tuple[float, float, float]:
    x, y, z = X_BF.translation
    return float(x), float(y), float(z)


def _mouth(cue: Cue, headings: dict[str, float]) -> float | None:
    return headings.get(cue.person) if cue.kind == "speech" else None
