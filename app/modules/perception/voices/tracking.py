"""Who is who among the directions that sound comes from: tracks, from birth to death."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from app.modules.perception.voices.localization import Peaks
from app.modules.perception.voices.motion import Motion, Vector, along, angle_deg, angular_speed


@dataclass(frozen=True, slots=True)
class TrackerSettings:
    """When tracks are born, how they move and when they die.

    ``tracks``: most at a time. A peak of ``birth_power``, and of ``birth_share`` of the strongest one, makes a track
    once it has been there for ``patience_s``, and sooner by the cube of how much it is above both. A track lives on
    peaks of ``keep_power`` and ``keep_share`` within ``gate_deg`` of where it must be, and without any the longer the
    better it was heard before, at most ``silence_s``. A floor's and a ceiling's echoes come from above and below their
    source: a peak within ``echo_azimuth_deg`` of a stronger one, but higher or lower by ``echo_elevation_deg`` and more
    and below ``echo_share`` of it, is none of either. A peak that is a copy of a stronger one makes no track from the
    second of ``echo`` on, and one the later from the first on. A track sounds (is active) while peaks' recent powers
    are at least ``active_power``, and for ``active_s`` longer. ``apart_deg``: nearer to a track none other is born.
    What is heard of a track counts as itself if it is ``sure_level`` of its own level and ``sure_share`` of the
    strongest, both held over pauses (``hold_s``), and if the search finds it, too, within ``unfound_s``: the rest is
    the room's and the others' and moves nothing. An echo only ever follows: again and again, within ``trial_s`` of its
    birth and then within ``trust_s`` of sound, a track must be ``proof_share`` of the strongest or, for ``proof_steps``
    steps, louder than ``proof_loud`` of each other's level; until it is, it is not told of. The share it needs is the
    larger, the more it is a copy of others (``proof_echo``, mean over ``echo_s``). Nor is one
    told of that is silent for longer than ``told_s`` and ``told_heard`` times as long as it was heard, or than
    ``told_moving_s`` if it moved by more than ``moving_degps``, or than ``hidden_s`` within ``hidden_deg`` of one that
    sounds: it keeps its number, for when it is heard again. One
    that falls silent as another begins within ``replaced_deg`` ends once that one was heard for ``replaced_s``.
    ``jerk_degps``: how much a source's angular velocity may change in one second (standard deviation, random walk);
    ``rest_s``: how soon a silent one is supposed to have stopped. ``error_deg``: of a peak of good power, of a source
    that is as loud as it was of late; in its pauses the room and others pull its peak away for long, and never at
    random, so the error is the greater, the softer it is than its own level. ``steady_error_deg`` and, for each rad/s,
    ``steady_doubt``: the same of the long mean. ``lag_s``: how old what a peak says is on average.
    """

    tracks: int = 4
    birth_power: float = 0.025
    patience_s: float = 0.3
    mercy_s: float = 0.6
    most_evidence: float = 10.0
    birth_share: float = 0.23
    keep_power: float = 0.02
    keep_share: float = 0.12
    echo_azimuth_deg: float = 15.0
    echo_elevation_deg: float = 20.0
    echo_share: float = 0.5
    echo: tuple[float, float] = (0.38, 0.58)
    gate_deg: float = 10.0
    apart_deg: float = 15.0
    silence_s: float = 2.5
    walking_degps: float = 8.0
    active_power: float = 0.03
    active_s: float = 0.15
    jerk_degps: float = 8.0
    jerk_share: float = 1.0
    rest_s: float = 3.0
    heard_power: float = 0.015
    unfound_s: float = 0.3
    hold_s: float = 1.5
    sure_level: float = 0.3
    sure_share: float = 0.18
    hidden_s: float = 0.5
    hidden_deg: float = 30.0
    replaced_s: float = 0.2
    replaced_deg: float = 35.0
    trust_s: float = 2.5
    echo_s: float = 0.5
    told_s: float = 0.2
    told_heard: float = 0.8
    told_moving_s: float = 1.5
    moving_degps: float = 5.0
    trial_s: float = 0.85
    proof_share: tuple[float, ...] = (0.25, 0.38, 0.6)
    proof_echo: tuple[float, ...] = (0.15, 0.35, 0.5)
    proof_loud: float = 0.7
    proof_power: float = 0.04
    proof_steps: int = 2
    sure_power: float = 0.06
    error_deg: float = 6.0
    lag_s: float = 0.05
    steady_error_deg: float = 6.0
    steady_lag_s: float = 0.4
    pull: float = 1.2
    crowd_doubt: float = 3.0
    steady_doubt: float = 2.0


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """A source of sound followed over time.

    ``id`` is its number, from 1, never used again. ``direction`` (3,) float64 unit vector, ``velocity`` (3,) rad/s on
    the sphere (at right angles to it), in the axes the peaks were given in. ``power`` in [0, 1] of its last sighting.
    ``active``: heard just now; ``born`` and ``last_seen``: s.
    """

    id: int
    direction: Vector
    velocity: Vector
    power: float
    active: bool
    born: float
    last_seen: float


@dataclass(slots=True, eq=False)
class _Source:
    """A track, or what may become one (``id`` 0); ``evidence`` 1 and more makes it one.

    ``recent`` and ``share``: power of the last moments, and of the last half second in those of the strongest, which is
    held over pauses; as of now, 0 if it is not heard. ``level``: the greatest ``recent``, fading; ``pace`` (rad/s): the
    greatest speed, fading. ``louder``: for how many steps it was louder than each other track. ``heard_s``: for how
    long it was heard since its birth; ``unproven_s``: since it last sounded of itself; ``proven``: it ever did.
    ``unfound_s``: for how long the search has not found what is heard; ``last_sure``: when it was last surely itself.
    ``echo``: how much it is a copy of others, on average.
    """

    motion: Motion
    power: float
    evidence: float
    born: float
    last_seen: float
    last_active: float
    id: int = 0
    recent: float = 0.0
    share: float = 0.0
    louder: int = 0
    heard_s: float = 0.0
    unfound_s: float = 0.0
    last_sure: float = 0.0
    level: float = 0.0
    pace: float = 0.0
    unproven_s: float = 0.0
    echo: float = 0.35
    proven: bool = False


class Tracker:
    """Follows sources; knows no time but the one it is given."""

    def __init__(self, settings: TrackerSettings = TrackerSettings()) -> None:
        self.settings = settings
        self._sources: list[_Source] = []
        self._next = 1
        self._time: float | None = None
        self._strongest = 0.0

    def rotate(self, rotation: NDArray[np.float64]) -> None:
        """Turn all that is known by ``rotation`` (3, 3), R_new_old: the axes themselves have turned."""
        for source in self._sources:
            source.motion = source.motion.rotated(rotation)

    @property
    def expected(self) -> NDArray[np.float64]:
        """Where every track is supposed to be when peaks come next (E, 3), for :meth:`Localizer.process`."""
        return np.array([source.motion.direction for source in self._sources if source.id]).reshape(-1, 3)

    def update(self, time_s: float, peaks: Peaks) -> tuple[Track, ...]:
        """Take the peaks of ``time_s`` (s, never going back); the tracks as they stand, oldest first."""
        settings = self.settings
        passed = 0.0 if self._time is None else max(0.0, time_s - self._time)
        self._time = time_s
        fading = math.exp(-passed / settings.hold_s)
        self._strongest = max(self._strongest * fading, float(peaks.powers.max(initial=0.0)))
        for source in self._sources:
            heard = time_s - source.last_active < settings.active_s
            jerk = math.radians(settings.jerk_degps) + settings.jerk_share * angular_speed(source.motion.velocity)
            source.motion = source.motion.predicted(passed, jerk, math.inf if heard else settings.rest_s)
            source.recent = source.share = 0.0
            source.level *= fading
            source.pace *= fading
        tracks = [source for source in self._sources if source.id]
        maybe = [source for source in self._sources if not source.id]
        strongest = float(peaks.powers.max(initial=0.0))
        audible = [
            k
            for k in self._no_echoes(peaks)
            if peaks.powers[k] >= settings.keep_share * strongest or peaks.recent[k] >= settings.sure_power
        ]
        free = [
            k
            for k in self._assign(tracks, audible, peaks, passed, time_s)
            if peaks.powers[k] >= settings.keep_power
            and peaks.recent[k] >= settings.heard_power
            and not any(angle_deg(peaks.directions[k], t.motion.direction) < settings.apart_deg for t in tracks)
        ]
        for k in self._assign(maybe, free, peaks, passed, time_s):
            self._sources.append(self._begin(time_s, peaks, k, passed))
        self._bury(time_s)
        self._bear(time_s)
        self._prove()
        self._replace(time_s)
        return tuple(self._track(source, time_s) for source in self._sources if self._told(source, time_s))

    def _told(self, source: _Source, time_s: float) -> bool:
        settings = self.settings
        if source.proven:
            trusted = source.unproven_s < settings.trust_s
        else:
            trusted = time_s - source.born < settings.trial_s
        moving = math.degrees(source.pace) > settings.moving_degps
        longest = settings.told_moving_s if moving else settings.silence_s
        longest = min(longest, settings.told_s + settings.told_heard * source.heard_s)
        silent = time_s - source.last_sure
        return bool(source.id) and trusted and silent <= longest and not self._hidden(source, silent, time_s)

    def _hidden(self, source: _Source, silent: float, time_s: float) -> bool:
        """Whether it is silent beside another that sounds: what is left where two passed one another."""
        settings = self.settings
        return silent > settings.hidden_s and any(
            other.id
            and other is not source
            and other.proven
            and time_s - other.last_sure < settings.active_s
            and angle_deg(other.motion.direction, source.motion.direction) < settings.hidden_deg
            for other in self._sources
        )

    def _prove(self) -> None:
        settings = self.settings
        tracks = [source for source in self._sources if source.id]
        for source in tracks:
            if source.recent < settings.proof_power:
                continue
            source.louder += all(
                source.recent > settings.proof_loud * other.level for other in tracks if other is not source
            )
            share = float(np.interp(source.echo, settings.proof_echo, settings.proof_share))
            if source.share >= share or source.louder >= settings.proof_steps:
                source.proven, source.unproven_s, source.louder = True, 0.0, 0

    def _replace(self, time_s: float) -> None:
        """Let go of tracks that fell silent as another began near by: the same talker, or what was between two."""
        settings = self.settings
        begun = [
            source
            for source in self._sources
            if source.id and source.proven and time_s - source.born < 1.0 and source.heard_s >= settings.replaced_s
        ]
        if begun:
            self._sources = [
                source
                for source in self._sources
                if not any(
                    0 < source.id < new.id
                    and source.last_sure < new.born + settings.active_s
                    and time_s - source.last_sure > settings.replaced_s
                    and angle_deg(source.motion.direction, new.motion.direction) < settings.replaced_deg
                    for new in begun
                )
            ]

    def _no_echoes(self, peaks: Peaks) -> list[int]:
        settings = self.settings
        loud = [
            k
            for k, power in enumerate(peaks.powers)
            if power >= settings.keep_power or peaks.recent[k] >= settings.sure_power
        ]
        if len(loud) < 2:
            return loud
        azimuths = np.degrees(np.arctan2(peaks.directions[:, 1], peaks.directions[:, 0]))
        elevations = np.degrees(np.arcsin(np.clip(peaks.directions[:, 2], -1, 1)))

        def echoes(k: int, other: int) -> bool:
            aside = abs((azimuths[k] - azimuths[other] + 180) % 360 - 180)
            # Near the zenith azimuths say little.
            aside *= math.cos(math.radians(max(elevations[k], elevations[other])))
            return bool(
                peaks.powers[k] < settings.echo_share * peaks.powers[other]
                and aside < settings.echo_azimuth_deg
                and abs(elevations[k] - elevations[other]) > settings.echo_elevation_deg
            )

        return [k for k in loud if not any(echoes(k, other) for other in loud)]

    def _assign(self, sources: list[_Source], free: list[int], peaks: Peaks, passed: float, time_s: float) -> list[int]:
        """Give each of ``sources`` at most one of the peaks ``free``, the nearest in all; the peaks left over."""
        settings = self.settings
        if not sources or not free:
            return free
        expected = np.array([source.motion.direction for source in sources])
        angles = np.degrees(np.arccos(np.clip(expected @ peaks.directions[free].T, -1, 1)))
        spread = np.degrees(np.sqrt([source.motion.position_variance for source in sources]))[:, None]
        possible = angles < settings.gate_deg + np.minimum(spread, 5)
        rows, columns = linear_sum_assignment(np.where(possible, angles, 1e3))
        taken = set()
        for row, column in zip(rows, columns, strict=True):
            if possible[row, column]:
                k = free[column]
                taken.add(k)
                source = sources[row]
                found = peaks.powers[k] >= settings.keep_power
                source.unfound_s = 0.0 if found else source.unfound_s + passed
                if source.unfound_s > settings.unfound_s:
                    continue
                source.recent = float(peaks.recent[k])
                source.level = max(source.level, source.recent)
                source.share = float(peaks.powers[k]) / max(self._strongest, settings.keep_power)
                self._sight(source, peaks, k, passed)
                if source.recent >= settings.heard_power:
                    source.last_seen = time_s
                if found and self._sure(source):
                    source.last_sure = time_s
                    source.heard_s += passed
                    source.unproven_s += passed
                    source.pace = max(source.pace, angular_speed(source.motion.velocity))
                if source.recent >= settings.active_power:
                    source.last_active = time_s
        return [k for k in free if k not in taken]

    def _sight(self, source: _Source, peaks: Peaks, k: int, passed: float) -> None:
        settings = self.settings
        recent = float(peaks.recent[k])
        if recent < settings.heard_power:
            return
        sure = self._sure(source)
        if peaks.powers[k] >= settings.keep_power:
            source.power = float(peaks.powers[k])
            source.echo += min(1.0, passed / settings.echo_s) * (float(peaks.echoes[k]) - source.echo)
            source.evidence = min(source.evidence + self._evidence(peaks, k, passed), settings.most_evidence)
        # Two that pass one another are one peak for a while: each goes on as it went.
        crowded = any(
            other.id
            and other is not source
            and angle_deg(other.motion.direction, source.motion.direction) < settings.apart_deg
            for other in self._sources
        )
        softer = max(source.level, recent) / recent
        if sure and recent >= settings.keep_power:
            # What is weak is pulled toward what is strong, in this mean of all sources together.
            doubt = max(0.5, 0.06 / recent) * max(1.0, settings.pull * float(peaks.recent.max()) / recent)
            error = math.radians(settings.error_deg) * softer * doubt * (settings.crowd_doubt if crowded else 1.0)
            source.motion = source.motion.corrected(peaks.directions[k], error**2)
        steady = peaks.steady[k]
        if sure and peaks.powers[k] >= settings.keep_power and not math.isnan(steady[0]) and not crowded:
            # Of old: supposed to have moved since as the source does.
            speed = angular_speed(source.motion.velocity)
            since = settings.steady_lag_s - settings.lag_s
            now, _ = along(steady, source.motion.velocity, since)
            if angle_deg(now, source.motion.direction) < settings.gate_deg:
                error = math.radians(settings.steady_error_deg) + settings.steady_doubt * speed
                source.motion = source.motion.corrected(now, (softer * error) ** 2)

    def _sure(self, source: _Source) -> bool:
        """Whether what is heard of it now is itself, not what the room and others leave there when it is silent."""
        settings = self.settings
        own = source.recent >= max(settings.heard_power, settings.sure_level * source.level)
        return own and source.share >= settings.sure_share

    def _evidence(self, peaks: Peaks, k: int, passed: float) -> float:
        settings = self.settings
        power, strongest, echo = float(peaks.powers[k]), float(peaks.powers.max()), float(peaks.echoes[k])
        unlike, alike = settings.echo
        own = min(1.0, max(0.0, (alike - echo) / (alike - unlike)))
        # What is plainly no copy of the strongest may be much weaker.
        share = settings.birth_share * min(1.0, max(0.5, echo / unlike))
        strength = min(power / settings.birth_power, power / strongest / share)
        gain = own * strength**3 - 1
        return gain * passed / (settings.patience_s if gain > 0 else settings.mercy_s)

    def _begin(self, time_s: float, peaks: Peaks, k: int, passed: float) -> _Source:
        direction, power = peaks.directions[k], float(peaks.powers[k])
        motion = Motion(direction, np.zeros(3), math.radians(5.0) ** 2, 0.0, math.radians(10.0) ** 2)
        return _Source(
            motion, power, max(0.0, self._evidence(peaks, k, passed)), time_s, time_s, time_s, last_sure=time_s
        )

    def _bury(self, time_s: float) -> None:
        def lives(source: _Source) -> bool:
            if not source.id:
                source.evidence = max(0.0, source.evidence)
                return time_s - source.last_seen <= 0.2
            if source.evidence < 0:
                return False
            speed = math.degrees(angular_speed(source.motion.velocity))
            longest = self.settings.silence_s / (1 + speed / self.settings.walking_degps)
            return time_s - source.last_seen <= min(longest, 0.3 + 0.4 * source.evidence)

        self._sources = [source for source in self._sources if lives(source)]

    def _bear(self, time_s: float) -> None:
        """Number what has shown itself long enough, the strongest first, as far as there is room."""
        ready = [source for source in self._sources if not source.id and source.evidence >= 1]
        for source in sorted(ready, key=lambda source: -source.power):
            tracks = [other for other in self._sources if other.id]
            lost = self._lost(source, tracks, time_s)
            if lost is not None:
                lost.motion = source.motion.going_on_as(lost.motion)
                lost.power, lost.evidence = source.power, lost.evidence + source.evidence
                lost.last_sure, lost.level, lost.unfound_s = source.last_sure, source.level, 0.0
                lost.last_seen, lost.last_active = source.last_seen, source.last_active
                self._sources.remove(source)
                continue
            if any(angle_deg(source.motion.direction, t.motion.direction) < self.settings.apart_deg for t in tracks):
                self._sources.remove(source)
                continue
            if len(tracks) >= self.settings.tracks:
                quiet = min(tracks, key=lambda track: track.last_seen)
                if time_s - quiet.last_seen < 0.5:
                    continue
                self._sources.remove(quiet)
            source.id = self._next
            source.born = time_s
            source.heard_s = 0.0
            self._next += 1
            self._sources.sort(key=lambda source: (not source.id, source.id))

    def _lost(self, source: _Source, tracks: list[_Source], time_s: float) -> _Source | None:
        """The track that walked on unheard and is heard again as ``source``, if there is one."""
        found, nearest = None, math.inf
        for track in tracks:
            silent = time_s - track.last_sure
            speed = math.degrees(track.pace)
            angle = angle_deg(source.motion.direction, track.motion.direction)
            if silent > 0.15 and angle < min(self.settings.apart_deg + 2 * speed * silent, 30.0, nearest):
                found, nearest = track, angle
        return found

    def _track(self, source: _Source, time_s: float) -> Track:
        active = time_s - source.last_active <= self.settings.active_s
        direction, velocity = source.motion.ahead(self.settings.lag_s if active else 0.0)
        return Track(source.id, direction, velocity, source.power, active, source.born, source.last_seen)
