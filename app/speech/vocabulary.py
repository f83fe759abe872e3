"""Which words a recognizer knows, found without starting it: from its dictionary. Blocking."""

from __future__ import annotations

import importlib.util
from collections.abc import Collection
from pathlib import Path

from app.base.plain_file import open_plain
from app.speech.pocketsphinx import PocketSphinx
from app.speech.recognition import RecognizerConfig

#: A longer line is no word with its phones (bytes).
_LONGEST_LINE = 1000


def dictionary_of(config: RecognizerConfig) -> Path | None:
    """The file of the words that the recognizer ``config`` knows; None where that is not known: an engine of others, a
    package that is not installed."""
    if config.class_path != f"{PocketSphinx.__module__}:{PocketSphinx.__name__}":
        return None
    if config.path is not None:
        folder = config.path
    else:
        package = importlib.util.find_spec("pocketsphinx")
        if package is None or package.origin is None:
            return None
        folder = Path(package.origin).parent / "model" / "en-us"
    return next(iter(sorted(folder.glob("*.dict"))), None)


def unknown_words(dictionary: Path, words: Collection[str]) -> frozenset[str]:
    """Those of ``words`` (single ones, in lower case) that ``dictionary`` does not have. Raises OSError."""
    left = {word.encode() for word in words}
    with open_plain(dictionary) as file:
        while left and (line := file.readline(_LONGEST_LINE)):
            left.discard(line.partition(b" ")[0].partition(b"\t")[0].strip())
    return frozenset(word.decode() for word in left)
