"""Sounds of the simulated world for its microphones: scenes, and their ground truth."""

from __future__ import annotations

from collections.abc import Iterator

from app.base.errors import ConfigError
from app.base.geometry import Pose2, Pose3
from app.base.kinematic_model import KinematicModel
from app.messages import SoundTruth
from app.robots.simulated.acoustics.ipc import AcousticsSetup, ActiveSound, SoundScene
from app.robots.simulated.acoustics.sound_library import PEAK_DB_SPL, VARIANTS, ClipLibrary, Key
from app.robots.simulated.acoustics.synthesis import MAKERS
from app.robots.simulated.scenery.scenario_config import LONGEST_SOUND_S, ScenarioConfig
from app.robots.simulated.scenery.scenario_state import Cue, ScenarioState
from app.robots.simulated.world_config import WorldConfig
from app.robots.stream_config import LoudspeakerConfig, MicrophonesConfig

AFTER_S = 0.3
"""Time (s) that a sound stays in the scene after its end: travel time over up to 100 m."""
SCENES_HZ = 100.0
"""Rate (Hz) of the scenes."""


class Soundscape:
    """Every sound of ``scenario``; ``setup`` is the argument of a
    :class:`~app.robots.simulated.acoustics.microphone_simulator.MicrophoneSimulator`.

    Raises ConfigError for an unknown sound, or one that would be cut off.
    """

    def __init__(
        self,
        config: MicrophonesConfig,
        loudspeaker: LoudspeakerConfig | None,
        world: WorldConfig,
        model: KinematicModel,
        scenario: ScenarioConfig | None,
        wheels: tuple[str, str],
        seed: int,
    ) -> None:
        self._library = ClipLibrary(config.rate, config.sensitivity_db)
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
        self.setup = AcousticsSetup(
            config=config,
            loudspeaker=loudspeaker,
            world=world,
            X_BM=model.pose(config.link),
            X_BS=model.pose(loudspeaker.link) if loudspeaker is not None else Pose3.identity(),
            p_BW=tuple(_place(model.pose(model.joints[wheel].child)) for wheel in wheels),  # type: ignore[arg-type]
            clips={key: (clip.samples, clip.level) for key, clip in clips.items()},
            seed=seed,
        )

    def scene(
        self, time_s: float, stamp: float, X_WB: Pose2, rims_mps: tuple[float, float], scenario_state: ScenarioState
    ) -> SoundScene:
        """The world's state at ``time_s`` (simulated, s), ``stamp`` by the robot's clock."""
        headings = {person.name: person.heading for person in scenario_state.people}
        sounds = tuple(
            ActiveSound(
                cue.name,
                self._key(cue),
                begin_s=cue.begin_s,
                gain_db=cue.gain_db,
                loop=cue.loop,
                p_W=scenario_state.place(cue),
                looks=_mouth(cue, headings),
            )
            for cue in scenario_state.cues
            if self._heard_still(cue, time_s)
        )
        return SoundScene(time_s, stamp, X_WB, rims_mps, sounds)

    def truth(self, time_s: float, stamp: float, scenario_state: ScenarioState) -> tuple[SoundTruth, ...]:
        """Every scripted sound in progress."""
        return tuple(
            SoundTruth(
                name=cue.name,
                kind=cue.kind,
                person=cue.person,
                p_WS=scenario_state.place(cue),
                began=stamp - (time_s - cue.begin_s),
                active=self._library.at(self._key(cue)).active(time_s - cue.begin_s, cue.loop),
            )
            for cue in scenario_state.cues
            if self._heard_still(cue, time_s, 0.0)
        )

    def _key(self, cue: Cue) -> Key:
        return self._library.key(cue.clip, cue.person if cue.kind == "speech" else cue.name)

    def _heard_still(self, cue: Cue, time_s: float, after_s: float = AFTER_S) -> bool:
        if cue.begin_s > time_s:
            return False
        return cue.loop or time_s < cue.begin_s + self._library.at(self._key(cue)).seconds + after_s


def _keys(library: ClipLibrary, scenario: ScenarioConfig) -> Iterator[Key]:
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
