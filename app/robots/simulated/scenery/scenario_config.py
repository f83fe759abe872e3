"""The models of ``config/scenarios/*.yaml``: people and sounds in the world, their scripts, and the robot's drive.

Everything is in the world's frame W (m, x east, y north, z up; degrees from east, counter-clockwise) and in simulated
seconds since the start.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, PlainValidator, field_validator, model_validator

from app.base.plain_file import check_plain
from app.base.yaml_source import load_yaml, suggestion
from app.robots.config_model import Positive
from app.robots.simulated.acoustics.sound_library import NAMES
from app.robots.simulated.scenery.faces import FACES
from app.robots.simulated.world_config import Color, FileModel, Point

NotNegative = Annotated[float, Field(ge=0)]
Place = tuple[float, float, float]
Kind = Literal["speech", "clap", "door", "steps", "music", "alarm", "noise"]


def _look(value: object) -> object:
    """One sentence on what is allowed, where a union would complain of each of its members."""
    if value in ("ahead", "robot"):
        return value
    if isinstance(value, list | tuple) and len(value) == 2 and all(isinstance(v, int | float) for v in value):
        return (float(value[0]), float(value[1]))
    raise ValueError("should be 'ahead', 'robot' or a point [x, y]")


Look = Annotated[Literal["ahead", "robot"] | Point, PlainValidator(_look)]
SOUND_FILES = (".wav", ".flac", ".ogg")
SHORTEST_SCRIPT_S = 0.5
"""Least duration (s) of a repeated script: else its sounds would start a hundred times a second."""
LONGEST_SOUND_S = 120.0
"""Greatest duration (s) of a sound without loop: the scenario's state drops it after that."""
ACTIONS = ("walk", "wait", "wait_for_robot", "follow", "say", "clap")


class StepConfig(FileModel):
    """One thing that a person does; exactly one of ``walk``, ``wait``, ``wait_for_robot``, ``follow``, ``say``
    and ``clap``.

    ``walk`` straight to a point at ``speed``; ``wait`` some seconds; ``wait_for_robot`` until the robot comes
    ``within`` metres of a point, or for ``at_most`` seconds; ``follow`` the robot for some seconds, ``distance`` metres
    behind and ``lag`` seconds late (both drawn from the seed where left out); ``say`` a sound of the library or a file;
    ``clap`` the hands so many times, one each ``every`` seconds. ``say`` does not wait for the sound's end. ``look``:
    direction of the face meanwhile: ``ahead``, at the ``robot``, or at a point.
    """

    walk: Point | None = None
    wait: NotNegative | None = None
    wait_for_robot: Point | None = None
    follow: Positive | None = None
    say: str | None = None
    clap: Annotated[int, Field(ge=1, le=20)] | None = None
    speed: Annotated[float, Field(gt=0, le=2)] = 1.0
    within: Positive = 1.5
    at_most: Positive = 60.0
    distance: Annotated[float, Field(ge=0.6, le=10)] | None = None
    lag: Annotated[float, Field(ge=0, le=30)] | None = None
    every: Annotated[float, Field(ge=0.2, le=5)] = 0.6
    gain_db: float = 0.0
    look: Look = "ahead"

    @model_validator(mode="after")
    def _one_action(self) -> StepConfig:
        given = [action for action in ACTIONS if getattr(self, action) is not None]
        if len(given) != 1:
            raise ValueError(f"a step is exactly one of {', '.join(ACTIONS)}, this is {' and '.join(given) or 'none'}")
        if self.follow is None and (self.distance is not None or self.lag is not None):
            raise ValueError("distance and lag are of following alone")
        return self


class PersonConfig(FileModel):
    """One person: looks, place at the start, and a ``script`` gone through once, or again and again (``repeat``).

    Without ``height_m`` the height is drawn from the scenario's seed. After waiting ``gives_way_s`` for the robot to
    move out of the way the person goes back a metre, and tries again after a time; None: the person waits.
    """

    name: Annotated[str, Field(min_length=1, max_length=40)]
    face: str
    at: Point
    heading_deg: float = 0.0
    height_m: Annotated[float, Field(ge=1.2, le=2.2)] | None = None
    shirt: Color = (70, 96, 140)
    trousers: Color = (52, 54, 62)
    shoes: Color = (38, 30, 26)
    script: tuple[StepConfig, ...] = ()
    repeat: bool = True
    gives_way_s: Positive | None = None

    @field_validator("face")
    @classmethod
    def _face_exists(cls, face: str) -> str:
        if face not in FACES:
            raise ValueError(f"there is no such face; {suggestion(face, tuple(FACES))}")
        return face

    @model_validator(mode="after")
    def _repeating_takes_time(self) -> PersonConfig:
        if self.repeat and self.script and self._least_s() < SHORTEST_SCRIPT_S:
            raise ValueError(
                "a repeated script needs steps that surely take time (wait, follow, clap, or walk between two points), "
                f"{SHORTEST_SCRIPT_S:g} s at least, or it would be over in an instant, again and again"
            )
        return self

    def _least_s(self) -> float:
        """Least duration (s) of a repetition of the script: waits for the robot and sounds may take no time."""
        goals = [step for step in self.script if step.walk is not None]
        walks = sum(
            math.dist(before.walk, step.walk) / step.speed
            for before, step in zip([*goals[-1:], *goals], goals, strict=False)
            if before.walk is not None and step.walk is not None
        )
        waits = sum((step.wait or 0.0) + (step.follow or 0.0) for step in self.script)
        return walks + waits + sum(step.clap * step.every for step in self.script if step.clap is not None)


