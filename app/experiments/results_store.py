"""Store of an experiment's results, one JSON line each, so that an interrupted run can be resumed."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from app.base import paths
from app.base.errors import ConfigError

T = TypeVar("T")


def default_folder(experiment: str) -> Path:
    """``$HBBA_EXPERIMENTS/<experiment>``, or ``hbba/experiments/<experiment>`` in the user's data folder (XDG)."""
    named = os.environ.get("HBBA_EXPERIMENTS")
    data = os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share"
    return (Path(named) if named else Path(data) / "hbba" / "experiments") / experiment


class ResultsStore:
    """The file ``results.jsonl`` in ``folder``: a first line with their identity, then one result a line. Results of
    another identity (other worlds, another program) are moved aside, as ``results.old.jsonl``, and so are all of them
    if ``fresh``. Raises ConfigError where the folder or the file cannot be used.
    """

    def __init__(self, folder: Path, of: dict[str, Any], *, fresh: bool = False) -> None:
        self.file = folder / "results.jsonl"
        self.moved = ""
        self._of = of
        try:
            folder.mkdir(parents=True, exist_ok=True)
            found = None if fresh else self._read()
            if found is None and self.file.exists():
                self.moved = str(self.file.replace(folder / "results.old.jsonl"))
            self.found: list[dict[str, Any]] = found or []
            if not self.file.exists():
                self.file.write_text(json.dumps({"of": of}) + "\n", encoding="utf-8")
        except OSError as failure:
            raise ConfigError(f"cannot be used for results: {failure.strerror or failure}", str(folder)) from None

    def add(self, result: dict[str, Any]) -> None:
        """Store ``result``; on disk before it returns. Raises ConfigError on a disk error."""
        try:
            with self.file.open("a", encoding="utf-8") as lines:
                lines.write(json.dumps(result, allow_nan=False) + "\n")
                lines.flush()
                os.fsync(lines.fileno())
        except OSError as failure:
            raise ConfigError(f"cannot be written: {failure.strerror or failure}", str(self.file)) from None

    def _read(self) -> list[dict[str, Any]] | None:
        """The stored results; None for another identity. A line cut off by a crash is dropped."""
        if not self.file.exists():
            return []
        found: list[dict[str, Any]] = []
        whole = 0
        with self.file.open("rb") as lines:
            for line in lines:
                try:
                    entry = json.loads(line)
                except ValueError:
                    break
                if not line.endswith(b"\n") or not isinstance(entry, dict):
                    break
                if whole == 0:
                    if entry.get("of") != self._of:
                        return None
                else:
                    found.append(entry)
                whole += len(line)
        if whole == 0:
            return None
        os.truncate(self.file, whole)
        return found


def results_in(kept: ResultsStore, kind: type[T]) -> list[T]:
    """The stored results as ``kind``, a dataclass. Raises ConfigError for a line that is none."""
    try:
        return [msgspec.convert(document, kind) for document in kept.found]
    except msgspec.ValidationError as failure:
        raise ConfigError(f"holds a line that is no result ({failure}); --fresh starts again", str(kept.file)) from None


def program_digest(config: Path) -> str:
    """Digest of the program's configuration and code: results of different programs are not combined."""
    digest = hashlib.sha256()
    for folder, ending in ((config.resolve().parent, "*.yaml"), (Path(paths.__file__).parents[1], "*.py")):
        for file in sorted(folder.rglob(ending)):
            digest.update(file.relative_to(folder).as_posix().encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()[:16]
