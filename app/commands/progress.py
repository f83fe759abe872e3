"""Progress of long work: a bar on a terminal, a line now and then elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol

#: Where nobody sees a bar move, a line so often (s).
LINE_EVERY_S = 5.0


class Bar(Protocol):
    """What is told of progress."""

    def update(self, done: float, text: str = "") -> None:
        """So much is done of the total; ``text`` says what was done last."""
        ...


@contextmanager
def bar(what: str, total: float) -> Iterator[Bar]:
    """Show the progress of ``what`` towards ``total`` on standard error, until left."""
    if sys.stderr.isatty():
        with _Rich(what, total) as shown:
            yield shown
    else:
        yield _Lines(what, total)


class _Rich:
    def __init__(self, what: str, total: float) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

        self._progress = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TaskProgressColumn(),
            TimeRemainingColumn(),
            TextColumn("{task.fields[text]}", markup=False),
            console=Console(stderr=True),
        )
        self._task = self._progress.add_task(what, total=total, text="")

    def __enter__(self) -> _Rich:
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()

    def update(self, done: float, text: str = "") -> None:
        self._progress.update(self._task, completed=done, text=text)


class _Lines:
    def __init__(self, what: str, total: float) -> None:
        self._what = what
        self._total = total
        self._told = time.monotonic()

    def update(self, done: float, text: str = "") -> None:
        now = time.monotonic()
        if now - self._told >= LINE_EVERY_S or done >= self._total:
            self._told = now
            share = 100 * done / self._total if self._total else 100
            print(f"{self._what}: {share:.0f} %  {text}".rstrip(), file=sys.stderr, flush=True)
