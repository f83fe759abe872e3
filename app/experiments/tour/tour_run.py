"""One run of a tour, on the kinematic body, with its two visitors."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from app.base.geometry import Pose2
from app.experiments.tour.observer import TourObserver
from app.experiments.tour.result import TourResult, farthest_m, left_behind_s, waits
from app.experiments.tour.visitors import REPLIES_S, start_of, two_visitors
from app.maps.grid_rays import GridRays
from app.maps.library import MapLibrary
from app.maps.places import pose_of
from app.messages import Place
from app.program.config import load_configuration
from app.rehearsal.play import RehearsalRun, Stage, play
from app.rehearsal.rehearse import LOOK_S, UNCONCERNED, begin_tour
from app.rehearsal.replies import VisitorReplies
from app.speech.text_spans import sentences_of
from app.tours.model import Tour
from app.tours.run_library import RunLibrary
from app.tours.tour_file import read_tour
from app.tours.values import text_in

#: A run that takes longer (s) is ended.
PATIENCE_S = 1200.0
#: Noise of the laser's distances (m).
NOISE_M = 0.02
#: Of the way, a pose a second is kept.
_KEPT = round(1.0 / LOOK_S)


@dataclass(frozen=True, slots=True)
class TourRun:
    """A plan: the ``tour`` (its file's text) with the program of ``config``, on its map in the folder ``maps``."""

    config: Path
    tour: str
    maps: Path
    seed: int


def work(spec: TourRun, give: Callable[[TourResult], None]) -> None:
    """Run ``spec``, and give its result. Raises ConfigError, and any programming error."""
    maps = MapLibrary(spec.maps)
    tour, _ = read_tour(spec.tour, "the tour")
    places = {place.id: place for place in maps.places(tour.map)}
    begin = places[tour.home if tour.home is not None else tour.stops[0].place]
    start = start_of(pose_of(begin), spec.seed)
    configuration = load_configuration(spec.config)
    with tempfile.TemporaryDirectory(prefix="hbba-tour-") as folder:
        stage = Stage(
            configuration,
            maps,
            tour.map,
            start,
            scenario=two_visitors(start, GridRays(maps.grid(tour.map)), spec.seed),
            runs=RunLibrary(Path(folder), resumes=False),
            without=tuple(name for name in UNCONCERNED if name in configuration.program.modules),
            noise_m=NOISE_M,
        )
        give(play(stage, lambda run: _led(run, tour, places, spec.seed)))


async def _led(run: RehearsalRun, tour: Tour, places: Mapping[str, Place], seed: int) -> TourResult:
    system, link = run.system, run.link
    language = tour.languages[0]
    rng = np.random.default_rng([seed, 3])
    began = time.perf_counter(), time.process_time()
    with (
        TourObserver(system, link, tour, places, Pose2()) as noted,
        VisitorReplies(system, link.let_pass, lambda: float(rng.uniform(*REPLIES_S))) as replies,
    ):
        await begin_tour(system, tour, language)
        while not noted.has_ended and noted.elapsed_s < PATIENCE_S:
            await system.clock.sleep(LOOK_S)
            noted.look()
            replies.look()
    progress, samples = noted.progress, noted.samples
    assert progress is not None
    outcome = progress.reason if noted.has_ended else f"it did not end within {PATIENCE_S / 60:.0f} min"
    presented = [stop for stop in tour.stops if stop.id in progress.presented]
    said = [text_in(step.say, language, language) for stop in presented for step in stop.do if step.say is not None]
    count, waited_s = waits(samples)
    restarted = [name for name, state in system.supervisor.states.items() if state.restarts]
    return TourResult(
        seed=seed,
        outcome=outcome,
        duration_s=round(noted.elapsed_s, 2),
        driven_m=round(link.base.driven_m, 2),
        stops=sum(not stop.left_out for stop in tour.stops),
        presented=len(presented),
        arrivals=tuple(noted.arrivals),
        texts=tuple(noted.texts),
        unsaid=tuple(each for text in said for each in _sentences(text) if each not in noted.sentences),
        pointed_deg=tuple(noted.pointed_deg),
        to_point=sum(step.point is not None for stop in presented for step in stop.do),
        wait_m=tour.pace.wait_m,
        left_behind_s=round(left_behind_s(samples, tour.pace.wait_m), 2),
        farthest_m=round(farthest_m(samples), 2),
        touched=link.base.touches,
        people_m=None if noted.people_m is None else round(noted.people_m, 3),
        cpu_share=round(noted.cpu_share, 4),
        asked=len(replies.asked),
        answered=noted.answered,
        waits=count,
        waited_s=round(waited_s, 2),
        failures=(
            *(f"{failure.stop}: {failure.what}" for failure in progress.failures),
            *(f"the module {name} failed" for name in restarted),
        ),
        wall_s=round(time.perf_counter() - began[0], 2),
        cpu_s=round(time.process_time() - began[1], 2),
        trace=tuple(samples[::_KEPT]),
    )


def _sentences(text: str) -> list[str]:
    return [text[begin:end] for begin, end in sentences_of(text)]
