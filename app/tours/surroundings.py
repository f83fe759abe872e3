"""What there is of what a tour refers to, looked up on the disk. Blocking."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from app.attention.desires import DesireClass
from app.base.errors import ConfigError
from app.maps.library import MapLibrary, UnknownMap
from app.speech.recognition import RecognizerConfig
from app.speech.vocabulary import dictionary_of, unknown_words
from app.tours.checks import Surroundings, media_of, words_by_language
from app.tours.model import Tour

#: The language of the usual recognizer's own dictionary.
_USUAL = "en"


def surroundings(
    tour: Tour,
    *,
    maps: MapLibrary,
    folders: Sequence[Path],
    classes: Mapping[str, DesireClass] | None = None,
    recognizer: RecognizerConfig | None = None,
) -> Surroundings:
    """The surroundings of ``tour``: maps in ``maps``, media in the first of ``folders`` that has them.

    ``classes`` are those of the program, ``recognizer`` what recognizes words in it; None: not known.
    """
    no_map, places = "", None
    try:
        places = frozenset(place.id for place in maps.places(tour.map))
    except UnknownMap as refusal:
        no_map = f"{refusal}; map the place and save that as {tour.map}, or give the tour another map"
    except (ConfigError, ValueError, OSError) as damage:
        no_map = f"the map cannot be used: {damage}"
    missing = frozenset(file for _, file in media_of(tour) if not any((folder / file).is_file() for folder in folders))
    return Surroundings(no_map, places, missing, classes, _unknown_words(tour, recognizer))


def _unknown_words(tour: Tour, recognizer: RecognizerConfig | None) -> Mapping[str, frozenset[str]] | None:
    dictionary = None if recognizer is None else dictionary_of(recognizer)
    if recognizer is None or dictionary is None:
        return None
    wanted = words_by_language(tour)
    # A dictionary of the user's does not say of what language it is.
    known = [language for language in wanted if recognizer.path is not None or language.partition("-")[0] == _USUAL]
    try:
        return {language: unknown_words(dictionary, wanted[language]) for language in known}
    except OSError:
        return None  # the recognizer itself reports that, where it is started
