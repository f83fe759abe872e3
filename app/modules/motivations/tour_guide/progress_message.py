"""What the guide publishes of a run: a pure function of it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from app.messages import ShownMedia, TourFailure, TourProgress, TourQuestion
from app.modules.motivations.tour_guide.controls import buttons, operator_question
from app.modules.motivations.tour_guide.entering import AT_A_STOP, ON_THE_WAY, subject_of
from app.modules.motivations.tour_guide.progress import Progress, View
from app.modules.motivations.tour_guide.wishes import Scene, step_now, steps_now, stop_of
from app.tours.steps import Step

#: Distances are published in steps of so much (m).
_STEP_M: Final = 0.5


def progress_message(progress: Progress, view: View, scene: Scene, *, run: str, waits: bool) -> TourProgress:
    """How ``run`` goes."""
    tour, subject = scene.tour, subject_of(progress)
    there = subject in ON_THE_WAY | AT_A_STOP
    stop = stop_of(progress, tour) if there else None
    step = step_now(progress, tour)
    kept = [number for number, each in enumerate(tour.stops) if not each.left_out]
    listens = progress.state == "listening"
    people = view.people + view.others
    question = stop.questions if stop is not None and progress.state in ("listening", "answering") else ()
    return TourProgress(
        view.now,
        run,
        tour.id,
        title=tour.title,
        language=scene.language,
        languages=tour.languages,
        waits=waits,
        state=progress.state,
        since=progress.since,
        reason=progress.reason,
        stop="" if stop is None else stop.id,
        stop_title={} if stop is None else stop.title,
        number=kept.index(progress.stop) + 1 if stop is not None and progress.stop in kept else 0,
        stops=len(kept),
        step=0 if step is None else progress.step + 1,
        steps=len(steps_now(progress, tour)),
        text=_text(progress, scene, step),
        sentence=progress.sentence,
        shown=_shown(progress, scene),
        press=step.wait.press or {} if listens and step is not None and step.wait is not None else {},
        questions=tuple(TourQuestion(each.id, each.question) for each in question),
        buttons=buttons(progress, e_stop=view.e_stop),
        question=operator_question(progress, scene),
        people=people,
        farthest_m=None if people == 0 else round(max(view.farthest_m, view.others_m) / _STEP_M) * _STEP_M,
        presented=progress.presented,
        skipped=tuple(tour.stops[number].id for number in progress.skipped),
        failures=tuple(TourFailure(failure.stop, failure.what) for failure in progress.failures),
    )


def _text(progress: Progress, scene: Scene, step: Step | None) -> Mapping[str, str]:
    confirm = scene.tour.greeting.confirm
    if progress.state == "confirming" and confirm is not None:
        return confirm.ask
    if progress.state == "listening" and progress.carried is not None:
        return {progress.carried.language: progress.carried.text}
    return {} if step is None or step.say is None else step.say


def _shown(progress: Progress, scene: Scene) -> ShownMedia | None:
    """A picture stays until the next, or the stop's end; an answer's is there while it is said."""
    steps = steps_now(progress, scene.tour)
    media = next((step.show for step in reversed(steps[: progress.step + 1]) if step.show is not None), None)
    if media is None and progress.state == "answering":
        said = stop_of(progress, scene.tour).do[: progress.listened + 1]
        media = next((step.show for step in reversed(said) if step.show is not None), None)
    return None if media is None else ShownMedia(media.file, media.alt, media.is_video)
