"""The folder of reports on runs of tours, and the run that is under way, for a program that is started again."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import ClassVar

import msgspec

from app.base.named_library import NamedLibrary, data_folder
from app.base.plain_file import read_plain
from app.base.whole_file import write_whole
from app.tours.run_report import RunReport

#: So many reports are kept, the newest.
MOST_REPORTS = 1000
#: A file has no more bytes than these.
MOST_BYTES = 1_000_000


class UnknownRun(Exception):
    """There is no report on this run; the message is one sentence."""


class RunLibrary(NamedLibrary):
    """Reports in ``folder``, one file ``RUN.json`` each, and ``under-way`` beside them. All methods touch the disk, and
    raise OSError. ``resumes``: whether a run that is under way is kept for the program that is started next."""

    kind: ClassVar[str] = "run"
    suffix: ClassVar[str] = ".json"

    def __init__(self, folder: Path, *, resumes: bool = True) -> None:
        super().__init__(folder)
        self._resumes = resumes
        #: Reports that are about to be written, by their runs.
        self._unwritten: dict[str, RunReport] = {}

    def expect(self, report: RunReport) -> None:
        """List ``report`` from now on, though :meth:`add` writes it a moment later. Does not touch the disk."""
        self._unwritten[report.run] = report

    def add(self, report: RunReport) -> None:
        """Keep ``report``, in place of one on the same run; the oldest beyond MOST_REPORTS are deleted."""
        self._write(self.path(report.run), msgspec.json.format(msgspec.json.encode(report), indent=1))
        self._unwritten.pop(report.run, None)
        for name in self._names()[MOST_REPORTS:]:
            self.path(name).unlink(missing_ok=True)

    def reports(self) -> tuple[RunReport, ...]:
        """Every report that can be read, the newest first."""
        # Taken before the disk is read: what is written meanwhile is in one of them, or in both.
        unwritten = dict(self._unwritten)
        found = {report.run: report for report in self._readable()} | unwritten
        return tuple(found[run] for run in sorted(found, reverse=True))

    def report(self, run: str) -> RunReport:
        """The report on ``run``. Raises UnknownRun, ValueError for what cannot be an id."""
        path = self.path(run)
        found = self._unwritten.get(run) or self._read(path)
        if found is None:
            raise UnknownRun(f"there is no report on a run {run!r}")
        return found

    def delete(self, run: str) -> None:
        """Delete the report on ``run``. Raises UnknownRun, ValueError for what cannot be an id."""
        path = self.path(run)
        unwritten = self._unwritten.pop(run, None)
        try:
            path.unlink()
        except FileNotFoundError:
            if unwritten is None:
                raise UnknownRun(f"there is no report on a run {run!r}") from None

    def keep(self, run: bytes | None) -> None:
        """Keep the run that is under way; None: none is."""
        if not self._resumes:
            return
        if run is None:
            self._under_way.unlink(missing_ok=True)
        else:
            self._write(self._under_way, run)

    def kept(self) -> bytes | None:
        """The run that was under way; None: none was."""
        if not self._resumes:
            return None
        try:
            return read_plain(self._under_way, MOST_BYTES)
        except FileNotFoundError:
            return None

    @property
    def _under_way(self) -> Path:
        return self.folder / "under-way"

    def _names(self) -> list[str]:
        # Ids begin with their time.
        return sorted((name for name, _ in self.entries()), reverse=True)

    def _readable(self) -> Iterator[RunReport]:
        for name in self._names():
            if (found := self._read(self.path(name))) is not None:
                yield found

    def _read(self, path: Path) -> RunReport | None:
        try:
            return msgspec.json.decode(read_plain(path, MOST_BYTES), type=RunReport)
        except (FileNotFoundError, msgspec.DecodeError):
            return None

    def _write(self, path: Path, data: bytes) -> None:
        """Wholly or not at all."""
        self.folder.mkdir(parents=True, exist_ok=True)
        write_whole(path, data)


def default_folder() -> Path:
    """The folder of the user's reports: ``$HBBA_TOUR_RUNS``, or ``hbba/tour-runs`` in the user's data folder."""
    return data_folder("HBBA_TOUR_RUNS", "tour-runs")
