"""Progress of a long operation: a bar on a terminal, a line now and then elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol

#: Without a terminal: a line after this time (s), and at most one in it.
LINE_EVERY_S = 5.0


#: Least time (s) between two updates of a bar: more frequent ones cost more than the work they report.
_BAR_EVERY_S = 0.05


class Progress(Protocol):
    """To be called as often as one likes."""

    def __call__(self, done: float, total: float, text: str = "") -> None:
        """Update: ``done`` of the ``total``; ``text`` describes the last step."""
        ...


def part(progress: Progress, before: int, files: int, name: str) -> Progress:
    """The progress within one of ``files``, ``before`` of which are done already."""

    def update(done: float, total: float, text: str = "") -> None:
        progress(before + (done / total if total else 1), files, text or name)

    return update


@contextmanager
def shown(title: str) -> Iterator[Progress]:
    """Show the progress of the block on standard error; the bar is removed at the end."""
    from rich.console import Console
    from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    errors = Console(stderr=True)
    if not errors.is_terminal:
        yield _Lines(title)
        return
    said = TextColumn("{task.fields[text]}", markup=False)
    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn(), said)
    with Bar(*columns, console=errors, transient=True) as bar:
        task = bar.add_task(title, total=None, text="")
        due = 0.0

        def progress(done: float, total: float, text: str = "") -> None:
            nonlocal due
            if (now := time.monotonic()) >= due or done >= total:
                due = now + _BAR_EVERY_S
                bar.update(task, completed=done, total=total, text=text)

        yield progress


class _Lines:
    """Whole lines on standard error for a file or a pipe, none where all is done quickly."""

    def __init__(self, title: str) -> None:
        self._title = title
        self._due = time.monotonic() + LINE_EVERY_S
        self._first: tuple[float, float] | None = None

    def __call__(self, done: float, total: float, text: str = "") -> None:
        now = time.monotonic()
        share = done / total if total else 1.0
        if self._first is None or share <= self._first[1]:  # steps of a former run do not count for the speed
            self._first = now, share
        if now >= self._due:
            self._due = now + LINE_EVERY_S
            line = f"{self._title}: {int(100 * share)} %{self._left(now, share)}  {text}"
            print(line.rstrip(), file=sys.stderr, flush=True)

    def _left(self, now: float, share: float) -> str:
        """Remaining time in words; "" for a minute or less, or while it is unknown."""
        assert self._first is not None
        began, before = self._first
        if share <= before:
            return ""
        minutes = (now - began) * (1 - share) / (share - before) / 60
        return f", about {minutes:.0f} min left" if minutes >= 1 else ""
