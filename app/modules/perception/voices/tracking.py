"""Multi-target tracking of sound sources: assignment of peaks, birth and death of tracks."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from app.modules.perception.voices.confirmation import TrackCandidate, TrackerSettings, confirm, reported
from app.modules.perception.voices.kalman import DirectionState, Vector, along, angle_deg, angular_speed
from app.modules.perception.voices.localization import Peaks


@dataclass(frozen=True, slots=True, eq=False)
class SoundTrack:
    """A tracked sound source.

    ``id``: its number, from 1, never reused. ``direction`` (3,) float64 unit vector, ``velocity`` (3,) rad/s tangent to
    the sphere, in the axes of the peaks. ``power`` in [0, 1] of its last peak. ``active``: whether it sounds now;
    ``born``, ``last_seen``: s.
    """

    id: int
    direction: Vector
    velocity: Vector
    power: float
    active: bool
    born: float
    last_seen: float


class Tracker:
    """Tracks sources; the only clock is the ``time_s`` of :meth:`update`."""

    def __init__(self, settings: TrackerSettings | None = None) -> None:
        self.settings = settings or TrackerSettings()
        self._sources: list[TrackCandidate] = []
        self._next = 1
        self._time: float | None = None
        self._strongest = 0.0
        self._loudest = 0.0

    @property
    def expected(self) -> NDArray[np.float64]:
        """Predicted directions of all tracks (E, 3), for :meth:`Localizer.process`."""
        return np.array([source.motion.direction for source in self._sources if source.id]).reshape(-1, 3)

    def update(self, time_s: float, peaks: Peaks) -> tuple[SoundTrack, ...]:
        """Take the peaks at ``time_s`` (s, monotonic); returns the reported tracks, oldest first."""
        settings = self.settings
        passed = 0.0 if self._time is None else max(0.0, time_s - self._time)
        self._time = time_s
        fading = math.exp(-passed / settings.hold_s)
        self._strongest = max(self._strongest * fading, float(peaks.powers.max(initial=0.0)))
        self._loudest = max(self._loudest * fading, float(peaks.recent.max(initial=0.0)))
        for source in self._sources:
            heard = time_s - source.last_active < settings.active_s
            jerk = math.radians(settings.jerk_degps) + settings.jerk_share * angular_speed(source.motion.velocity)
            source.motion = source.motion.predicted(passed, jerk, math.inf if heard else settings.rest_s)
            source.recent = source.share = 0.0
            source.level *= fading
            source.speed_radps *= fading
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
        self._end_lost(time_s)
        self._number_born(time_s)
        confirm(self._sources, self._loudest, time_s, settings)
        self._replace(time_s)
        return tuple(
            self._track(source, time_s) for source in self._sources if reported(source, self._sources, time_s, settings)
        )

    def _replace(self, time_s: float) -> None:
        """End tracks that fell silent as another began near by: the same talker, or a phantom between two."""
        settings = self.settings
        new_sources = [
            source
            for source in self._sources
            if source.id and source.confirmed and time_s - source.born < 1.0 and source.heard_s >= settings.replaced_s
        ]
        if new_sources:
            self._sources = [
                source
                for source in self._sources
                if not any(
                    0 < source.id < new.id
                    and source.last_sure < new.born + settings.active_s
                    and time_s - source.last_sure > settings.replaced_s
                    and angle_deg(source.motion.direction, new.motion.direction) < settings.replaced_deg
                    for new in new_sources
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
            # Near the zenith differences of azimuth are small angles.
            aside *= math.cos(math.radians(max(elevations[k], elevations[other])))
            return bool(
                peaks.powers[k] < settings.echo_share * peaks.powers[other]
                and aside < settings.echo_azimuth_deg
                and abs(elevations[k] - elevations[other]) > settings.echo_elevation_deg
            )

        return [k for k in loud if not any(echoes(k, other) for other in loud)]

    def _assign(
        self, sources: list[TrackCandidate], free: list[int], peaks: Peaks, passed: float, time_s: float
    ) -> list[int]:
        """Assign at most one of the peaks ``free`` to each of ``sources`` with the least sum of angles; returns the
        others."""
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
                source.missed_s = 0.0 if found else source.missed_s + passed
                if source.missed_s > settings.missed_s:
                    continue
                source.recent = float(peaks.recent[k])
                source.level = max(source.level, source.recent)
                source.share = float(peaks.powers[k]) / max(self._strongest, settings.keep_power)
                source.add_onsets(peaks.onsets[k], math.exp(-passed / settings.lead_s))
                self._sight(source, peaks, k, passed)
                if source.recent >= settings.heard_power:
                    source.last_seen = time_s
                if found and self._sure(source):
                    source.last_sure = time_s
                    source.heard_s += passed
                    source.unconfirmed_s += passed
                    source.since_moment_s += passed
                    source.speed_radps = max(source.speed_radps, angular_speed(source.motion.velocity))
                if source.recent >= settings.active_power:
                    source.last_active = time_s
        return [k for k in free if k not in taken]

    def _sight(self, source: TrackCandidate, peaks: Peaks, k: int, passed: float) -> None:
        settings = self.settings
        recent = float(peaks.recent[k])
        if recent < settings.heard_power:
            return
        sure = self._sure(source)
        if peaks.powers[k] >= settings.keep_power:
            source.power = float(peaks.powers[k])
            source.echo += min(1.0, passed / settings.echo_s) * (float(peaks.echoes[k]) - source.echo)
            evidence = source.evidence + self._evidence(peaks, k, passed, source.leads)
            source.evidence = min(evidence, settings.max_evidence)
        # Two crossing sources are one peak for a while: each keeps its own motion.
        crowded = any(
            other.id
            and other is not source
            and angle_deg(other.motion.direction, source.motion.direction) < settings.apart_deg
            for other in self._sources
        )
        softer = max(source.level, recent) / recent
        if sure and recent >= settings.keep_power:
            # A mean over all sources biases a weak peak toward a strong one.
            factor = max(0.5, 0.06 / recent) * max(1.0, settings.pull * float(peaks.recent.max()) / recent)
            error = math.radians(settings.error_deg) * softer * factor * (settings.crowded_factor if crowded else 1.0)
            source.motion = source.motion.corrected(peaks.directions[k], error**2)
        steady = peaks.steady[k]
        if sure and peaks.powers[k] >= settings.keep_power and not math.isnan(steady[0]) and not crowded:
            # The long mean is old: moved on by the source's velocity.
            speed = angular_speed(source.motion.velocity)
            since = settings.steady_lag_s - settings.lag_s
            now, _ = along(steady, source.motion.velocity, since)
            if angle_deg(now, source.motion.direction) < settings.gate_deg:
                error = math.radians(settings.steady_error_deg) + settings.steady_error_s * speed
                source.motion = source.motion.corrected(now, (softer * error) ** 2)

    def _sure(self, source: TrackCandidate) -> bool:
        """Whether the current sound of ``source`` is direct, not reverberation or a remnant of other sources."""
        settings = self.settings
        own = source.recent >= max(settings.heard_power, settings.sure_level * source.level)
        return own and source.share >= settings.sure_share

    def _evidence(self, peaks: Peaks, k: int, passed: float, leads: float = 1.0) -> float:
        settings = self.settings
        power, strongest, echo = float(peaks.powers[k]), float(peaks.powers.max()), float(peaks.echoes[k])
        unlike, alike = settings.echo
        least, plain = settings.birth_leads
        own = min(1.0, max(0.0, (alike - echo) / (alike - unlike), (leads - least) / (plain - least)))
        # A peak that is no copy of the strongest may be much weaker.
        share = settings.birth_share * min(1.0, max(0.5, echo / unlike))
        if leads > plain:
            share = min(share, settings.birth_lead_share)
        strength = min(power / settings.birth_power, power / strongest / share)
        gain = own * strength**3 - 1
        return gain * passed / (settings.birth_s if gain > 0 else settings.birth_decay_s)

    def _begin(self, time_s: float, peaks: Peaks, k: int, passed: float) -> TrackCandidate:
        direction, power = peaks.directions[k], float(peaks.powers[k])
        motion = DirectionState(direction, np.zeros(3), math.radians(5.0) ** 2, 0.0, math.radians(10.0) ** 2)
        return TrackCandidate(
            motion,
            power,
            evidence=max(0.0, self._evidence(peaks, k, passed)),
            born=time_s,
            last_seen=time_s,
            last_active=time_s,
            last_sure=time_s,
        )

    def _end_lost(self, time_s: float) -> None:
        def alive(source: TrackCandidate) -> bool:
            if not source.id:
                source.evidence = max(0.0, source.evidence)
                return time_s - source.last_seen <= 0.2
            if source.evidence < 0:
                return False
            speed = math.degrees(angular_speed(source.motion.velocity))
            longest = self.settings.silence_s / (1 + speed / self.settings.walking_degps)
            return time_s - source.last_seen <= min(longest, 0.3 + 0.4 * source.evidence)

        self._sources = [source for source in self._sources if alive(source)]

    def _number_born(self, time_s: float) -> None:
        """Turn candidates with enough evidence into tracks, the strongest first, up to the greatest number."""
        ready = [source for source in self._sources if not source.id and source.evidence >= 1]
        for source in sorted(ready, key=lambda source: -source.power):
            tracks = [other for other in self._sources if other.id]
            lost = self._lost(source, tracks, time_s)
            if lost is not None:
                if not reported(lost, self._sources, time_s, self.settings):
                    # It may be an echo near the track's last direction: it takes the number, but must be confirmed
                    # again.
                    lost.restart_trial(time_s)
                    lost.echo = source.echo
                lost.motion = source.motion.going_on_as(lost.motion)
                lost.power, lost.evidence = source.power, lost.evidence + source.evidence
                lost.last_sure, lost.level, lost.missed_s = source.last_sure, source.level, 0.0
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
            source.restart_trial(time_s)
            self._next += 1
            self._sources.sort(key=lambda source: (not source.id, source.id))

    def _lost(self, source: TrackCandidate, tracks: list[TrackCandidate], time_s: float) -> TrackCandidate | None:
        """The silent track that ``source`` probably continues, by its speed and silence; None if there is none."""
        found, nearest = None, math.inf
        for track in tracks:
            silent = time_s - track.last_sure
            speed = math.degrees(track.speed_radps)
            angle = angle_deg(source.motion.direction, track.motion.direction)
            if silent > 0.15 and angle < min(self.settings.apart_deg + 2 * speed * silent, 30.0, nearest):
                found, nearest = track, angle
        return found

    def _track(self, source: TrackCandidate, time_s: float) -> SoundTrack:
        active = time_s - source.last_active <= self.settings.active_s
        direction, velocity = source.motion.ahead(self.settings.lag_s if active else 0.0)
        return SoundTrack(
            source.id,
            direction,
            velocity=velocity,
            power=source.power,
            active=active,
            born=source.born,
            last_seen=source.last_seen,
        )
