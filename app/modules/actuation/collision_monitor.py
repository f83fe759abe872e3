"""The collision monitor: limits a commanded twist by the newest laser scan.

Its input is the command alone, no plan. The time to contact of the footprint, with the arms as they are stretched out
(``app.base.moving_shapes``), grown by a margin, with the scan's points along the commanded arc is computed exactly
(``swept_footprint``). The command is scaled with its arc kept until

- the body can stop before contact, with its true deceleration and after the reaction time of the whole chain;
- the time to contact is at least ``contact_s``.

Points that only the margin touches limit the speed to a crawl. Points already within the margin are approached at a
crawl, up to the footprint itself. Motion away from a point is never limited, so that the body can leave a tight place.
Where the arc is stopped, its rotation alone is tried. Outside the laser's field of view, as backwards, the body crawls.
Velocities are complex, forward + i left (m/s), so that a holonomic base needs no other rule.

The rule of slowing to keep a time to contact is Nav2's *approach* (collision monitor of the ROS 2 Navigation stack);
the braking rule is that of the Dynamic Window Approach (Fox, Burgard, Thrun 1997).
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np
from pydantic import BaseModel, Field

from app.base.geometry import Pose2
from app.link import BaseLimits
from app.messages import LaserScan
from app.modules.actuation.swept_footprint import Floats, Points, Polygon, contact_times, may_decide

#: Below these speeds (m/s, rad/s) the body counts as standing, and a command scaled below them is a stop. A standing
#: body starts again only for twice as much: hysteresis against the laser's noise.
STANDING_MPS, STANDING_RADPS = 0.03, 0.08
#: A point approaches if its closing speed exceeds this share of its own speed relative to the body: a point beside a
#: round body, drawn as a polygon, may graze its edges while the body turns.
NEARED, NEARED_IN_TOUCH = 0.02, 0.25
#: Half the angle (rad) that the laser must see around a direction off the body's axis.
LANE_RAD = 0.75


class MonitorRules(BaseModel, frozen=True, extra="forbid"):
    """Parameters of the collision monitor."""

    margin_m: float = Field(0.05, ge=0, le=0.5, description="kept clear around the body's footprint")
    contact_s: float = Field(1.0, ge=0.1, le=5, description="the least time to contact, at the speed driven")
    reaction_s: float = Field(0.15, ge=0, le=1, description="from a ray of the laser to wheels that obey")
    #: Also how far a scan's stamp may be ahead of the clock.
    stale_s: float = Field(0.3, gt=0, le=1, description="without a younger scan nothing drives")
    crawl_mps: float = Field(0.1, gt=0, le=0.2, description="allowed where the laser does not see, and by override")
    crawl_radps: float = Field(0.3, gt=0, le=0.5, description="allowed likewise")
    evidence: int = Field(2, ge=1, le=10, description="so many points make a thing; one alone may be noise")


@dataclass(frozen=True, slots=True)
class Verdict:
    """The allowed velocity (m/s, forward + i left; rad/s), and the reason where it differs from the commanded one
    (else "")."""

    velocity: complex
    angular: float
    reason: str = ""

    @property
    def linear(self) -> float:
        """Forward, m/s."""
        return self.velocity.real

    @property
    def lateral(self) -> float:
        """To the left, m/s."""
        return self.velocity.imag


@dataclass(frozen=True, slots=True, eq=False)
class SeenPoints:
    """Points of one scan near the robot: ``points`` (N,), x + iy m in ``base_link`` at ``stamp`` (s), the middle of the
    sweep. ``field``: first and last bearing (rad) of the laser's field of view in ``base_link``. ``dead``: no ray
    returned a range, not even "free"."""

    stamp: float
    points: Points
    field: tuple[float, float]
    dead: bool

    def covers(self, velocity: complex) -> bool:
        """Whether the laser looks where ``velocity`` leads: along the body's axis, or to both sides of a direction off
        it, where parts of the body move that the axis does not pass."""
        bearing = cmath.phase(velocity)
        if velocity.imag == 0.0:
            return _looks(*self.field, bearing)
        return _looks(*self.field, bearing - LANE_RAD) and _looks(*self.field, bearing + LANE_RAD)


class CollisionMonitor:
    """Limits commands for one body, of the outline that it was given last: a pure function of its arguments, with a
    cached table of the scan's angles."""

    def __init__(self, corners: tuple[tuple[float, float], ...], limits: BaseLimits, rules: MonitorRules) -> None:
        """``corners`` as ``RobotDescription.footprint``. Raises ValueError for an invalid footprint."""
        self.rules = rules
        self._limits = limits
        self._fastest_mps = max(limits.linear_mps, limits.lateral_mps)
        slowest_stop = max(self._fastest_mps / limits.linear_mps2, limits.angular_radps / limits.angular_radps2)
        self._horizon_s = max(rules.contact_s, rules.reaction_s + slowest_stop / 2)
        self.outline(corners)
        self._angles: tuple[int, float, float] | None = None
        self._cosines = self._sines = np.empty(0)

    def outline(self, corners: tuple[tuple[float, float], ...]) -> None:
        """Take ``corners`` for the footprint from now on. Points that were seen before may not reach as far: see the
        scan again. Raises ValueError for an invalid footprint."""
        self._tight = Polygon.of(corners)
        self._grown = Polygon.of(corners, self.rules.margin_m)
        #: Greatest distance (m) from the base of a point that can matter, at the greatest age of a scan.
        self.reach_m = self._grown.outer + self._fastest_mps * (self._horizon_s + self.rules.stale_s)

    def see(self, scan: LaserScan) -> SeenPoints:
        """The points of ``scan`` within the distance that can matter."""
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
        return SeenPoints(middle, points, (first + yaw, last + yaw), not measured.any())

    def judge(
        self, seen: SeenPoints, X_SB: Pose2, velocity: complex, angular: float, *, standing: bool = False
    ) -> Verdict:
        """The allowed part of ``velocity`` (m/s, forward + i left) and ``angular`` (rad/s). ``X_SB``: motion of the
        base since ``seen``; ``standing``: whether it does not move now."""
        if velocity == 0.0 and angular == 0.0:
            return Verdict(0.0, 0.0)
        if seen.dead:
            return Verdict(0.0, 0.0, "stopped: no ray of the laser measures anything: is it covered?")
        turned = complex(math.cos(X_SB.theta), -math.sin(X_SB.theta))
        points = (seen.points - complex(X_SB.x, X_SB.y)) * turned
        scale, where = self._scale(points, velocity, angular, standing)
        reason = "" if where is None else self._explanation(complex(points[where]), scale)
        crawl = self._crawl(velocity, angular)
        if velocity != 0.0 and crawl < scale and not seen.covers(velocity):
            scale, reason = crawl, f"slowed: the laser does not see {_side(velocity)}"
        if scale == 0.0 and velocity != 0.0 and angular != 0.0:
            turn, _ = self._scale(points, 0.0, angular, standing)
            if turn > 0.0:
                return Verdict(0.0, turn * angular, f"{reason}; it turns")
        return Verdict(scale * velocity, scale * angular, reason)

    def blind(self, age_s: float | None) -> Verdict:
        """The allowed velocity without a usable scan: the newest is ``age_s`` old (None: there is no scan)."""
        if age_s is None:
            why = "the laser has given no scan yet"
        elif age_s > 0.0:
            why = "the laser gives no new scans"
        else:
            why = "the laser's stamps are not of the robot's clock"
        return Verdict(0.0, 0.0, f"stopped: {why}")

    def crawl(self, velocity: complex, angular: float) -> Verdict:
        """The allowed velocity under the operator's override, whatever the scan shows."""
        scale = self._crawl(velocity, angular)
        return Verdict(scale * velocity, scale * angular, "override: it crawls, whatever is in the way")

    def _crawl(self, velocity: complex, angular: float) -> float:
        return min(
            1.0,
            self.rules.crawl_mps / abs(velocity) if velocity else 1.0,
            self.rules.crawl_radps / abs(angular) if angular else 1.0,
        )

    def _scale(self, points: Points, velocity: complex, angular: float, standing: bool) -> tuple[float, int | None]:
        """The allowed share of the command, in [0, 1], and the point that limits it."""
        rules, horizon = self.rules, self._horizon_s
        near = may_decide(
            points,
            self._tight,
            grown=self._grown,
            velocity=velocity,
            angular=angular,
            horizon_s=horizon,
            evidence=rules.evidence,
        )
        if len(near) < rules.evidence:
            return 1.0, None
        times = contact_times(points[near], self._grown, velocity, angular, horizon)
        met = times < np.inf
        near, times = near[met], times[met]
        if len(near) < rules.evidence:
            return 1.0, None
        shares = self._share(times, velocity, angular)
        crawl = self._crawl(velocity, angular)
        slow = np.flatnonzero(shares < crawl)
        if len(slow):
            # Below a crawl only for contact with the footprint itself; the margin alone permits a crawl.
            passed_s = horizon + 2 * self._grown.outer / max(abs(velocity), abs(angular) * self._tight.inner)
            brushed = contact_times(points[near[slow]], self._tight, velocity, angular, passed_s) == np.inf
            shares[slow[brushed]] = crawl
            within = np.flatnonzero(times == 0.0)
            if len(within):
                shares[within] = self._within(points[near[within]], velocity, angular, crawl)
        worst = int(np.argpartition(shares, rules.evidence - 1)[rules.evidence - 1])
        scale = float(shares[worst])
        if scale >= 1.0:
            return 1.0, None
        least = 2.0 if standing else 1.0
        if scale * abs(velocity) < least * STANDING_MPS and scale * abs(angular) < least * STANDING_RADPS:
            scale = 0.0
        return scale, int(near[worst])

    def _share(self, times: Floats, velocity: complex, angular: float) -> Floats:
        """The greatest shares of the command that avoid contact, which is ``times`` (s) away at full speed.

        With share k the body covers k·t_r while it reacts and k²/2b while it brakes, where b (1/s) is the decrease of k
        per second with the arc kept.
        """
        limits, reaction = self._limits, self.rules.reaction_s
        braking = min(
            limits.linear_mps2 / abs(velocity) if velocity else math.inf,
            limits.angular_radps2 / abs(angular) if angular else math.inf,
        )
        stoppable = braking * (np.sqrt(reaction**2 + 2 * times / braking) - reaction)
        return np.minimum(1.0, np.minimum(stoppable, times / self.rules.contact_s))

    def _within(self, points: Points, velocity: complex, angular: float, crawl: float) -> Floats:
        """Shares for points that are within the margin already."""
        beyond, edges = self._tight.beyond(points)
        # Velocity of a point relative to the body.
        relative = -1j * angular * points - velocity
        closing = -(self._tight.normals[edges].conj() * relative).real
        share = closing / np.maximum(np.abs(relative), 1e-9)
        times = contact_times(points, self._tight, velocity, angular, self._horizon_s)
        outside = np.where(share > NEARED, np.minimum(crawl, self._share(times, velocity, angular)), 1.0)
        touching = np.where(share > NEARED_IN_TOUCH, 0.0, 1.0)
        return np.where(beyond >= 0.0, outside, touching)

    def _explanation(self, point: complex, scale: float) -> str:
        distance = max(0.0, float(self._tight.beyond(np.array([point]))[0][0]))
        return f"{'slowed' if scale else 'stopped'}: something {distance:.1f} m {_side(point)}"


def _side(direction: complex) -> str:
    bearing = math.degrees(cmath.phase(direction))
    if abs(bearing) <= 60:
        return "ahead"
    if abs(bearing) >= 120:
        return "behind"
    return "to the left" if bearing > 0 else "to the right"


def _looks(first: float, last: float, bearing: float) -> bool:
    """Whether ``bearing`` (rad, modulo 2π) is between ``first`` and ``last``."""
    if last - first >= 2 * math.pi - 0.05:
        return True
    return (bearing - first) % (2 * math.pi) <= last - first
