"""What the guide wants to perceive in each state. Pure: the lanes show that attention changes with the tour.

While it leads it sees only ahead, so faces are not looked for, and voices are: ears hear all round.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from app.modules.motivations.tour_guide.commands import commands_now
from app.modules.motivations.tour_guide.progress import Progress, State
from app.modules.motivations.tour_guide.wishes import Scene, Wish, step_now, stop_of
from app.tours.codes import obeys_codes
from app.tours.values import Words

FACES: Final = "LocateFaces"
VOICES: Final = "LocateVoices"
PERSONS: Final = "TrackPersons"
NOISES: Final = "DetectNoises"
CODES: Final = "FindQRCodes"
WORDS: Final = "ListenForWords"
SLAM: Final = "SLAM"
#: The recognizer is asked for so many phrases, and characters of all, at most.
_MOST_PHRASES, _MOST_CHARACTERS = 20, 500

_SEES: Final[frozenset[State]] = frozenset(
    {"inviting", "confirming", "waiting", "searching", "turning", "presenting", "listening", "answering", "parting"}
)
#: Who turns away there is no face, and is a person still.
_BINDS: Final[frozenset[State]] = _SEES - {"inviting", "confirming", "parting"}
_HEARS: Final[frozenset[State]] = frozenset({"confirming", "leading", "waiting", "searching", "turning", "listening"})
_DRIVES: Final[frozenset[State]] = frozenset({"leading", "waiting", "searching", "blocked", "lost", "going_home"})


def perceptions(progress: Progress, scene: Scene) -> tuple[Wish, ...]:
    """Desires of perceptions; their keys stay from state to state, so that none lapses in between."""
    return tuple(_perceptions(progress, scene))


def _perceptions(progress: Progress, scene: Scene) -> Iterator[Wish]:
    state, begin = progress.state, scene.tour.begin.by
    invites = state == "idle"
    if state in _SEES or (invites and ("face" in begin or "voice" in begin)):
        yield Wish("faces", FACES)
    if state in _BINDS:
        yield Wish("persons", PERSONS)
    if state in _HEARS or (invites and "voice" in begin):
        yield Wish("voices", VOICES)
    if state in _DRIVES:
        yield Wish("slam", SLAM)
    if state in _DRIVES or (state == "listening" and obeys_codes(scene.tour)):
        yield Wish("codes", CODES)
    step = step_now(progress, scene.tour)
    wait = None if state != "listening" or step is None else step.wait
    if wait is not None and (wait.claps is not None or wait.call):
        yield Wish("noises", NOISES)
    if phrases := awaited_phrases(progress, scene):
        yield Wish("words", WORDS, {"words": ", ".join(phrases), "language": scene.language})


def awaited_phrases(progress: Progress, scene: Scene) -> tuple[str, ...]:
    """The phrases that are listened for now, in the language of the visitors; as many as can be."""
    found: list[str] = []
    for words in _awaited(progress, scene):
        for phrase in words.get(scene.language, ()):
            fits = len(found) < _MOST_PHRASES and len(", ".join((*found, phrase))) <= _MOST_CHARACTERS
            if fits and phrase.lower() not in found:
                found.append(phrase.lower())
    return tuple(found)


def _awaited(progress: Progress, scene: Scene) -> Iterator[Words]:
    confirm = scene.tour.greeting.confirm
    if progress.state == "confirming" and confirm is not None:
        yield confirm.agree
        yield confirm.decline
    if progress.state == "listening":
        step = step_now(progress, scene.tour)
        if step is not None and step.wait is not None:
            yield step.wait.words
        for question in stop_of(progress, scene.tour).questions:
            yield question.words
    for words, _ in commands_now(progress, scene.tour):
        yield words
