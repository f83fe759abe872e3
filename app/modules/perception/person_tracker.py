"""PersonTracker: persons, by all that is perceived of them (binding of percepts, thesis 2.1.2).

    ┌─────────────────────────────────────────────────────────────────────────────────────────────┐
    │ PersonTracker  in   faces         Faces, any rate; only where something has them looked for  │
    │                in   torsos        TorsoColors, likewise                                      │
    │                in   sources       SoundSources, likewise                                     │
    │                in   scans         LaserScan, 40 Hz / φ                                       │
    │                in   localization  Localization: where odom is on the map                     │
    │                in   map           OccupancyGrid: what is no leg, and no way                  │
    │                in   odometry      Odometry, 100 Hz, X_OB in odom; never filtered             │
    │                out  persons       Persons, 10 Hz                                             │
    └─────────────────────────────────────────────────────────────────────────────────────────────┘

Tracks, identities and bindings are pure (``people/``). Any of faces, voices and legs may be missing. Identities and the
colours of torsos are kept in memory alone, and while the program runs.
"""

from __future__ import annotations

from pydantic import Field

from app.attention.desires import DesireClass
from app.base.geometry import Pose2
from app.messages import (
    Faces,
    LaserScan,
    Localization,
    OccupancyGrid,
    Odometry,
    Persons,
    SoundSources,
    TorsoColors,
)
from app.modules.perception.people.legs import legs_seen
from app.modules.perception.people.motion import prepare
from app.modules.perception.people.observations import Walls, faces_seen, voices_heard
from app.modules.perception.people.person_tracks import PersonTracks
from app.modules.perception.people.values import LegsSeen
from app.modules.perception.pose_at import PoseAt
from app.runtime.module import Module, ModuleContext, Settings

#: Kept over restarts, so that no number is used again.
_NEXT = "next numbers"


class PersonTrackerSettings(Settings):
    """Settings of PersonTracker."""

    legs_m: float = Field(8.0, gt=0, le=30, description="range within which legs are looked for in the scan")
    period_s: float = Field(0.1, gt=0, le=5, description="time between two messages")


TRACK_PERSONS = DesireClass(
    name="TrackPersons",
    title="Track persons",
    description="Bind faces, voices and legs into persons, who keep their number while they are hidden for a while.",
)


class PersonTracker(Module):
    """Tracks persons."""

    title = "Person tracker"
    desire_classes = (TRACK_PERSONS,)
    auxiliary_inputs = frozenset({"faces", "torsos", "sources", "localization", "map"})
    Settings = PersonTrackerSettings
    settings: PersonTrackerSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._tracks = PersonTracks(*self.persistent.get(_NEXT, (1, 1)))
        self._poses = PoseAt(self.clock, self.log, "persons are not tracked", "the stamps of percepts")
        self._newest: Odometry | None = None
        self._grid: OccupancyGrid | None = None
        self._X_MO: Pose2 | None = None
        self.faces = self.input("faces", Faces, capacity=8, wants="if_wanted")
        self.torsos = self.input("torsos", TorsoColors, capacity=8, wants="if_wanted")
        self.sources = self.input("sources", SoundSources, capacity=8, wants="if_wanted")
        self.scans = self.input("scans", LaserScan)
        self.localization = self.input("localization", Localization, wants="if_wanted")
        self.map = self.input("map", OccupancyGrid, wants="if_wanted")
        self.odometry = self.input("odometry", Odometry, capacity=100, always_open=True)
        self.persons = self.output("persons", Persons)
        self.on(self.faces, self._see_faces)
        self.on(self.torsos, self._see_torsos)
        self.on(self.sources, self._hear)
        self.on(self.scans, self._see_legs)
        self.on(self.localization, self._localize)
        self.on(self.map, self._note_map)
        self.on(self.odometry, self._note_odometry)
        self.every(self.settings.period_s, self._report)

    async def start(self) -> None:
        """Load what assigns."""
        await self.compute(prepare)

    async def _see_faces(self, faces: Faces) -> None:
        X_OB = await self._poses.logged_at(faces.stamp)
        if X_OB is not None:
            self._tracks.see_faces(faces.stamp, faces_seen(faces, X_OB))

    def _see_torsos(self, torsos: TorsoColors) -> None:
        below = len(torsos.tracks)
        self._tracks.see_torsos(torsos.stamp, dict(zip(torsos.tracks, torsos.histograms[:below], strict=True)))
        self._tracks.see_worn(torsos.stamp, dict(zip(torsos.persons, torsos.histograms[below:], strict=True)))

    async def _hear(self, sources: SoundSources) -> None:
        X_OB = await self._poses.logged_at(sources.stamp) if sources.sources else None
        if X_OB is not None:
            self._tracks.hear(sources.stamp, *voices_heard(sources, X_OB))

    async def _see_legs(self, scan: LaserScan) -> None:
        X_OB = await self._poses.logged_at(scan.stamp)
        if X_OB is not None:
            self._tracks.see_legs(scan.stamp, await self.compute(self._legs, scan, X_OB, self._grid, self._X_MO))

    def _legs(self, scan: LaserScan, X_OB: Pose2, grid: OccupancyGrid | None, X_MO: Pose2 | None) -> list[LegsSeen]:
        return legs_seen(scan, X_OB, self.settings.legs_m, grid, X_MO)

    def _localize(self, localization: Localization) -> None:
        self._X_MO = localization.X_MO
        self._know_walls()

    def _note_map(self, grid: OccupancyGrid) -> None:
        self._grid = grid
        self._know_walls()

    def _know_walls(self) -> None:
        if self._grid is not None and self._X_MO is not None:
            self._tracks.passable = Walls(self._grid, self._X_MO).passable

    def _note_odometry(self, odometry: Odometry) -> None:
        self._poses.add(odometry)
        self._newest = odometry

    def _report(self) -> None:
        if self._newest is None or not self.persons.wanted:
            return
        # At the time of the newest pose, for which a follower of a person has one.
        stamp = self._newest.stamp
        persons = self._tracks.persons(stamp)
        self.persistent[_NEXT] = (self._tracks.next_track, self._tracks.next_person)
        self.persons.publish(Persons(stamp, persons))
