"""A tour rehearsed: the real guide, planner and attention on a kinematic body on the saved map, with visitors."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from app.base import compiled
from app.base.errors import ConfigError
from app.base.geometry import Pose2
from app.base.yaml_source import KeyPath
from app.maps.grid_rays import GridRays
from app.maps.library import MapLibrary
from app.maps.map_service import MapUnavailable
from app.maps.places import pose_of
from app.messages import Place
from app.program.config import Configuration
from app.program.system import System
from app.rehearsal.observer import RehearsalObserver
from app.rehearsal.play import RehearsalRun, Stage, play
from app.rehearsal.replies import VisitorReplies
from app.rehearsal.result import Rehearsal, RehearsalProblem
from app.rehearsal.visitors import visitors
from app.tours.consistency import steps_of
from app.tours.model import Tour
from app.tours.run_library import RunLibrary
from app.tours.run_service import TourRefused

LOOK_S = 0.25
#: A rehearsal that takes longer (s) does not end by itself.
LONGEST_S = 7200.0
#: The guide is there so long (s) after the begin at most.
READY_S = 30.0
#: Progress is said so often (s).
REPORT_S = 10.0
#: Modules whose desires have nothing to do with the tour.
UNCONCERNED = ("ScenarioCoordinator",)


@dataclass(frozen=True, slots=True)
class RehearsalRequest:
    """What is rehearsed: ``tour`` in ``language``, led by the program ``configuration`` on a map of ``maps``, with so
    many ``people``, each of whom follows as the ``seed`` says."""

    tour: Tour
    configuration: Configuration
    maps: MapLibrary
    language: str
    people: int = 2
    seed: int = 1


def rehearse(request: RehearsalRequest, progress: Callable[[float, str], None] = lambda _, __: None) -> Rehearsal:
    """Rehearse, in virtual time; not on an event loop. ``progress(seconds, stop)`` is called as it goes.

    Raises ConfigError for a program or a map that cannot be used, and where no place of the tour is on the map.
    """
    tour, maps = request.tour, request.maps
    try:
        places = {place.id: place for place in maps.places(tour.map)}
        grid = maps.grid(tour.map)
    except (MapUnavailable, ValueError) as refusal:
        raise ConfigError(f"map: {refusal}") from None
    start = _start(tour, places)
    stage = Stage(
        request.configuration,
        maps,
        tour.map,
        start,
        scenario=visitors(request.people, start, GridRays(grid), request.seed),
        without=tuple(name for name in UNCONCERNED if name in request.configuration.program.modules),
    )
    compiled.make_ready()
    with tempfile.TemporaryDirectory(prefix="hbba-rehearsal-") as folder:
        staged = replace(stage, runs=RunLibrary(Path(folder), resumes=False))
        found = play(staged, lambda run: _Conductor(run, request, progress).lead())
    first = (*_unsaid(tour, request.language), *_stood(tour, places, found.stood))
    return replace(found.rehearsal, problems=(*first, *found.rehearsal.problems))


@dataclass(frozen=True, slots=True)
class _Found:
    """What was noted; ``stood``: where the robot stood at each stop."""

    rehearsal: Rehearsal
    stood: Mapping[str, Pose2]


class _Conductor:
    """Begins the tour, and has visitors reply, until it ends."""

    def __init__(self, run: RehearsalRun, request: RehearsalRequest, progress: Callable[[float, str], None]) -> None:
        self._run = run
        self._request = request
        self._progress = progress
        self._reported_s = -math.inf

    async def lead(self) -> _Found:
        """Lead the tour to its end, or to the end of patience."""
        request, clock = self._request, self._run.system.clock
        with (
            RehearsalObserver(self._run, request.tour.pace.wait_m) as noted,
            VisitorReplies(self._run.system, self._run.link.let_pass) as replies,
        ):
            await begin_tour(self._run.system, request.tour, request.language)
            while not noted.has_ended and noted.elapsed_s < LONGEST_S:
                await clock.sleep(LOOK_S)
                noted.look()
                replies.look()
                self._report(noted)
        last = noted.states[-1]
        outcome = last.reason if noted.has_ended else f"it did not end within {LONGEST_S / 60:.0f} min"
        problems = [*noted.problems, *self._failed_modules()]
        if not noted.has_ended:
            problems.append(RehearsalProblem("error", last.stop, outcome, round(noted.elapsed_s, 2)))
        rehearsal = Rehearsal(
            request.tour.id,
            request.language,
            outcome=outcome,
            duration_s=round(noted.elapsed_s, 2),
            driven_m=round(self._run.link.base.driven_m, 2),
            stops=() if noted.progress is None else noted.progress.presented,
            states=tuple(noted.states),
            subtitles=tuple(noted.subtitles),
            path=tuple(noted.path),
            problems=tuple(problems),
        )
        return _Found(rehearsal, noted.stood)

    def _report(self, noted: RehearsalObserver) -> None:
        if noted.elapsed_s - self._reported_s >= REPORT_S:
            self._reported_s = noted.elapsed_s
            self._progress(noted.elapsed_s, noted.states[-1].stop if noted.states else "")

    def _failed_modules(self) -> Iterator[RehearsalProblem]:
        for name, state in self._run.system.supervisor.states.items():
            if state.restarts:
                yield RehearsalProblem("error", "", f"the module {name} failed: {state.problem or 'it was restarted'}")


async def begin_tour(system: System, tour: Tour, language: str) -> None:
    """Start ``tour`` as soon as the guide can. Raises ConfigError with its refusal where it cannot."""
    until = system.clock.now() + READY_S
    while True:
        try:
            system.tour_run.server.start_tour(tour, language=language, waits=False)
        except TourRefused as refusal:
            if system.clock.now() >= until:
                raise ConfigError(str(refusal)) from None
            await system.clock.sleep(LOOK_S)
        else:
            return


def _unsaid(tour: Tour, language: str) -> Iterator[RehearsalProblem]:
    """What is said in another language than the visitors'."""
    for path, step in steps_of(tour):
        if step.say is not None and language not in step.say:
            stop = tour.stops[int(path[1])].id if path[0] == "stops" else ""
            said = tour.languages[0] if tour.languages[0] in step.say else next(iter(step.say))
            text = f"{_named(path)} has no text in {language}: that in {said} is said"
            yield RehearsalProblem("warning", stop, text)


