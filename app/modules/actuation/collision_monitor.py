"""The collision monitor: what of a commanded twist may be given to the wheels, by what the laser sees now.

It knows nothing of plans or of who drives. Along the arc that the command would drive, the time until the footprint,
grown by a margin, meets what the laser sees is computed exactly (``swept_footprint``); the command is scaled, its arc
kept, until

- the body can still stop before it, at the deceleration it really has and after the time everything takes to react;
- it is at least ``contact_s`` away.

What the grown footprint only brushes past is passed at a crawl; what already is within the margin is neared no faster,
and only as far as the footprint itself. What moves away from a thing is never held back, so that one gets out of a
tight place. Where an arc is stopped, its turn on the spot is tried. Backwards, where the laser does not see, the body
crawls.

The rule of slowing to keep a time to contact is Nav2's *approach* (collision monitor of the ROS 2 Navigation stack);
the braking rule is that of the Dynamic Window Approach (Fox, Burgard, Thrun 1997).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from app.base.geometry import Pose2
from app.link import BaseLimits
from app.messages import LaserScan
from app.modules.actuation.swept_footprint import Floats, Points, Polygon, contact_times, may_decide

#: Slower than this (m/s and rad/s) is standing: a command cut down to less is a stop. A body that stands starts again
#: only for twice as much, or the laser's noise would have it jerk.
STANDING_MPS, STANDING_RADPS = 0.03, 0.08
#: A point is neared when it comes closer by more than this share of its own speed past the body; a thing that touches a
#: round body, drawn as a polygon, may scrape along its edges while the body turns.
NEARED, NEARED_IN_TOUCH = 0.02, 0.25


@dataclass(frozen=True, slots=True)
class Rules:
    """How careful the monitor is.

    ``margin_m`` around the footprint; ``contact_s`` is the least time to contact; ``reaction_s`` the time from a ray to
    wheels that obey; a scan older than ``stale_s``, or as far ahead of its time, is none; ``crawl_mps`` and
    ``crawl_radps`` are what is allowed where nothing is known; so many points as ``evidence`` make a thing: one alone
    may be noise.
    """

    margin_m: float = 0.05
    contact_s: float = 1.0
    reaction_s: float = 0.15
    stale_s: float = 0.3
    crawl_mps: float = 0.1
    crawl_radps: float = 0.3
    evidence: int = 2


@dataclass(frozen=True, slots=True)
class Verdict:
    """The velocity that may be driven (m/s, rad/s), and why it is not the commanded one ("" where it is)."""

    linear: float
    angular: float
    reason: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """What one scan saw: the near ``points`` (N,), x + iy m in ``base_link`` at ``stamp`` (s), the middle of its sweep;
    whether the laser looks along the body's x axis ``ahead`` and ``behind``; ``dead``: not one ray measured anything,
    not even that nothing is there."""

    stamp: float
    points: Points
    ahead: bool
    behind: bool
    dead: bool


class CollisionMonitor:
    """Judges commands for one body: a pure function of what it is given, but for a table of the scan's angles."""

    def __init__(self, corners: tuple[tuple[float, float], ...], limits: BaseLimits, rules: Rules) -> None:
        """``corners`` as ``RobotDescription.footprint``. Raises ValueError for what is no footprint."""
        self.rules = rules
        self._limits = limits
        self._tight = Polygon.of(corners)
        self._grown = Polygon.of(corners, rules.margin_m)
        slowest_stop = max(limits.linear_mps / limits.linear_mps2, limits.angular_radps / limits.angular_radps2)
        self._horizon_s = max(rules.contact_s, rules.reaction_s + slowest_stop / 2)
        #: Further than this (m) from the base nothing matters, however old the scan may be.
        self.reach_m = self._grown.outer + limits.linear_mps * (self._horizon_s + rules.stale_s)
        self._angles: tuple[int, float, float] | None = None
        self._cosines = self._sines = np.empty(0)

    def see(self, scan: LaserScan) -> Seen:
        """The points of ``scan`` that may matter."""
        key = (len(scan.ranges), scan.angle_min, scan.angle_increment)
        if key != self._angles:
            angles = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
            self._angles, self._cosines, self._sines = key, np.cos(angles), np.sin(angles)
        rotation, place = scan.X_BL.rotation, scan.X_BL.translation
        offset = math.hypot(place[0], place[1])
        measured = scan.ranges >= scan.range_min
        near = np.flatnonzero(measured & (scan.ranges < min(self.reach_m + offset, scan.range_max)))
        ranges = scan.ranges[near].astype(np.float64)
        x, y = ranges * self._cosines[near], ranges * self._sines[near]
        points = np.empty(len(near), np.complex128)
        points.real = rotation[0, 0] * x + rotation[0, 1] * y + place[0]
        points.imag = rotation[1, 0] * x + rotation[1, 1] * y + place[1]
        last = scan.angle_min + scan.angle_increment * (len(scan.ranges) - 1)
        yaw = math.atan2(rotation[1, 0], rotation[0, 0])
        first, last = min(scan.angle_min, last), max(scan.angle_min, last)
        middle = scan.stamp + scan.duration_s / 2
        ahead, behind = _looks(first, last, -yaw), _looks(first, last, math.pi - yaw)
        return Seen(middle, points, ahead, behind, not measured.any())

    def judge(self, seen: Seen, X_SB: Pose2, linear: float, angular: float, *, stands: bool = False) -> Verdict:
        """What may be driven of (``linear``, ``angular``); the base has moved by ``X_SB`` since ``seen`` was seen, and
        ``stands`` now or drives."""
        if linear == 0.0 and angular == 0.0:
            return Verdict(0.0, 0.0)
        if seen.dead:
            return Verdict(0.0, 0.0, "stopped: no ray of the laser measures anything: is it covered?")
        turned = complex(math.cos(X_SB.theta), -math.sin(X_SB.theta))
        points = (seen.points - complex(X_SB.x, X_SB.y)) * turned
        scale, where = self._scale(points, linear, angular, stands)
        reason = "" if where is None else self._words(complex(points[where]), scale)
        crawl = self._crawl(linear, angular)
        hidden = (linear > 0 and not seen.ahead) or (linear < 0 and not seen.behind)
        if hidden and crawl < scale:
            scale, reason = crawl, f"slowed: the laser does not see {'ahead' if linear > 0 else 'behind'}"
        if scale == 0.0 and linear != 0.0 and angular != 0.0:
            turn, _ = self._scale(points, 0.0, angular, stands)
            if turn > 0.0:
                return Verdict(0.0, turn * angular, f"{reason}; it turns")
        return Verdict(scale * linear, scale * angular, reason)

    def blind(self, age_s: float | None) -> Verdict:
        """What may be driven while the newest scan is ``age_s`` old, which is too old or no age (None: there is no
        scan)."""
        if age_s is None:
            why = "the laser has given no scan yet"
        elif age_s > 0.0:
            why = "the laser gives no new scans"
        else:
            why = "the laser's stamps are not of the robot's clock"
        return Verdict(0.0, 0.0, f"stopped: {why}")

    def crawl(self, linear: float, angular: float) -> Verdict:
        """What may be driven on an operator's explicit hold, whatever stands in the way."""
        scale = self._crawl(linear, angular)
        return Verdict(scale * linear, scale * angular, "override: it crawls, whatever is in the way")

    def _crawl(self, linear: float, angular: float) -> float:
        return min(
            1.0,
            self.rules.crawl_mps / abs(linear) if linear else 1.0,
            self.rules.crawl_radps / abs(angular) if angular else 1.0,
        )

    def _scale(self, points: Points, linear: float, angular: float, stands: bool) -> tuple[float, int | None]:
        """The share of the command that may be driven, in [0, 1], and the point that says so."""
        rules, horizon = self.rules, self._horizon_s
        near = may_decide(
            points,
            self._tight,
            grown=self._grown,
            linear=linear,
            angular=angular,
            horizon_s=horizon,
            evidence=rules.evidence,
        )
        if len(near) < rules.evidence:
            return 1.0, None
        times = contact_times(points[near], self._grown, linear, angular, horizon)
        met = times < np.inf
        near, times = near[met], times[met]
        if len(near) < rules.evidence:
            return 1.0, None
        shares = self._share(times, linear, angular)
        crawl = self._crawl(linear, angular)
        slow = np.flatnonzero(shares < crawl)
        if len(slow):
            # Slower than a crawl only before what the footprint itself would meet; what it brushes past is passed.
            passed_s = horizon + 2 * self._grown.outer / max(abs(linear), abs(angular) * self._tight.inner)
            brushed = contact_times(points[near[slow]], self._tight, linear, angular, passed_s) == np.inf
            shares[slow[brushed]] = crawl
            within = np.flatnonzero(times == 0.0)
            if len(within):
                shares[within] = self._within(points[near[within]], linear, angular, crawl)
        worst = int(np.argpartition(shares, rules.evidence - 1)[rules.evidence - 1])
        scale = float(shares[worst])
        if scale >= 1.0:
            return 1.0, None
        least = 2.0 if stands else 1.0
        if scale * abs(linear) < least * STANDING_MPS and scale * abs(angular) < least * STANDING_RADPS:
            scale = 0.0
        return scale, int(near[worst])

    def _share(self, times: Floats, linear: float, angular: float) -> Floats:
        """The greatest shares of the command with which contact, ``times`` (s) away at its full speed, can be avoided.

        With share k the body covers k·t_r while it reacts and k²/2b while it brakes, where b (1/s) is what it can take
        from k in a second with the arc kept.
        """
        limits, reaction = self._limits, self.rules.reaction_s
        braking = min(
            limits.linear_mps2 / abs(linear) if linear else math.inf,
            limits.angular_radps2 / abs(angular) if angular else math.inf,
        )
        stoppable = braking * (np.sqrt(reaction**2 + 2 * times / braking) - reaction)
        return np.minimum(1.0, np.minimum(stoppable, times / self.rules.contact_s))

    def _within(self, points: Points, linear: float, angular: float, crawl: float) -> Floats:
        """Shares for points that lie within the margin already."""
        beyond, edges = self._tight.beyond(points)
        # A point's velocity as the body sees it.
        velocity = -1j * angular * points - linear
        closing = -(self._tight.normals[edges].conj() * velocity).real
        share = closing / np.maximum(np.abs(velocity), 1e-9)
        times = contact_times(points, self._tight, linear, angular, self._horizon_s)
        outside = np.where(share > NEARED, np.minimum(crawl, self._share(times, linear, angular)), 1.0)
        touching = np.where(share > NEARED_IN_TOUCH, 0.0, 1.0)
        return np.where(beyond >= 0.0, outside, touching)

    def _words(self, point: complex, scale: float) -> str:
        distance = max(0.0, float(self._tight.beyond(np.array([point]))[0][0]))
        bearing = math.degrees(math.atan2(point.imag, point.real))
        if abs(bearing) <= 60:
            where = "ahead"
        elif abs(bearing) >= 120:
            where = "behind"
        else:
            where = "to the left" if bearing > 0 else "to the right"
        return f"{'slowed' if scale else 'stopped'}: something {distance:.1f} m {where}"


def _looks(first: float, last: float, bearing: float) -> bool:
    """Whether ``bearing`` (rad) lies between ``first`` and ``last``, a whole turn more or less."""
    if last - first >= 2 * math.pi - 0.05:
        return True
    return (bearing - first) % (2 * math.pi) <= last - first
