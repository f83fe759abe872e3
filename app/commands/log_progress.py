"""How far a long work on a log is: a bar on a terminal, a line now and then elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

from app.recording.output import Progress

#: Where there is no terminal: a line after so long (s), and not more often.
LINE_EVERY_S = 5.0


@contextmanager
def shown(title: str) -> Iterator[Progress]:
    """A progress to be called as often as one likes; the bar is taken away at the end."""
    from rich.console import Console
    from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    errors = Console(stderr=True)
    if not errors.is_terminal:
        yield _Lines(title)
        return
    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    with Bar(*columns, console=errors, transient=True) as bar:
        task = bar.add_task(title, total=None)
        due = 0.0

        def progress(done: int, total: int) -> None:
            nonlocal due
            # Telling the bar costs more than copying a record does.
            if (now := time.monotonic()) >= due or done >= total:
                due = now + 0.05
                bar.update(task, completed=done, total=total)

        yield progress


class _Lines:
    """Whole lines on standard error for a file or a pipe, none where all is done quickly."""

    def __init__(self, title: str) -> None:
        self._title = title
        self._due = time.monotonic() + LINE_EVERY_S

    def __call__(self, done: int, total: int) -> None:
        if (now := time.monotonic()) >= self._due:
            self._due = now + LINE_EVERY_S
            print(f"{self._title}: {100 * done // max(total, 1)} %", file=sys.stderr, flush=True)
