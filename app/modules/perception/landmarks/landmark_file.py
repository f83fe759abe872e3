"""File format of a map's landmarks, ``landmarks.npz``: their sightings by keyframe.

An archive of arrays, as numpy writes them, without pickles. Rows of all landmarks' sightings are concatenated;
``row_of`` (S,) holds the landmark of each. ``anchor`` and ``anchor_pose`` are the keyframes in use and where they were.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.base.errors import ConfigError
from app.base.npz_source import checked_array, joined, read_arrays
from app.modules.perception.landmarks.sightings import FloatArray, Sightings
from app.modules.perception.landmarks.types import Anchored

LANDMARKS_FILE = "landmarks.npz"
FORMAT = 1
#: No map has more landmarks, nor a code more characters.
MOST_LANDMARKS = 10_000
_LONGEST_TEXT = 8_000
_WHAT = "the map's landmarks"


@dataclass(frozen=True, slots=True, eq=False)
class StoredLandmarks:
    """``landmarks``, and their anchors: ``ids`` (K,) int64, ascending, at ``X_MK`` (K, 3) x, y, theta when kept."""

    landmarks: tuple[Anchored, ...]
    ids: NDArray[np.int64]
    X_MK: FloatArray


NONE = StoredLandmarks((), np.zeros(0, np.int64), np.zeros((0, 3)))


def write_landmarks(path: Path, stored: StoredLandmarks) -> None:
    """Write ``stored`` to the file ``path``. Raises OSError."""
    marks = stored.landmarks
    sightings = [mark.sightings for mark in marks]
    with path.open("wb") as file:
        np.savez_compressed(
            file,
            format=np.array(FORMAT),
            id=np.array([mark.id for mark in marks], np.int64),
            # Bytes: an array of text loses what is no character, and zeros at its end.
            text=np.frombuffer(b"".join(_encoded(mark.text) for mark in marks), np.uint8),
            text_length=np.array([len(_encoded(mark.text)) for mark in marks], np.int64),
            seen=np.array([mark.seen for mark in marks], np.int64),
            time=np.array([(mark.first_seen, mark.last_seen) for mark in marks], np.float64).reshape(-1, 2),
            row_of=np.repeat(np.arange(len(marks)), [len(one.anchors) for one in sightings]),
            keyframe=joined([one.anchors for one in sightings], (0,), np.int64),
            position=joined([one.p_KQ for one in sightings], (0, 3), np.float64),
            information=joined([one.information for one in sightings], (0, 3, 3), np.float64),
            heading=joined([one.headings for one in sightings], (0, 2), np.float64),
            anchor=stored.ids,
            anchor_pose=stored.X_MK,
        )
        file.flush()
        os.fsync(file.fileno())


def read_landmarks(path: Path) -> StoredLandmarks:
    """The landmarks in the file ``path``; none where there is no such file. Raises ConfigError for a damaged one."""
    if not path.exists():
        return NONE
    arrays = read_arrays(path, _WHAT)
    try:
        if int(arrays["format"]) != FORMAT:
            raise ConfigError(f"{_WHAT} have format {arrays['format']}; this program reads {FORMAT}", str(path))
        return _stored(arrays)
    except KeyError as missing:
        raise ConfigError(f"{_WHAT} are damaged: there is no {missing}", str(path)) from None
    except (ValueError, TypeError, IndexError) as damage:
        raise ConfigError(f"{_WHAT} are damaged: {damage}", str(path)) from None


def _stored(a: Mapping[str, NDArray[Any]]) -> StoredLandmarks:
    ids = checked_array(a, "id", np.int64, (-1,))
    count = len(ids)
    if count > MOST_LANDMARKS or len(np.unique(ids)) != count or (ids < 1).any():
        raise ValueError(f"there are more than {MOST_LANDMARKS}, or two with one id, or ids below 1")
    lengths, seen = (checked_array(a, name, np.int64, (count,)) for name in ("text_length", "seen"))
    times = checked_array(a, "time", np.float64, (count, 2))
    ends = np.cumsum(lengths)
    text = checked_array(a, "text", np.uint8, (int(ends[-1]) if count else 0,)).tobytes()
    if ((lengths < 0) | (lengths > _LONGEST_TEXT)).any():
        raise ValueError(f"a text has more than {_LONGEST_TEXT} bytes")
    row_of = checked_array(a, "row_of", np.int64, (-1,))
    rows = len(row_of)
    keyframes = checked_array(a, "keyframe", np.int64, (rows,))
    positions, headings = (checked_array(a, n, np.float64, (rows, w)) for n, w in (("position", 3), ("heading", 2)))
    information = checked_array(a, "information", np.float64, (rows, 3, 3))
    anchors = checked_array(a, "anchor", np.int64, (-1,))
    poses = checked_array(a, "anchor_pose", np.float64, (len(anchors), 3))
    if (np.diff(anchors) <= 0).any() or np.setdiff1d(keyframes, anchors).size:
        raise ValueError("a sighting belongs to a keyframe whose pose is missing")
    if rows and not (np.linalg.eigvalsh(information) > 0).all():
        raise ValueError("information is not above 0")
    if set(row_of.tolist()) != set(range(count)):
        raise ValueError("a landmark has no sighting, or a sighting no landmark")
    marks = []
    for row, id in enumerate(ids.tolist()):
        own = row_of == row
        sightings = Sightings(keyframes[own], positions[own], information[own], headings[own])
        if (np.diff(sightings.anchors) <= 0).any():
            raise ValueError("a landmark has two rows for one keyframe")
        said = text[int(ends[row] - lengths[row]) : int(ends[row])].decode("utf-8", "surrogatepass")
        first, last = times[row].tolist()
        marks.append(Anchored(id, said, sightings, int(seen[row]), first, last_seen=last, here=False))
    return StoredLandmarks(tuple(marks), anchors, poses)


def _encoded(text: str) -> bytes:
    return text.encode("utf-8", "surrogatepass")
