"""What the guide desires in each state. Pure functions: the module adds and removes desires until these hold."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from app.maps.poster_places import Poster, poster_named
from app.modules.motivations.tour_guide.company import DIRECTIONS
from app.modules.motivations.tour_guide.progress import Progress
from app.speech.text_spans import sentences_of
from app.tours.desires import LOOK_AT, SAY, desires_of
from app.tours.model import Stop, Tour
from app.tours.steps import Step
from app.tours.values import text_in

GO_TO: Final = "GoTo"
TRACK_FACE: Final = "TrackFace"
ROTATE: Final = "RotateToHeading"
DOCK: Final = "Dock"

#: Visitors are asked whether to show them round, and once more after so many seconds.
ASKS_S: Final = (0.0, 10.0)
#: Visitors who wait are called after so many seconds.
CALLS_S: Final = (10.0, 30.0)
#: People in its way are asked to let it pass after so many seconds without progress.
PASSES_S: Final = (8.0, 20.0)
#: Looking for visitors, the head looks where the base is turned, at faces some metres away.
AHEAD: Final[Mapping[str, Any]] = {"x": 3.0, "y": 0.0, "z": 1.5, "frame": "base_link"}
#: Driving back for visitors, it is there this near (m).
BACK_M: Final = 0.5
#: Share of the tour's speed while visitors are farther behind than ``slow_m``, and while it drives back for them.
SLOWLY: Final = 0.5

CALL: Final = {"en": "I am waiting for you.", "fr": "Je vous attends."}
PASS: Final = {"en": "Excuse me, may I pass?", "fr": "Excusez-moi, puis-je passer ?"}
STILL: Final = {"en": "Are you still with me?", "fr": "Êtes-vous toujours avec moi ?"}
SEEK: Final = {"en": "I am coming back for you.", "fr": "Je reviens vous chercher."}
#: By key: what it says of a pause, of going on otherwise than visitors expect, and of an end that they do not expect.
EXCUSES: Final[Mapping[str, Mapping[str, str]]] = {
    "paused": {"en": "One moment, please.", "fr": "Un instant, s'il vous plaît."},
    "without": {"en": "I go on with those who are here.", "fr": "Je continue avec ceux qui sont là."},
    "again": {"en": "I was interrupted. Let us go on.", "fr": "J'ai été interrompu. Reprenons."},
    "skipped": {"en": "I cannot get there, so I leave it out.", "fr": "Je ne peux pas y aller, je passe cette étape."},
    "from_here": {
        "en": "I cannot get any nearer, so I explain it from here.",
        "fr": "Je ne peux pas m'approcher davantage, je vous l'explique d'ici.",
    },
    "poster": {
        "en": "Excuse me, the poster is not where I knew it.",
        "fr": "Excusez-moi, l'affiche n'est pas là où je la connaissais.",
    },
    "e_stop": {"en": "I was stopped. One moment, please.", "fr": "On m'a arrêté. Un instant, s'il vous plaît."},
    "battery": {
        "en": "My battery is low. I must end the tour here.",
        "fr": "Ma batterie est faible. Je dois terminer la visite ici.",
    },
    "interrupted": {
        "en": "I was interrupted, and must end the tour here.",
        "fr": "J'ai été interrompu et dois terminer la visite ici.",
    },
    "lost": {
        "en": "I do not know where I am. I must end the tour here.",
        "fr": "Je ne sais pas où je suis. Je dois terminer la visite ici.",
    },
    "unreachable": {
        "en": "I cannot get any further. I must end the tour here.",
        "fr": "Je ne peux pas aller plus loin. Je dois terminer la visite ici.",
    },
}
#: Names of wishes that say something beside a step: none of them fails it.
BESIDE: Final = ("excuse", "code")
LOST: Final = {"en": "I do not know where I am. One moment.", "fr": "Je ne sais pas où je suis. Un instant."}


@dataclass(frozen=True, slots=True)
class Wish:
    """A desire of the class ``cls``; ``key`` identifies it among the wishes of one run."""

    key: str
    cls: str
    params: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Scene:
    """What a run needs beside its tour: ``places``, parameters of GoTo by the place's id; ``language`` of the visitors;
    ``achievements``, the desire classes that end by themselves. ``doubts``: what is doubtful about places, in words, by
    their ids; ``docks``: whether the robot charges at home; ``posters``: those that the map knows."""

    tour: Tour
    language: str
    places: Mapping[str, Mapping[str, Any]]
    achievements: frozenset[str]
    doubts: Mapping[str, str] = field(default_factory=dict)
    docks: bool = False
    posters: tuple[Poster, ...] = ()


def stop_of(progress: Progress, tour: Tour) -> Stop:
    """The stop that ``progress`` is about."""
    return tour.stops[progress.stop]


def goal_of(stop: Stop, scene: Scene) -> dict[str, Any]:
    """Parameters of GoTo for ``stop``: its place, turned to its poster where it stands so and the map knows that."""
    goal = dict(scene.places[stop.place])
    if stop.stand.face != "poster" or stop.poster is None:
        return goal
    poster = poster_named(scene.posters, stop.poster, near=(goal["x"], goal["y"]))
    if poster is None:
        return goal
    # In steps, so that a map that is corrected makes no new goal.
    return goal | {"heading": round(math.atan2(poster.y - goal["y"], poster.x - goal["x"]), 2)}


def steps_now(progress: Progress, tour: Tour) -> tuple[Step, ...]:
    """The steps that follow one another in this state; none in states without."""
    match progress.state:
        case "inviting":
            return tour.greeting.do
        case "presenting" | "listening":
            return stop_of(progress, tour).do
        case "answering":
            return (stop_of(progress, tour).questions[progress.question].answer,)
        case "parting":
            return tour.farewell.do
    return ()


def step_now(progress: Progress, tour: Tour) -> Step | None:
    """The step that is under way; None between steps and in states without."""
    steps = steps_now(progress, tour)
    return steps[progress.step] if progress.step < len(steps) else None


def wishes(progress: Progress, scene: Scene, now: float) -> tuple[Wish, ...]:
    """All desires of the guide at ``now``. One to go somewhere is among them only while it leads, drives back
    for visitors, or goes home."""
    return tuple(_wishes(progress, scene, now))


def awaited(progress: Progress, scene: Scene, now: float) -> frozenset[str]:
    """Keys of the wishes that this step waits for."""
    if step_now(progress, scene.tour) is None and not _says_first(progress):
        return frozenset()
    return frozenset(wish.key for wish in wishes(progress, scene, now) if wish.cls in scene.achievements)


def key(progress: Progress, name: str) -> str:
    """The key of the wish ``name`` of this state or step."""
    return f"{progress.entry}.{name}"


def _wishes(progress: Progress, scene: Scene, now: float) -> Iterator[Wish]:
    tour = scene.tour
    if progress.homed and scene.docks and progress.state in ("idle", "inviting", "confirming"):
        # It leaves the dock when it leads, not when it greets.
        yield Wish("dock", DOCK)
    match progress.state:
        case "leading":
            stop = stop_of(progress, tour)
            yield _going(progress, scene, stop.place, stop)
            yield from _asking_to_pass(progress, scene, now)
            if progress.excuse:
                yield _said(progress, f"excuse-{progress.excuse}", EXCUSES[progress.excuse], scene)
        case "searching" if progress.back is not None:
            x, y = progress.back
            speed = round(tour.pace.speed * SLOWLY, 3)
            yield Wish(key(progress, "go"), GO_TO, {"x": x, "y": y, "tolerance_m": BACK_M, "speed": speed})
            yield Wish(key(progress, "ahead"), LOOK_AT, AHEAD)
            yield _said(progress, "seek", SEEK, scene)
            yield from _asking_to_pass(progress, scene, now)
        case "paused" if progress.excuse:
            yield _said(progress, f"excuse-{progress.excuse}", EXCUSES[progress.excuse], scene)
        case "going_home":
            if tour.home is not None:
                yield _going(progress, scene, tour.home)
                if progress.excuse:
                    yield _said(progress, f"excuse-{progress.excuse}", EXCUSES[progress.excuse], scene)
                yield from _asking_to_pass(progress, scene, now)
        case "waiting" | "turning":
            # The camera that sees farthest turns with the head, which a near face would keep.
            looks_for = progress.state == "waiting" and progress.company.short
            yield Wish(key(progress, "ahead"), LOOK_AT, AHEAD) if looks_for else Wish(key(progress, "look"), TRACK_FACE)
            yield from _facing(progress)
            if progress.state == "waiting" and (looks := progress.company.last_look) is not None:
                # Once more to the other side, where the voice is turned to.
                yield _said(progress, f"still-{1 + (looks >= DIRECTIONS // 2)}", STILL, scene)
            elif progress.state == "waiting":
                calls = [after for after in CALLS_S if now - progress.since >= after]
                if calls:
                    yield _said(progress, f"call-{len(calls)}", CALL, scene)
        case "listening":
            yield from _facing_at_stop(progress, tour)
            if progress.excuse:
                yield _said(progress, f"excuse-{progress.excuse}", EXCUSES[progress.excuse], scene)
            yield from _carried(progress, scene)
        case "confirming":
            yield Wish(key(progress, "look"), TRACK_FACE)
            yield from _facing(progress)
            if tour.greeting.confirm is not None:
                asked = sum(now - progress.since >= after for after in ASKS_S)
                yield _said(progress, f"ask-{asked}", tour.greeting.confirm.ask, scene)
        case "blocked":
            yield _said(progress, "pass", PASS, scene)
        case "lost":
            yield _said(progress, "lost", LOST, scene)
        case "inviting" | "presenting" | "answering" | "parting":
            if progress.excuse and _says_first(progress):
                yield _said(progress, f"excuse-{progress.excuse}", EXCUSES[progress.excuse], scene)
            if progress.state == "presenting":
                yield from _carried(progress, scene)
            step = step_now(progress, tour)
            if step is not None:
                yield from _of_step(progress, step, scene)
            if progress.state == "parting":
                yield from _facing(progress)
            elif not _points(progress, step):
                yield from _facing_at_stop(progress, tour)


def _asking_to_pass(progress: Progress, scene: Scene, now: float) -> Iterator[Wish]:
    """People in its way are asked to let it pass."""
    since = now if progress.stuck_since is None else max(progress.stuck_since, progress.since)
    if asked := sum(now - since >= after for after in PASSES_S):
        yield _said(progress, f"pass-{asked}", PASS, scene)


def _says_first(progress: Progress) -> bool:
    """Whether it first says why it ends, or goes on otherwise than visitors expect, or what a code carries."""
    if progress.state == "presenting" and progress.carried is not None:
        return True
    return progress.state in ("parting", "presenting") and bool(progress.excuse)


def _carried(progress: Progress, scene: Scene) -> Iterator[Wish]:
    """What a code has it say."""
    if (says := progress.carried) is not None:
        yield _said(progress, "code", {says.language: says.text}, scene)


def _points(progress: Progress, step: Step | None) -> bool:
    """Whether it is pointing, for which the base may have to turn away from visitors."""
    return step is not None and step.point is not None and key(progress, "point") not in progress.ended


def _facing_at_stop(progress: Progress, tour: Tour) -> Iterator[Wish]:
    """Turned to visitors, where its tour wants that of it."""
    if progress.state == "inviting" or stop_of(progress, tour).stand.face == "visitors":
        yield from _facing(progress)


def _facing(progress: Progress) -> Iterator[Wish]:
    if progress.towards is not None:
        yield Wish("face", ROTATE, {"heading": round(progress.towards, 2)})


def _of_step(progress: Progress, step: Step, scene: Scene) -> Iterator[Wish]:
    for name, cls, params in desires_of(step, scene.language, scene.tour.languages[0]):
        if name == "say":
            params["text"] = _from_sentence(params["text"], progress.said_from)
        yield Wish(key(progress, name), cls, params)
    if step.look == "visitors":
        yield Wish(key(progress, "look"), TRACK_FACE)
    elif step.look == "poster":
        yield Wish(key(progress, "look"), LOOK_AT, {"place": stop_of(progress, scene.tour).poster})


def _going(progress: Progress, scene: Scene, place: str, stop: Stop | None = None) -> Wish:
    params = dict(scene.places[place]) if stop is None else goal_of(stop, scene)
    speed = scene.tour.pace.speed * (SLOWLY if progress.slow else 1.0)
    if stop is not None:
        params |= {"tolerance_m": stop.stand.tolerance_m, "tolerance_rad": stop.stand.tolerance_rad}
    return Wish(key(progress, "go"), GO_TO, params | {"speed": round(speed, 3)})


def _said(progress: Progress, name: str, text: Mapping[str, str], scene: Scene) -> Wish:
    language = scene.language if scene.language in text else scene.tour.languages[0]
    used = language if language in text else next(iter(text))
    return Wish(key(progress, name), SAY, {"text": text_in(text, used, used), "language": used})


def _from_sentence(text: str, sentence: int) -> str:
    """``text`` from the sentence of this number on, the last at the latest."""
    spans = sentences_of(text)
    return text[spans[min(sentence, len(spans) - 1)][0] :] if spans else text
