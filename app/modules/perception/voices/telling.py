"""Whom to tell of among the tracks: an echo has to be told from a talker, and a silent track from one who left."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from app.modules.perception.voices.motion import Motion, angle_deg


@dataclass(frozen=True, slots=True)
class TrackerSettings:
    """When tracks are born, how they move and when they die.

    ``tracks``: most at a time. A peak of ``birth_power``, and of ``birth_share`` of the strongest one, makes a track
    once it has been there for ``patience_s``, and sooner by the cube of how much it is above both. A track lives on
    peaks of ``keep_power`` and ``keep_share`` within ``gate_deg`` of where it must be, and without any the longer the
    better it was heard before, at most ``silence_s``. A floor's and a ceiling's echoes come from above and below their
    source: a peak within ``echo_azimuth_deg`` of a stronger one, but higher or lower by ``echo_elevation_deg`` and more
    and below ``echo_share`` of it, is none of either. A peak that is a copy of a stronger one makes no track from the
    second of ``echo`` on, and one the later from the first on; unless it leads (:attr:`Source.leads`) by more than the
    first of ``birth_leads``, and from the second on ``birth_lead_share`` of the strongest is enough. A track sounds (is
    active) while peaks' recent powers are at least ``active_power``, and for ``active_s`` longer. ``apart_deg``: nearer
    to a track none other is born. What is heard of a track counts as itself if it is ``sure_level`` of its own level
    and ``sure_share`` of the strongest, both held over pauses (``hold_s``), and if the search finds it, too, within
    ``unfound_s``: the rest is the room's and the others' and moves nothing. An echo only ever follows: again and again,
    within ``trial_s`` of its birth and then within ``trust_s`` of sound, a track must be ``proof_share`` of the
    strongest or, for ``proof_steps`` steps, louder than ``proof_loud`` of each other's level; until it is, it is not
    told of. The share it needs is the larger, the more it is a copy of others (``proof_echo``,
    mean over ``echo_s``). And in a moment of the same time it must have been ``proof_moment`` of the loudest moment of
    all, which is held, too (``hold_s``). Whoever may be a copy needs once, for all the time he is then followed, a
    moment the louder, the more he is one (``proof_moments``, by ``proof_echo``), or to be heard for ``trial_s`` without
    a break: echoes come and go with what they follow. Nor does an echo begin of itself: beside a louder track that
    leads by ``lead_live`` and more, a track must lead by ``lead_share`` of what that one does above 1, the more, the
    more it is a copy (``lead_echo``); on trial by the second share, and not before ``soon_s`` of sound. One that
    leads by ``lead_plain`` of it, and is a copy by less than ``plain_echo``, needs nothing but the moment. What sounded
    is remembered for ``lead_s``. Nor is one told of that is silent for longer than ``told_s`` and ``told_heard`` times
    as long as it was heard, or than ``told_moving_s`` if it moved by more than ``moving_degps``, or than ``hidden_s``
    within ``hidden_deg`` of one that sounds: it keeps its number, for when it is heard again. One that falls silent as
    another begins within ``replaced_deg`` ends once that one was heard for ``replaced_s``.
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
    trial_s: float = 0.7
    proof_share: tuple[float, ...] = (0.25, 0.38, 0.6)
    proof_echo: tuple[float, ...] = (0.15, 0.35, 0.5)
    proof_loud: float = 0.7
    proof_moment: float = 0.4
    proof_moments: tuple[float, ...] = (0.4, 0.55, 0.65)
    proof_power: float = 0.04
    proof_steps: int = 2
    lead_live: float = 1.25
    lead_share: tuple[float, ...] = (0.1, 0.26, 0.5, 0.8)
    lead_echo: tuple[float, ...] = (0.15, 0.35, 0.5, 0.65)
    lead_plain: float = 0.85
    plain_echo: float = 0.45
    lead_s: float = 2.5
    soon_s: float = 0.3
    birth_leads: tuple[float, float] = (1.1, 1.25)
    birth_lead_share: float = 0.16
    sure_power: float = 0.06
    error_deg: float = 6.0
    lag_s: float = 0.05
    steady_error_deg: float = 6.0
    steady_lag_s: float = 0.4
    pull: float = 1.2
    crowd_doubt: float = 3.0
    steady_doubt: float = 2.0


