"""A rehearsal that the console starts: ``python -m app.console.rehearsal_process CONSOLE``, with the process id of the
console, which it does not outlive. What is rehearsed comes on standard input (:class:`RehearsalOrder`); how far it is,
then the result or why there is none, goes to standard output, a line of JSON each (:class:`RehearsalWord`)."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import msgspec

from app.base.child_processes import end_with_parent
from app.base.errors import ConfigError
from app.rehearsal.result import Rehearsal

#: A robot that drives meanwhile goes first.
_NICE = 10


class RehearsalOrder(msgspec.Struct):
    """What is rehearsed: a ``tour`` as the text of its file, by the program ``config``, on a map in the folder
    ``maps``."""

    tour: str
    config: str
    maps: str
    language: str
    people: int
    seed: int


class RehearsalWord(msgspec.Struct, omit_defaults=True):
    """One of: how much was played (``seconds``, and the id of the stop), the ``result``, why there is none."""

    seconds: float | None = None
    stop: str = ""
    result: Rehearsal | None = None
    problem: str | None = None


def main(arguments: list[str]) -> None:
    """Rehearse what standard input says."""
    (console,) = arguments
    end_with_parent()
    if str(os.getppid()) != console:
        return  # it ended before its end could be watched
    os.nice(_NICE)
    # What anything else prints is no word of ours.
    with os.fdopen(os.dup(sys.stdout.fileno()), "wb") as out:
        os.dup2(sys.stderr.fileno(), sys.stdout.fileno())

        def say(word: RehearsalWord) -> None:
            out.write(msgspec.json.encode(word) + b"\n")
            out.flush()

        order = msgspec.json.decode(sys.stdin.buffer.read(), type=RehearsalOrder)
        try:
            say(RehearsalWord(result=finished(_rehearsed(order, say))))
        except ConfigError as refusal:
            say(RehearsalWord(problem=str(refusal)))


def finished(rehearsal: Rehearsal) -> Rehearsal:
    """``rehearsal`` without what JSON cannot say: a sentence that is said at the end ends with it."""
    subtitles = (
        replace(said, until_s=rehearsal.duration_s) if math.isinf(said.until_s) else said
        for said in rehearsal.subtitles
    )
    return replace(rehearsal, subtitles=tuple(subtitles))


def _rehearsed(order: RehearsalOrder, say: Callable[[RehearsalWord], None]) -> Rehearsal:
    # The console itself needs none of it.
    from app.base import logging_setup
    from app.maps.library import MapLibrary
    from app.program.config import load_configuration
    from app.rehearsal.rehearse import RehearsalRequest, rehearse
    from app.tours.tour_file import read_tour

    logging_setup.configure("error", as_json=False)
    tour, _ = read_tour(order.tour, "the tour")
    configuration, maps = load_configuration(Path(order.config)), MapLibrary(Path(order.maps))
    request = RehearsalRequest(tour, configuration, maps, order.language, people=order.people, seed=order.seed)
    return rehearse(request, lambda seconds, stop: say(RehearsalWord(seconds=seconds, stop=stop)))


if __name__ == "__main__":
    main(sys.argv[1:])
