"""Track confirmation: which tracks are reported as sources, and for how long after their last sound. A new track is on
trial. Two observations distinguish a source from an echo. A source has moments in which it is loud while other tracks
are not; an echo always accompanies its source. And onsets agree with a source's direction better than sound in general
does, with an echo's direction no better (precedence effect, Litovsky et al. 1999).
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
    """Parameters of birth, motion, confirmation, report and death of tracks.

    Powers and shares are those of :class:`Peaks` (in [0, 1]); times in s, angles in degrees. A *held* value is a
    running maximum with decay time constant ``hold_s``. A tuple of shares is interpolated linearly over the tuple of
    ``TrackCandidate.echo`` named with it, constant beyond its ends. All defaults were fitted to the recordings of
    ``benchmarks/voices.py``; the ratio of direct to reverberant onsets is the precedence effect (docs/voices.md).
    """

    # --- birth: with g = w min(power / birth_power, share / birth_share)^3, the evidence of a candidate grows by
    # (g - 1) dt / birth_s where g > 1, else falls by (1 - g) dt / birth_decay_s; at 1 the candidate becomes a track ---
    #: Greatest number of tracks.
    tracks: int = 4
    #: Reference power of a peak, and its reference share of the strongest peak. The share is scaled by
    #: echo / ``echo[0]``, within [0.5, 1].
    birth_power: float = 0.025
    birth_share: float = 0.23
    #: Time constants of growing and of falling evidence (s), and the greatest evidence.
    birth_s: float = 0.3
    birth_decay_s: float = 0.6
    max_evidence: float = 10.0
    #: Least angle between a new track and an existing one.
    apart_deg: float = 15.0
    #: ``Peaks.echoes`` of a peak: w falls linearly from 1 at the first value to 0 at the second ...
    echo: tuple[float, float] = (0.38, 0.58)
    #: ... but is at least the position of the onset ratio between these values, in [0, 1]. Above the second value,
    #: ``birth_lead_share`` is enough as the share of the strongest peak.
    birth_leads: tuple[float, float] = (1.1, 1.25)
    birth_lead_share: float = 0.16
    #: A peak is ignored as an echo of the floor or ceiling if another peak is within this azimuth (scaled by the cosine
    #: of the elevation), differs by more than this elevation, and has more than 1 / ``echo_share`` times its power.
    echo_azimuth_deg: float = 15.0
    echo_elevation_deg: float = 20.0
    echo_share: float = 0.5

    # --- life and death ---
    #: Least power and share of the strongest peak for a peak to update a track, and greatest angle from the predicted
    #: direction (plus its standard deviation, at most 5).
    keep_power: float = 0.02
    keep_share: float = 0.12
    gate_deg: float = 10.0
    #: A track ends after min(``silence_s`` / (1 + speed / ``walking_degps``), 0.3 + 0.4 evidence) without a peak.
    silence_s: float = 2.5
    walking_degps: float = 8.0
    #: A track is active while its recent power is at least this, and for this time after.
    active_power: float = 0.03
    active_s: float = 0.15
    #: Least recent power of a peak that counts at all, and of one that counts without the half-second search.
    heard_power: float = 0.015
    sure_power: float = 0.06
    #: A track that fell silent within this angle of a newer confirmed one, before that one was born, ends once the
    #: newer one was heard for this time.
    replaced_s: float = 0.2
    replaced_deg: float = 35.0

    # --- motion: a Kalman filter of constant velocity on the sphere ---
    #: Process noise: change of the angular velocity in one second (1 sigma), plus this share of the velocity.
    jerk_degps: float = 8.0
    jerk_share: float = 1.0
    #: Time constant with which the velocity of a silent track decays.
    rest_s: float = 3.0
    #: Measurement by the short mean: error (1 sigma) of a strong peak, and mean age. The error is scaled by held level
    #: / recent power (at least 1), since reverberation biases peaks in pauses.
    error_deg: float = 6.0
    lag_s: float = 0.05
    #: Measurement by the long mean: error and mean age; increase of the error (rad) per rad/s of speed.
    steady_error_deg: float = 6.0
    steady_lag_s: float = 0.4
    steady_error_s: float = 2.0
    #: Scale of a weak peak's error: ``pull`` times strongest / own recent power (at least 1); further factor where
    #: another track is within ``apart_deg``.
    pull: float = 1.2
    crowded_factor: float = 3.0

    # --- direct sound: a moment counts as the source's own, not as reverberation ---
    hold_s: float = 1.5
    #: Least recent power as a share of the track's held level, and least share of the strongest held power.
    sure_level: float = 0.3
    sure_share: float = 0.18
    #: After this time without a peak in the half-second search, other peaks no longer move the track.
    missed_s: float = 0.3

    # --- confirmation: a track is reported while on trial, for ``trial_s`` after birth; then while conditions 1 and 2
    # held within ``confirmed_s`` of its direct sound, and conditions 3 and 4 hold ---
    trial_s: float = 0.7
    confirmed_s: float = 2.5
    #: Time constant of the mean of ``TrackCandidate.echo``.
    echo_s: float = 0.5
    #: Condition 1: recent power of at least ``confirm_power``, and either (a) this share of the strongest held power,
    #: by echo,
    confirm_share: tuple[float, ...] = (0.25, 0.38, 0.6)
    confirm_echo: tuple[float, ...] = (0.15, 0.35, 0.5)
    #: or (b) in this many steps, a recent power above this share of every other track's held level.
    confirm_steps: int = 2
    confirm_loud: float = 0.7
    confirm_power: float = 0.04
    #: Condition 2: within ``confirmed_s`` of direct sound, a moment of this share of the loudest held moment of all
    #: tracks. Condition 3, once per track: a moment of this share by ``confirm_echo``, or ``trial_s`` of direct sound
    #: without a gap.
    confirm_moment: float = 0.4
    confirm_moments: tuple[float, ...] = (0.4, 0.55, 0.65)
    #: Condition 4, where a track at least as loud (held) has an onset ratio r of at least this: the track's own onset
    #: ratio is at least 1 + share * (r - 1), the share by ``lead_echo`` (on trial: its second value).
    lead_other: float = 1.25
    lead_share: tuple[float, ...] = (0.1, 0.26, 0.5, 0.8)
    lead_echo: tuple[float, ...] = (0.15, 0.35, 0.5, 0.65)
    #: On trial, condition 4 applies after this time of direct sound.
    soon_s: float = 0.3
    #: Condition 2 alone is enough with a share of condition 4 of at least this and an echo below this.
    lead_plain: float = 0.85
    plain_echo: float = 0.45
    #: Time constant of the sums behind the onset ratio.
    lead_s: float = 2.5

    # --- report: greatest time since the last direct sound; the least of the following ---
    #: This, plus this share of the time the track was heard;
    report_s: float = 0.2
    report_heard: float = 0.8
    #: this, if the held speed is above ``moving_degps`` (else ``silence_s``);
    report_moving_s: float = 1.5
    moving_degps: float = 5.0
    #: this, within this angle of a confirmed track that sounds.
    hidden_s: float = 0.5
    hidden_deg: float = 30.0


@dataclass(slots=True, eq=False)
class TrackCandidate:
    """A track, or a candidate for one (``id`` 0); a candidate becomes a track at ``evidence`` 1.

    - ``recent``: power of the last moments, 0 if it is not heard; ``share``: power over the last half second as a share
      of the strongest held power.
    - ``level``: held ``recent``; ``speed_radps``: held speed.
    - ``louder``: number of steps in which it was louder than ``confirm_loud`` of every other track.
    - ``heard_s``: time of direct sound since birth; ``unconfirmed_s``: since the last confirmation; ``since_moment_s``:
      since the last loud moment (``confirm_moment``).
    - ``confirmed``: whether it ever was; ``trial_start``: begin of the trial; ``last_gap``: last time without direct
      sound; ``independent``: whether condition 3 is met.
    - ``missed_s``: time since the half-second search found it; ``last_sure``: time of the last direct sound.
    - ``echo``: mean of ``Peaks.echoes``.
    - ``onsets`` (4,): decaying sums of ``Onsets.agreement``; ``leads``: the onset ratio, agreement with onsets over
      agreement with all sound, each relative to its greatest possible value: about 1 for an echo, about 1.4 for a
      talker in a room.
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
    since_moment_s: float = math.inf
    trial_start: float = 0.0
    last_gap: float = 0.0
    echo: float = 0.35
    confirmed: bool = False
    independent: bool = False
    onsets: NDArray[np.float64] = field(default_factory=lambda: np.zeros(4))
    leads: float = 1.0

    def add_onsets(self, onsets: NDArray[np.float64], keep: float) -> None:
        """Add ``onsets`` (4,) to the decaying sums; ``keep`` in [0, 1]: weight of the sums so far."""
        self.onsets = self.onsets * keep + onsets
        rising, heard, most_rising, most = self.onsets.tolist()
        self.leads = rising * most / (most_rising * heard) if heard > 0 and most_rising > 0 else 1.0

    def restart_trial(self, time_s: float) -> None:
        """Put the track on trial from ``time_s`` (s) on, without its earlier confirmations."""
        self.trial_start = self.last_gap = time_s
        self.confirmed, self.independent, self.louder = False, False, 0
        self.heard_s = self.unconfirmed_s = 0.0
        self.since_moment_s = math.inf