@dataclass(slots=True, eq=False)
class Source:
    """A track, or what may become one (``id`` 0); ``evidence`` 1 and more makes it one.

    ``recent`` and ``share``: power of the last moments, and of the last half second in those of the strongest, which is
    held over pauses; as of now, 0 if it is not heard. ``level``: the greatest ``recent``, fading; ``pace`` (rad/s): the
    greatest speed, fading. ``louder``: for how many steps it was louder than each other track. ``heard_s``: for how
    long it was heard since its birth; ``unproven_s``: since it last sounded of itself; ``proven``: it ever did;
    ``faint_s``: since it was last as loud as a moment of a talker's own is. ``tried``: since when it is on trial;
    ``broken``: when it was last not heard, or put on trial; ``own``: whether it showed since that it is no copy.
    ``unfound_s``: for how long the search has not found what is heard; ``last_sure``: when it was last surely itself.
    ``echo``: how much it is a copy of others, on average. ``onsets`` (4,): how well what began, and all that sounded,
    agreed with it, and the most that either could have; fading. ``leads``: how much better it agrees with what begins
    than with all that sounds: an echo about 1, a talker in a room about 1.4.
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
    faint_s: float = math.inf
    tried: float = 0.0
    broken: float = 0.0
    echo: float = 0.35
    proven: bool = False
    own: bool = False
    onsets: NDArray[np.float64] = field(default_factory=lambda: np.zeros(4))
    leads: float = 1.0

    def hear(self, onsets: NDArray[np.float64], keep: float) -> None:
        """Take the next ``onsets`` (4,) of it; ``keep`` in [0, 1]: how much of the former counts still."""
        self.onsets = self.onsets * keep + onsets
        begun, heard, most_begun, most = self.onsets.tolist()
        self.leads = begun * most / (most_begun * heard) if heard > 0 and most_begun > 0 else 1.0

    def try_anew(self, time_s: float) -> None:
        """Put it on trial as of ``time_s`` (s): whatever it is now has shown nothing yet."""
        self.tried = self.broken = time_s
        self.proven, self.own, self.louder = False, False, 0
        self.heard_s = self.unproven_s = 0.0
        self.faint_s = math.inf


def told(source: Source, sources: Sequence[Source], time_s: float, settings: TrackerSettings) -> bool:
    """Whether ``source``, one of ``sources``, is to be told of at ``time_s`` (s)."""
    on_trial = time_s - source.tried < settings.trial_s
    least, plain = _leads(source, sources, on_trial, settings)
    trusted = on_trial
    if source.proven:
        trusted = (trusted or source.own) and source.unproven_s < settings.trust_s and source.faint_s < settings.trust_s
    trusted = trusted or (plain and source.faint_s < settings.trust_s)
    trusted = trusted and (least or (on_trial and source.heard_s <= settings.soon_s))
    moving = math.degrees(source.pace) > settings.moving_degps
    longest = settings.told_moving_s if moving else settings.silence_s
    longest = min(longest, settings.told_s + settings.told_heard * source.heard_s)
    silent = time_s - source.last_sure
    return bool(source.id) and trusted and silent <= longest and not _hidden(source, silent, sources, time_s, settings)


def _hidden(source: Source, silent: float, sources: Sequence[Source], time_s: float, settings: TrackerSettings) -> bool:
    """Whether it is silent beside another that sounds: what is left where two passed one another."""
    return silent > settings.hidden_s and any(
        other.id
        and other is not source
        and other.proven
        and time_s - other.last_sure < settings.active_s
        and angle_deg(other.motion.direction, source.motion.direction) < settings.hidden_deg
        for other in sources
    )


def _leads(source: Source, sources: Sequence[Source], on_trial: bool, settings: TrackerSettings) -> tuple[bool, bool]:
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


def prove(sources: Sequence[Source], loudest: float, time_s: float, settings: TrackerSettings) -> None:
    """Note which of ``sources`` sound of themselves at ``time_s`` (s); ``loudest``: the most any did of late."""
    tracks = [source for source in sources if source.id]
    for source in tracks:
        if source.recent >= settings.proof_moment * loudest:
            source.faint_s = 0.0
        if source.last_sure < time_s:
            source.broken = time_s
        if not source.own:
            moment = float(np.interp(source.echo, settings.proof_echo, settings.proof_moments))
            source.own = source.recent >= moment * loudest or time_s - source.broken >= settings.trial_s
        if source.recent < settings.proof_power:
            continue
        source.louder += all(
            source.recent > settings.proof_loud * other.level for other in tracks if other is not source
        )
        share = float(np.interp(source.echo, settings.proof_echo, settings.proof_share))
        enough = source.share >= share or source.louder >= settings.proof_steps
        if enough and source.faint_s < settings.trust_s:
            source.proven, source.unproven_s, source.louder = True, 0.0, 0