def _named(path: KeyPath) -> str:
    """The step at ``path``, within its stop, as people count."""
    match path:
        case (*_, "questions", int(index), "answer"):
            return f"the answer to question {index + 1}"
        case ("greeting" | "farewell" as part, "do", int(index)):
            return f"step {index + 1} of the {part}"
    return f"step {int(path[-1]) + 1}"


def _stood(tour: Tour, places: Mapping[str, Place], stood: Mapping[str, Pose2]) -> Iterator[RehearsalProblem]:
    """Where the robot stood farther from a place than the stop allows."""
    for stop in tour.stops:
        place, pose = places.get(stop.place), stood.get(stop.id)
        if place is None or pose is None:
            continue
        off_m = math.hypot(pose.x - place.x, pose.y - place.y)
        if off_m > stop.stand.tolerance_m:
            text = f"the robot stands {off_m:.2f} m from {place.name}, and {stop.stand.tolerance_m:g} m are allowed"
            yield RehearsalProblem("warning", stop.id, text)


def _start(tour: Tour, places: Mapping[str, Place]) -> Pose2:
    """Where it begins: at home, or at the first stop. Raises ConfigError where neither is on the map."""
    for place in (tour.home, *(stop.place for stop in tour.stops if not stop.left_out)):
        if place is not None and place in places:
            return pose_of(places[place])
    raise ConfigError(f"none of the places of the tour {tour.id} is on the map {tour.map}")
