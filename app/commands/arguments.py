"""What several commands take: the name of a log, numbers."""

from __future__ import annotations

import math
from pathlib import Path

from app.errors import ConfigError


def find_log(text: str) -> Path:
    """The file people mean: a path, or the bare name of a recording. Raises ConfigError."""
    from app.recording.library import RecordingLibrary, default_folder

    path = Path(text)
    if path.exists():
        return path
    library = RecordingLibrary(default_folder())
    try:
        recording = library.path(text.removesuffix(".mcap"))
    except ValueError:
        raise ConfigError(f"there is no file {text}") from None
    if not recording.is_file():
        raise ConfigError(f"there is no file {text}, and no recording of that name in {library.folder}")
    return recording


def number(text: str) -> float | None:
    """``text`` as a finite number, or None where it is none."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None
