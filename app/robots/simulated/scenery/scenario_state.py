"""State of a scenario: current actions of its people, and scripted sounds with their places. Pure bookkeeping, without
physics, images or sound; the world's loop advances it, bodies and acoustics read it. Time advances in fixed ticks, so
that the same scenario and the same motion of the robot give the same people, however often ``advance`` is called.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from app.base.geometry import Pose2
from app.messages import PersonTruth
from app.robots.simulated.scenery.actor import Actor, ActorSound
from app.robots.simulated.scenery.following import draw_habits
from app.robots.simulated.scenery.scenario_config import LONGEST_SOUND_S, ScenarioConfig, SoundConfig

TICK_S = 0.01
LOOKAHEAD_S = 2.0
"""Lead time (s) with which a timed sound appears among the cues."""
KEEP_S = LONGEST_SOUND_S + 1.0
"""Time (s) after its begin that a sound stays there: the longest clip, plus travel time."""
STEPS_KEEP_S = 2.0
HEIGHT_MEAN_M, HEIGHT_SIGMA_M = 1.71, 0.10
"""Heights of standing adults in shoes (Fryar et al., Vital and Health Statistics 3(46), 2021), as in the prior of
``app/modules/perception/height_prior.py``; a test holds both together."""
HEIGHT_RANGE_M = (1.45, 1.97)


@dataclass(frozen=True, slots=True)
class Cue:
    """One sound, once (or for ever: ``loop``), from ``begin_s`` (simulated s) on. ``name`` is unique.

    ``kind`` as in ``SoundTruth``; ``person``: name of its person, "" for none; ``clip`` a sound of the library, or an
    absolute path of a file; ``gain_db`` relative to the clip's own level.
    """

    name: str
    kind: str
    person: str
    clip: str
    gain_db: float
    begin_s: float
    loop: bool


class ScenarioState:
    """Plays a scenario. Attributes are read between calls of :meth:`advance`."""

    def __init__(self, scenario: ScenarioConfig) -> None:
        seeds = np.random.SeedSequence(scenario.seed).spawn(3)
        heights = np.random.default_rng(seeds[0])
        self._footsteps = scenario.footsteps
        self.actors = tuple(
            Actor(person, person.height_m if person.height_m is not None else height, habit)
            for person, height, habit in zip(
                scenario.people,
                draw_heights(heights, len(scenario.people)),
                draw_habits(np.random.default_rng(seeds[2]), len(scenario.people)),
                strict=True,
            )
        )
        self._by_name = {actor.name: actor for actor in self.actors}
        self._places = {sound.name: sound.at for sound in scenario.sounds if sound.at is not None}
        self._timed = [
            _Timed(sound, np.random.default_rng(seed))
            for sound, seed in zip(scenario.sounds, seeds[1].spawn(len(scenario.sounds)), strict=True)
        ]
        self._ticks = 0
        self._numbers = 0
        self._cues: deque[Cue] = deque()
        self._loops: list[Cue] = []
        self._of: dict[str, str] = {}
        self.advance(0.0, Pose2())

    @property
    def time_s(self) -> float:
        """Simulated time of the last tick."""
        return self._ticks * TICK_S

    @property
    def cues(self) -> tuple[Cue, ...]:
        """Every endless sound, and those that began in the last two minutes or begin in the next two seconds."""
        return (*self._loops, *self._cues)

    @property
    def people(self) -> tuple[PersonTruth, ...]:
        return tuple(actor.truth for actor in self.actors)

    def place(self, cue: Cue) -> tuple[float, float, float]:
        """Current place (m, world) of the sound of ``cue``: its fixed place, or its person's mouth, hands or feet."""
        if not cue.person:
            place = self._places[self._of[cue.name]]
            assert place is not None
            return place
        actor = self._by_name[cue.person]
        if cue.kind == "clap":
            return actor.hands
        if cue.kind == "steps":
            return (actor.x, actor.y, 0.02)
        return actor.mouth

    def due(self, time_s: float) -> bool:
        """Whether a tick passes up to ``time_s`` (simulated s)."""
        return (self._ticks + 1) * TICK_S <= time_s + 1e-9

    def let_pass(self) -> None:
        """The robot asks those who follow it to let it pass."""
        for actor in self.actors:
            actor.let_pass()

    def advance(self, time_s: float, X_WB: Pose2) -> None:
        """Advance the people to ``time_s`` (simulated s), the robot being at ``X_WB``."""
        before = self._ticks
        while self.due(time_s):
            self._ticks += 1
            now = self.time_s
            for number, actor in enumerate(self.actors):
                for happening in actor.tick(TICK_S, now, X_WB, self.actors[:number]):
                    self._happened(actor, happening)
        if self._ticks > before or not self._cues:
            self._update_cues()

    def _happened(self, actor: Actor, what: ActorSound) -> None:
        clip, gain_db = what.clip, what.gain_db
        if what.kind == "steps":
            if self._footsteps is None:
                return
            clip, gain_db = self._footsteps.clip, self._footsteps.gain_db
        self._numbers += 1
        name = f"{actor.name}: {what.kind} {self._numbers}"
        self._cues.append(
            Cue(name, what.kind, person=actor.name, clip=clip, gain_db=gain_db, begin_s=what.begin_s, loop=False)
        )

    def _update_cues(self) -> None:
        now = self.time_s
        for timed in self._timed:
            while (begin := timed.next_s) is not None and begin <= now + LOOKAHEAD_S:
                sound = timed.sound
                self._numbers += 1
                name = sound.name if sound.every_s is None else f"{sound.name} {timed.done + 1}"
                self._of[name] = sound.name
                cue = Cue(
                    name,
                    sound.kind,
                    person=sound.person,
                    clip=sound.clip,
                    gain_db=sound.gain_db,
                    begin_s=begin,
                    loop=sound.loop,
                )
                (self._loops if sound.loop else self._cues).append(cue)
                if sound.kind == "clap" and sound.person:
                    self._by_name[sound.person].clap_at(begin)
                timed.take()
        self._cues = deque(cue for cue in self._cues if self._still_active(cue, now))
        known = {cue.name for cue in self.cues}
        self._of = {name: sound for name, sound in self._of.items() if name in known}

    @staticmethod
    def _still_active(cue: Cue, now: float) -> bool:
        return now - cue.begin_s < (STEPS_KEEP_S if cue.kind == "steps" else KEEP_S)


class _Timed:
    def __init__(self, sound: SoundConfig, rng: np.random.Generator) -> None:
        self.sound = sound
        self.done = 0
        self._rng = rng
        self.next_s: float | None = self._jittered(sound.begin_s)

    def take(self) -> None:
        """Take the next time and compute the one after."""
        self.done += 1
        sound = self.sound
        again = sound.every_s is not None and (sound.count is None or self.done < sound.count)
        self.next_s = self._jittered(sound.begin_s + self.done * sound.every_s) if again and sound.every_s else None

    def _jittered(self, time_s: float) -> float:
        return time_s + self.sound.jitter_s * float(self._rng.random()) if self.sound.jitter_s else time_s


def draw_heights(rng: np.random.Generator, count: int) -> list[float]:
    """``count`` heights (m) of standing people, without extremes."""
    heights = HEIGHT_MEAN_M + HEIGHT_SIGMA_M * rng.standard_normal(count)
    return [float(height) for height in np.clip(heights, *HEIGHT_RANGE_M)]
