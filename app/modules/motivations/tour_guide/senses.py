"""What the guide sees, out of the messages that come in: placed at their own stamps, put together as a View."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable
from typing import Final

from app.base.geometry import Pose2, wrap_angle
from app.base.pose_buffer import PoseBuffer
from app.messages import (
    BatteryState,
    Exploitation,
    Faces,
    LinkStatus,
    Localization,
    NavigationStatus,
    Odometry,
    Persons,
    SoundSource,
    SoundSources,
)
from app.modules.motivations.tour_guide.progress import Event, Progress, View
from app.modules.motivations.tour_guide.visitors import Visitors
from app.tours.model import Tour

#: Percepts wait so long (s) for odometry to reach their stamp.
_PATIENCE_S: Final = 1.0
#: Greatest age (s) of the report of who drives.
_FRESH_S: Final = 0.5
#: A way is free again once it is so much (m) shorter, or nothing was in it for so long (s): before people who do not
#: move, navigation waits and tries by turns.
_FREE_M: Final = 0.5
#: A base turned this near (rad) to where it looks is turned there.
_TURNED_RAD: Final = 0.4
_FREE_S: Final = 6.0
_STUCK: Final = frozenset({"recovering", "waiting", "unreachable"})
_LOCALIZED: Final = frozenset({"mapping", "tracking"})


class Senses:
    """``by_hand``: the behavior that people drive by; ``voice``: a source at least this probably speech is a voice."""

    def __init__(self, *, by_hand: str, voice: float) -> None:
        self._by_hand = by_hand
        self._voice = voice
        self.visitors = Visitors()
        self._poses = PoseBuffer()
        self._X_OB: Pose2 | None = None
        self._percepts: deque[Faces | SoundSources] = deque(maxlen=32)
        self._localization: Localization | None = None
        self._exploitation: Exploitation | None = None
        self._e_stop = False
        self._battery: float | None = None
        self._docked = False
        self._stuck_since: float | None = None
        self._stuck_at = -math.inf
        #: The rest of the way (m), now and when it was stuck first.
        self._left_m: float | None = None
        self._stuck_m: float | None = None
        #: Since when (s) it has been turned to where it looks for visitors.
        self._looks_since: float | None = None

    def take_odometry(self, odometry: Odometry) -> None:
        """Where the base is."""
        self._poses.add(odometry.stamp, odometry.X_OB)
        self._X_OB = odometry.X_OB
        self.visitors.drive(odometry.X_OB)

    def take_percepts(self, percepts: Faces | SoundSources) -> None:
        """Who is seen or heard, placed once odometry has reached its stamp."""
        self._percepts.append(percepts)

    def take_persons(self, persons: Persons) -> None:
        """Who is there, also without a face."""
        self.visitors.bind(persons)

    def take_localization(self, localization: Localization) -> None:
        """Where the robot is on the map."""
        self._localization = localization

    def take_exploitation(self, exploitation: Exploitation) -> None:
        """Who drives."""
        self._exploitation = exploitation
        if exploitation.limited:
            self._stuck(exploitation.stamp)

    def take_status(self, status: LinkStatus) -> bool:
        """Whether the emergency stop is latched. Returns whether it has just been."""
        before, self._e_stop = self._e_stop, status.e_stopped
        return self._e_stop and not before

    def take_battery(self, battery: BatteryState) -> None:
        """What is left, and whether it charges."""
        self._battery, self._docked = battery.charge, battery.charging

    def take_navigation(self, status: NavigationStatus) -> None:
        """Whether the way to the goal is free."""
        self._left_m = status.remaining_m
        if status.state in _STUCK:
            self._stuck(status.stamp)
        elif (
            status.state in ("arrived", "idle")
            or status.stamp - self._stuck_at > _FREE_S
            or (self._left_m is not None and self._stuck_m is not None and self._left_m < self._stuck_m - _FREE_M)
        ):
            self._stuck_since = None

    def localized(self, map_name: str) -> bool:
        """Whether the robot knows where it is on the map ``map_name``."""
        known = self._localization
        return known is not None and known.state in _LOCALIZED and known.map == map_name

    def pose_on(self, map_name: str) -> tuple[float, float, float] | None:
        """The robot's x, y (m) and heading (rad) on the map ``map_name``; None where it is not known."""
        if self._localization is None or self._X_OB is None or not self.localized(map_name):
            return None
        at = self._localization.X_MO @ self._X_OB
        return at.x, at.y, at.theta

    def view(self, now: float, tour: Tour, progress: Progress, *, diverted: bool, events: Iterable[Event]) -> View:
        """All of it at ``now``; ``diverted``: others want the robot elsewhere."""
        self._place(now)
        state, company = progress.state, progress.company
        X_OB = self._X_OB or Pose2()
        seeks = state in ("waiting", "searching")
        people = self.visitors.around(
            now,
            X_OB,
            within_m=tour.begin.within_m,
            behind=state == "leading",
            sought_since=company.sought_since if seeks else None,
            legs_m=tour.pace.wait_m if seeks else 0.0,
        )
        self.visitors.returns = state == "searching"
        turned = progress.towards is None or abs(wrap_angle(X_OB.theta - progress.towards)) <= _TURNED_RAD
        if state != "waiting" or not turned:
            self._looks_since = None
        elif self._looks_since is None:
            self._looks_since = now
        exploited = self._exploitation
        driven = exploited is not None and now - exploited.stamp <= _FRESH_S and exploited.behavior == self._by_hand
        return View(
            now,
            people=people.people,
            farthest_m=people.farthest_m,
            nearest_m=people.nearest_m,
            near=people.near,
            speaking=people.speaking,
            driven_m=self.visitors.driven_m,
            towards=people.towards,
            stuck_since=self._stuck_since,
            found=people.found,
            found_m=people.found_m,
            others=people.others,
            others_m=people.others_m,
            others_nearest_m=people.others_nearest_m,
            behind=people.behind,
            looked_s=0.0 if self._looks_since is None else now - self._looks_since,
            back=self._on_map(self.visitors.back(company.seen_m), tour.map) if state == "waiting" else None,
            astray_m=self.visitors.astray_m,
            X_MB=self.pose_on(tour.map),
            battery=self._battery,
            docked=self._docked,
            e_stop=self._e_stop,
            by_hand=driven or diverted,
            localized=self.localized(tour.map),
            events=tuple(events),
        )

    def _on_map(self, place: tuple[float, float] | None, map_name: str) -> tuple[float, float] | None:
        """``place`` (m in odom) on the map ``map_name``."""
        if place is None or self._localization is None or not self.localized(map_name):
            return None
        at = self._localization.X_MO @ Pose2(*place)
        return round(at.x, 3), round(at.y, 3)

    def _stuck(self, stamp: float) -> None:
        if self._stuck_since is None or stamp - self._stuck_at > _FREE_S:
            self._stuck_since, self._stuck_m = stamp, self._left_m
        self._stuck_at = stamp

    def voices(self, sources: SoundSources) -> list[SoundSource]:
        """Those that sound and are a voice's."""
        return [each for each in sources.sources if each.active and each.speech >= self._voice]

    def _place(self, now: float) -> None:
        later = []
        for percepts in self._percepts:
            X_OB = self._poses.at(percepts.stamp)
            if X_OB is None:
                if now - percepts.stamp < _PATIENCE_S:
                    later.append(percepts)
            elif isinstance(percepts, Faces):
                placed = {face.track: X_OB @ Pose2(face.p_BF[0], face.p_BF[1]) for face in percepts.faces}
                self.visitors.see(percepts.stamp, {track: (at.x, at.y) for track, at in placed.items()})
            else:
                for voice in self.voices(percepts):
                    x, y, _ = voice.direction
                    self.visitors.hear(percepts.stamp, wrap_angle(X_OB.theta + math.atan2(y, x)))
        self._percepts.clear()
        self._percepts.extend(later)