def reported(
    source: TrackCandidate, sources: Sequence[TrackCandidate], time_s: float, settings: TrackerSettings
) -> bool:
    """Whether ``source``, one of ``sources``, is reported at ``time_s`` (s)."""
    on_trial = time_s - source.trial_start < settings.trial_s
    least, plain = _leads(source, sources, on_trial, settings)
    trusted = on_trial
    if source.confirmed:
        trusted = (
            (trusted or source.independent)
            and source.unconfirmed_s < settings.confirmed_s
            and source.since_moment_s < settings.confirmed_s
        )
    trusted = trusted or (plain and source.since_moment_s < settings.confirmed_s)
    trusted = trusted and (least or (on_trial and source.heard_s <= settings.soon_s))
    moving = math.degrees(source.speed_radps) > settings.moving_degps
    longest = settings.report_moving_s if moving else settings.silence_s
    longest = min(longest, settings.report_s + settings.report_heard * source.heard_s)
    silent = time_s - source.last_sure
    return bool(source.id) and trusted and silent <= longest and not _hidden(source, silent, sources, time_s, settings)


def _hidden(
    source: TrackCandidate, silent: float, sources: Sequence[TrackCandidate], time_s: float, settings: TrackerSettings
) -> bool:
    """Whether it is silent beside another that sounds: a remnant of two crossing tracks."""
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
    """Whether condition 4 of the settings holds, and whether it holds by ``lead_plain`` and ``plain_echo``."""
    other = max(
        other.leads if other.id and other.level >= source.level and other.heard_s > settings.replaced_s else 1.0
        for other in sources
    )
    if other < settings.lead_other:
        return True, False
    lead = (source.leads - 1) / (other - 1)
    echo = settings.lead_echo[1] if on_trial else source.echo
    least = lead >= float(np.interp(echo, settings.lead_echo, settings.lead_share))
    return least, lead >= settings.lead_plain and source.echo < settings.plain_echo


def confirm(sources: Sequence[TrackCandidate], loudest: float, time_s: float, settings: TrackerSettings) -> None:
    """Update the confirmation of ``sources`` at ``time_s`` (s). ``loudest``: the held recent power of all peaks."""
    tracks = [source for source in sources if source.id]
    for source in tracks:
        if source.recent >= settings.confirm_moment * loudest:
            source.since_moment_s = 0.0
        if source.last_sure < time_s:
            source.last_gap = time_s
        if not source.independent:
            moment = float(np.interp(source.echo, settings.confirm_echo, settings.confirm_moments))
            source.independent = source.recent >= moment * loudest or time_s - source.last_gap >= settings.trial_s
        if source.recent < settings.confirm_power:
            continue
        source.louder += all(
            source.recent > settings.confirm_loud * other.level for other in tracks if other is not source
        )
        share = float(np.interp(source.echo, settings.confirm_echo, settings.confirm_share))
        enough = source.share >= share or source.louder >= settings.confirm_steps
        if enough and source.since_moment_s < settings.confirmed_s:
            source.confirmed, source.unconfirmed_s, source.louder = True, 0.0, 0