class SoundConfig(FileModel):
    """A sound at a time: at ``at`` (a fixed place), or given off by a ``person`` (mouth, hands for claps, feet for
    steps).

    ``clip`` names a sound of the library, or a file beside the scenario. First at ``begin_s``; with ``every_s`` again
    and again (``count`` times in all, where given), each time up to ``jitter_s`` later, drawn from the seed. ``loop``
    plays the clip without end.
    """

    name: Annotated[str, Field(min_length=1, max_length=40)]
    kind: Kind
    clip: str
    person: str = ""
    at: Place | None = None
    gain_db: float = 0.0
    begin_s: NotNegative = 0.0
    every_s: Annotated[float, Field(ge=0.1)] | None = None
    jitter_s: NotNegative = 0.0
    count: Annotated[int, Field(ge=1)] | None = None
    loop: bool = False

    @model_validator(mode="after")
    def _one_place(self) -> SoundConfig:
        if (self.at is None) == (not self.person):
            raise ValueError("a sound has either a place ('at') or a person, not both and not neither")
        if self.loop and self.every_s is not None:
            raise ValueError("a sound that loops has no 'every_s': it never ends")
        if self.every_s is not None and self.jitter_s > self.every_s:
            raise ValueError(f"jitter_s of {self.jitter_s:g} s is longer than every_s, {self.every_s:g} s")
        return self


class FootstepsConfig(FileModel):
    clip: str = "step"
    gain_db: float = -12.0


class WaypointConfig(FileModel):
    """One leg of the robot's drive: exactly one of ``go`` (a point), ``face`` (degrees to turn to), ``pause`` (s)."""

    go: Point | None = None
    face: float | None = None
    pause: NotNegative | None = None
    speed: Annotated[float, Field(gt=0, le=1)] = Field(default=1.0, description="fraction of the robot's limit")
    label: str = ""

    @model_validator(mode="after")
    def _one_leg(self) -> WaypointConfig:
        given = [name for name in ("go", "face", "pause") if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(f"a leg is exactly one of go, face, pause; this is {' and '.join(given) or 'none'}")
        return self


class StartConfig(FileModel):
    """Start pose of the robot, in place of its own configuration's ``start``."""

    x: float
    y: float
    heading_deg: float = 0.0


class ScenarioConfig(FileModel):
    """People and sounds in the world. The same scenario with the same seed gives the same events."""

    name: str
    seed: int = 1
    people: tuple[PersonConfig, ...] = ()
    sounds: tuple[SoundConfig, ...] = ()
    footsteps: FootstepsConfig | None = None
    start: StartConfig | None = None
    drive: tuple[WaypointConfig, ...] = ()

    @model_validator(mode="after")
    def _names_agree(self) -> ScenarioConfig:
        people = [person.name for person in self.people]
        for what, names in (("people", people), ("sounds", [sound.name for sound in self.sounds])):
            if twice := next((name for name in names if names.count(name) > 1), None):
                raise ValueError(f"two {what} are called {twice!r}")
        for sound in self.sounds:
            if sound.person and sound.person not in people:
                raise ValueError(f"the sound {sound.name!r} is by {sound.person!r}; {suggestion(sound.person, people)}")
        return self


def load_scenario(path: Path | str) -> ScenarioConfig:
    """Read ``config/scenarios/<name>.yaml``, with the sound files it names as absolute paths.

    Raises ConfigError (file, line, key), also for an unknown sound, and for a file without sound or longer than
    :data:`LONGEST_SOUND_S` without being a ``loop``.
    """
    document = load_yaml(path)
    config = document.validate(ScenarioConfig)
    here = Path(path).resolve().parent

    def resolved(clip: str, *at: str | int, loop: bool = False) -> str:
        if not clip.lower().endswith(SOUND_FILES):
            if " " not in clip.strip() and clip not in NAMES:
                raise document.error(f"there is no sound {clip!r}; {suggestion(clip, NAMES)}", at)
            return clip
        file = (here / clip).resolve()
        if not file.is_file():
            raise document.error(f"there is no sound file {file}", at)
        try:
            seconds = _seconds(file)
        except ValueError as failure:
            raise document.error(str(failure), at) from None
        if seconds > LONGEST_SOUND_S and not loop:
            raise document.error(
                f"the sound file {file} lasts {seconds:.1f} s; {LONGEST_SOUND_S:g} s are the most without a loop", at
            )
        return str(file)

    sounds = tuple(
        sound.model_copy(update={"clip": resolved(sound.clip, "sounds", i, "clip", loop=sound.loop)})
        for i, sound in enumerate(config.sounds)
    )
    people = tuple(
        person.model_copy(
            update={
                "script": tuple(
                    step.model_copy(update={"say": resolved(step.say, "people", i, "script", j, "say")})
                    if step.say is not None
                    else step
                    for j, step in enumerate(person.script)
                )
            }
        )
        for i, person in enumerate(config.people)
    )
    return config.model_copy(update={"sounds": sounds, "people": people})


def _seconds(file: Path) -> float:
    """Duration of a sound file, by its header. Raises ValueError, in words, for a file without sound."""
    import soundfile

    try:
        check_plain(file)
        seconds = float(soundfile.info(str(file)).duration)
    except (soundfile.SoundFileError, OSError) as failure:
        raise ValueError(f"the sound file {file} cannot be read: {failure}") from None
    if not seconds:
        raise ValueError(f"the sound file {file} holds no sound")
    return seconds
