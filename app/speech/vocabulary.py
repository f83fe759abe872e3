"""Which words a recognizer knows, found without starting it: from its dictionary. Blocking."""

from __future__ import annotations

import importlib.util
from collections.abc import Collection
from pathlib import Path

from app.base.plain_file import open_plain
from app.speech.pocketsphinx import PocketSphinx
from app.speech.recognition import RecognizerConfig

#: More of a file is not read (bytes): the largest dictionaries in use have a tenth of it.
_LARGEST = 64 << 20


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
    with open_plain(dictionary) as file:
        lines = b"\n" + file.read(_LARGEST)  # searched as one: line by line it held the interpreter for 0.1 s
    starts = {word: (f"\n{word} ".encode(), f"\n{word}\t".encode()) for word in words}
    return frozenset(word for word, begins in starts.items() if not any(begin in lines for begin in begins))
