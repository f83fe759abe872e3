"""Going on with a run that was under way when the program ended: with the map in use, the robot localized, and visitors
looked for."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

from app.base.geometry import Pose2
from app.maps.map_service import MapService, MapUnavailable
from app.modules.motivations.tour_guide.kept import KeptRun, after_restart
from app.modules.motivations.tour_guide.perceptions import FACES, PERSONS, SLAM
from app.modules.motivations.tour_guide.progress import Progress, View
from app.modules.motivations.tour_guide.transitions import interrupted
from app.modules.motivations.tour_guide.wishes import Scene, Wish
from app.tours.model import Tour

#: It waits so long (s) for map and pose, and then for visitors.
_READY_S, _VISITORS_S = 60.0, 10.0
_PERCEPTIONS: Final = (Wish("slam", SLAM), Wish("faces", FACES), Wish("persons", PERSONS))


class Resumption:
    """``kept`` is the run, of ``tour``. Times are Unix times (s)."""

    def __init__(self, kept: KeptRun, tour: Tour) -> None:
        self.kept = kept
        self.tour = tour
        #: Time until which it waits at most.
        self._until = math.inf
        self._map_taken, self._map_refused = False, ""

    async def take_map(self, maps: MapService, now: float) -> None:
        """Take the map of a run that is gone on with into use, with the robot about where it was."""
        kept, tour = self.kept, self.tour
        if not kept.progress.is_running or self._map_taken or not maps.available or not kept.is_fresh(now):
            return
        self._map_taken = True
        if maps.server.name == tour.map:
            return
        try:
            await maps.server.load(tour.map, None if kept.pose is None else Pose2(*kept.pose))
        except MapUnavailable as refusal:
            self._map_refused = f"the map {tour.map} cannot be taken into use: {refusal}"

    def interrupt(self, view: View, scene: Scene) -> bool:
        """Pause the run where the emergency stop is latched. Returns whether it has just been: released again before
        the run goes on, it is a pause all the same."""
        if not (self.kept.progress.is_running and view.e_stop) or self._held:
            return False
        self.kept = replace(self.kept, progress=interrupted(self.kept.progress, view, scene))
        return True

    def wishes(self, now: float) -> tuple[Wish, ...]:
        """What is to be perceived before the run goes on; nothing once it has waited long enough at ``now``."""
        self._until = min(self._until, now + _READY_S)
        return _PERCEPTIONS if self.kept.progress.is_running and now < self._until else ()

    def waits(self, now: float, view: View, *, localized: bool) -> bool:
        """Whether the run waits still, for pose and places (``localized``) and then for visitors; asked for while
        there are :meth:`wishes`."""
        if self._held:
            return False
        if not localized:
            return True
        self._until = min(self._until, now + _VISITORS_S)
        return view.there == 0

    def progress(self, now: float, view: View, scene: Scene, *, localized: bool) -> Progress:
        """How the run goes on, or why it does not."""
        if self.kept.progress.is_running and not (localized or self._held):
            unknown = f"the robot does not know where it is on the map {self.tour.map}"
            return Progress(reason=self._map_refused or unknown)
        return after_restart(self.kept, now, view, scene)

    @property
    def _held(self) -> bool:
        """Whether it is paused until a press, which needs neither pose nor visitors."""
        return self.kept.progress.state == "paused" and self.kept.progress.to_press
