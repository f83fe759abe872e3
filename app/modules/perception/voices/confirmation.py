"""Which tracks are reported: only those confirmed to be no echo, and only while their talker may still be there.

A track is born on trial. It is confirmed by moments in which it is loud by itself, since an echo always comes with what
it follows, and by *leading*: what begins agrees with a talker's direction better than all that sounds does, and with an
echo's no better (precedence effect).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from app.modules.perception.voices.kalman import DirectionState, angle_deg


@dataclass(frozen=True, slots=True)
class TrackerSettings:
    """When tracks are born, how they move, when they are confirmed and reported, and when they die.

    Powers and shares are those of :class:`Peaks`; *held* is what fades with ``hold_s``, over pauses. Times are in s,
    angles in degrees. A tuple of several shares belongs to the tuple of values of
    ``TrackCandidate.echo`` named with it.
    """

    # --- birth ---
    #: Most tracks at a time.
    tracks: int = 4
    #: A peak of this power, and of this share of the strongest, makes a track once it has been there for
    #: ``patience_s``, and sooner by the cube of how much it is above both; below, its evidence is gone in ``mercy_s``.
    birth_power: float = 0.025
    birth_share: float = 0.23
    patience_s: float = 0.3
    mercy_s: float = 0.6
    most_evidence: float = 10.0
    #: None is born nearer to a track than this.
    apart_deg: float = 15.0
    #: A copy of a stronger peak makes a track the later from the first ``Peaks.echoes`` on, and none from the second...
    echo: tuple[float, float] = (0.38, 0.58)
    #: ... unless it leads by more than the first; by the second, this share of the strongest is enough.
    birth_leads: tuple[float, float] = (1.1, 1.25)
    birth_lead_share: float = 0.16
    #: A floor's and a ceiling's echoes: within this azimuth of a stronger peak, this far above or below, and below this
    #: share of it.
    echo_azimuth_deg: float = 15.0
    echo_elevation_deg: float = 20.0
    echo_share: float = 0.5

    # --- life and death ---
    #: A track lives on peaks of this power and share, within this angle of where it must be ...
    keep_power: float = 0.02
    keep_share: float = 0.12
    gate_deg: float = 10.0
    #: ... and without any the longer the more evidence it has, at most so long; shorter for those who walk.
    silence_s: float = 2.5
    walking_degps: float = 8.0
    #: It sounds while its recent power is at least this, and so long after.
    active_power: float = 0.03
    active_s: float = 0.15
    #: Of this recent power, a peak is heard; of the next one, it counts without the search.
    heard_power: float = 0.015
    sure_power: float = 0.06
    #: One that falls silent as another begins so near ends once that one was heard for so long.
    replaced_s: float = 0.2
    replaced_deg: float = 35.0

    # --- motion ---
    #: How much the angular velocity may change in one second (1-sigma), and by which share of itself.
    jerk_degps: float = 8.0
    jerk_share: float = 1.0
    #: How soon a silent one is supposed to have stopped.
    rest_s: float = 3.0
    #: Error of a strong peak of the short mean, and how old it is on average. It is the greater, the softer the source
    #: is than its own level: in pauses the room pulls a peak away for long, and never at random.
    error_deg: float = 6.0
    lag_s: float = 0.05
    #: The same of the long mean; and for each rad/s of speed.
    steady_error_deg: float = 6.0
    steady_lag_s: float = 0.4
    steady_doubt: float = 2.0
    #: How much a weak peak is pulled by a strong one; how much less is believed where two tracks are near.
    pull: float = 1.2
    crowd_doubt: float = 3.0

    # --- what is heard is the source itself, not what the room leaves there ---
    hold_s: float = 1.5
    #: Of its own held level, and of the strongest's held power.
    sure_level: float = 0.3
    sure_share: float = 0.18
    #: What the search does not find for so long moves nothing.
    missed_s: float = 0.3

    # --- confirmation: again and again, within ``trial_s`` of birth and then within ``trust_s`` of its sound ---
    trial_s: float = 0.7
    trust_s: float = 2.5
    #: The mean of ``TrackCandidate.echo`` is over so long.
    echo_s: float = 0.5
    #: It must be this share of the strongest (by ``confirm_echo``) ...
    confirm_share: tuple[float, ...] = (0.25, 0.38, 0.6)
    confirm_echo: tuple[float, ...] = (0.15, 0.35, 0.5)
    #: ... or for so many steps louder than this share of each other's held level, of at least this power;
    confirm_steps: int = 2
    confirm_loud: float = 0.7
    confirm_power: float = 0.04
    #: and for a moment this share of the loudest held moment of all; once, of this share by ``confirm_echo``, or be
    #: heard for ``trial_s`` without a break.
    confirm_moment: float = 0.4
    confirm_moments: tuple[float, ...] = (0.4, 0.55, 0.65)
    #: Beside a louder track that leads by this and more ...
    lead_live: float = 1.25
    #: ... it must lead by this share of what that one does above 1 (by ``lead_echo``; on trial, the second), ...
    lead_share: tuple[float, ...] = (0.1, 0.26, 0.5, 0.8)
    lead_echo: tuple[float, ...] = (0.15, 0.35, 0.5, 0.65)
    #: ... from so much sound of it on.
    soon_s: float = 0.3
    #: One that leads by this share, and is a copy by less than this, needs the moment alone.
    lead_plain: float = 0.85
    plain_echo: float = 0.45
    #: What sounded is remembered so long.
    lead_s: float = 2.5

    # --- report: a silent track keeps its number, but is reported no longer than ---
    #: this and so many times as long as it was heard,
    report_s: float = 0.2
    report_heard: float = 0.8
    #: this if it moved faster than this,
    report_moving_s: float = 1.5
    moving_degps: float = 5.0
    #: this within this angle of one that sounds.
    hidden_s: float = 0.5
    hidden_deg: float = 30.0


@dataclass(slots=True, eq=False)
class TrackCandidate:
    """A track, or what may become one (``id`` 0); ``evidence`` 1 and more makes it one.

    ``recent`` and ``share``: power of the last moments, and of the last half second in those of the strongest, which is
    held over pauses; as of now, 0 if it is not heard. ``level``: the greatest ``recent``, fading; ``speed_radps``: the
    greatest speed, fading. ``louder``: for how many steps it was louder than each other track. ``heard_s``: for how
    long it was heard since its birth; ``unconfirmed_s``: since it last sounded of itself; ``confirmed``: it ever did;
    ``since_loud_s``: since it was last as loud as a moment of a talker's own is. ``tried``: since when it is on trial;
    ``broken``: when it was last not heard, or put on trial; ``own``: whether it showed since that it is no copy.
    ``missed_s``: for how long the search has not found what is heard; ``last_sure``: when it was last surely itself.
    ``echo``: how much it is a copy of others, on average. ``onsets`` (4,): how well what began, and all that sounded,
    agreed with it, and the most that either could have; fading. ``leads``: how much better it agrees with what begins
    than with all that sounds: an echo about 1, a talker in a room about 1.4.
    """

    motion: DirectionState
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
    missed_s: float = 0.0
    last_sure: float = 0.0
    level: float = 0.0
    speed_radps: float = 0.0
    unconfirmed_s: float = 0.0
    since_loud_s: float = math.inf
    tried: float = 0.0
    broken: float = 0.0
    echo: float = 0.35
    confirmed: bool = False
    own: bool = False
    onsets: NDArray[np.float64] = field(default_factory=lambda: np.zeros(4))
    leads: float = 1.0

    def hear(self, onsets: NDArray[np.float64], keep: float) -> None:
        """Take the next ``onsets`` (4,) of it; ``keep`` in [0, 1]: how much of the former counts still."""
        self.onsets = self.onsets * keep + onsets
        rising, heard, most_rising, most = self.onsets.tolist()
        self.leads = rising * most / (most_rising * heard) if heard > 0 and most_rising > 0 else 1.0

    def restart_trial(self, time_s: float) -> None:
        """Put it on trial as of ``time_s`` (s): whatever it is now has shown nothing yet."""
        self.tried = self.broken = time_s
        self.confirmed, self.own, self.louder = False, False, 0
        self.heard_s = self.unconfirmed_s = 0.0
        self.since_loud_s = math.inf


def reported(
    source: TrackCandidate, sources: Sequence[TrackCandidate], time_s: float, settings: TrackerSettings
) -> bool:
    """Whether ``source``, one of ``sources``, is to be reported at ``time_s`` (s)."""
    on_trial = time_s - source.tried < settings.trial_s
    least, plain = _leads(source, sources, on_trial, settings)
    trusted = on_trial
    if source.confirmed:
        trusted = (
            (trusted or source.own)
            and source.unconfirmed_s < settings.trust_s
            and source.since_loud_s < settings.trust_s
        )
    trusted = trusted or (plain and source.since_loud_s < settings.trust_s)
    trusted = trusted and (least or (on_trial and source.heard_s <= settings.soon_s))
    moving = math.degrees(source.speed_radps) > settings.moving_degps
    longest = settings.report_moving_s if moving else settings.silence_s
    longest = min(longest, settings.report_s + settings.report_heard * source.heard_s)
    silent = time_s - source.last_sure
    return bool(source.id) and trusted and silent <= longest and not _hidden(source, silent, sources, time_s, settings)


def _hidden(
    source: TrackCandidate, silent: float, sources: Sequence[TrackCandidate], time_s: float, settings: TrackerSettings
) -> bool:
    """Whether it is silent beside another that sounds: what is left where two passed one another."""
    return silent > settings.hidden_s and any(
        other.id
        and other is not source
        and other.confirmed
        and time_s - other.last_sure < settings.active_s
        and angle_deg(other.motion.direction, source.motion.direction) < settings.hidden_deg
        for other in sources
    )


def _leads(
    source: TrackCandidate, sources: Sequence[TrackCandidate], on_trial: bool, settings: TrackerSettings
) -> tuple[bool, bool]:
    """Whether it begins of itself as far as it must (nobody louder, nothing it could be an echo of); and plainly."""
    other = max(
        other.leads if other.id and other.level >= source.level and other.heard_s > settings.replaced_s else 1.0
        for other in sources
    )
    if other < settings.lead_live:
        return True, False
    lead = (source.leads - 1) / (other - 1)
    echo = settings.lead_echo[1] if on_trial else source.echo
    least = lead >= float(np.interp(echo, settings.lead_echo, settings.lead_share))
    return least, lead >= settings.lead_plain and source.echo < settings.plain_echo


def confirm(sources: Sequence[TrackCandidate], loudest: float, time_s: float, settings: TrackerSettings) -> None:
    """Note which of ``sources`` sound of themselves at ``time_s`` (s); ``loudest``: the most any did of late."""
    tracks = [source for source in sources if source.id]
    for source in tracks:
        if source.recent >= settings.confirm_moment * loudest:
            source.since_loud_s = 0.0
        if source.last_sure < time_s:
            source.broken = time_s
        if not source.own:
            moment = float(np.interp(source.echo, settings.confirm_echo, settings.confirm_moments))
            source.own = source.recent >= moment * loudest or time_s - source.broken >= settings.trial_s
        if source.recent < settings.confirm_power:
            continue
        source.louder += all(
            source.recent > settings.confirm_loud * other.level for other in tracks if other is not source
        )
        share = float(np.interp(source.echo, settings.confirm_echo, settings.confirm_share))
        enough = source.share >= share or source.louder >= settings.confirm_steps
        if enough and source.since_loud_s < settings.trust_s:
            source.confirmed, source.unconfirmed_s, source.louder = True, 0.0, 0
