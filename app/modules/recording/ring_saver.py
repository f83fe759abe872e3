"""Saving of rings as recordings: the running ring, and rings of earlier runs. Copies in threads."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path
from typing import Any

from app.logs.library import RecordingLibrary, default_name
from app.logs.log import LogError
from app.logs.mcap.ring import HeldSegments, Ring
from app.logs.mcap.ring_folder import begin_of, leftovers, rescue, size_of
from app.logs.mcap.writer import MEGABYTE, RecordingWriter, Sink, in_words
from app.logs.recorder_service import RecorderUnavailable

NO_RING = "no ring turns that could be saved: ask for a recording that keeps only the last minutes first"


class RingSaver:
    """Saves rings into a library."""

    def __init__(
        self,
        library: RecordingLibrary,
        least_free_bytes: int,
        log: logging.Logger,
        charge: Callable[..., Any],
    ) -> None:
        """Keeps at least ``least_free_bytes`` of the disk free; ``charge(function, *args)`` runs the work."""
        self._library = library
        self._least_free_bytes = least_free_bytes
        self._log = log
        self._charge = charge
        self._savings = 0
        self._none_saving = asyncio.Event()
        self._none_saving.set()

    async def save(self, writer: RecordingWriter, now: float, minutes: float | None, name: str | None) -> str:
        """Save the last ``minutes`` (None: all) of the ring that ``writer`` writes; returns the recording's name.

        Raises ValueError for an invalid name, RecorderUnavailable if it writes no ring, LogError if it cannot be
        written.
        """
        self._library.path(name or default_name(now))
        seconds = None if minutes is None else 60 * minutes
        self._savings += 1
        self._none_saving.clear()
        try:
            hold = await _held(writer.call(lambda sink: _hold(sink, now, seconds)))
            with hold:
                await self._in_thread(self._check_room, hold.bytes)
                targets = self._library.candidates(name or "", now)
                path: Path = await self._in_thread(hold.save, targets, self._progress("saving the ring"))
        except OSError as error:
            raise LogError(in_words(error)) from error
        finally:
            self._savings -= 1
            if not self._savings:
                self._none_saving.set()
        self._log.info("the ring's last %.0f s are saved as %s", hold.duration_s, path.stem)
        return path.stem

    async def rescue(self) -> None:
        """Make a recording of each ring that ended and was not discarded, in this program or by one that is gone.

        A ring that cannot become a recording is logged and left.
        """
        for home in await self._in_thread(leftovers, self._library.ring_folder):
            # A ring that has just ended may still be read by an earlier call.
            await self._none_saving.wait()
            try:
                saved = await self._in_thread(self._rescue, home)
            except (LogError, OSError) as error:
                words = in_words(error) if isinstance(error, OSError) else str(error)
                self._log.warning("a ring that ended could not be saved; it stays in %s: %s", home, words)
            else:
                if saved is not None:
                    self._log.warning("a ring that ended is saved as %s", saved.stem)

    def _rescue(self, home: Path) -> Path | None:
        self._check_room(size_of(home))
        begin = begin_of(home)
        targets = self._library.candidates(f"{default_name(begin)}-ring", begin)
        return rescue(home, targets, self._progress("saving a ring that ended"))

    def _check_room(self, size: int) -> None:
        free = self._library.free_bytes()
        if free - size < self._least_free_bytes:
            raise LogError(
                f"no room to save the ring: it takes {size / MEGABYTE:.0f} MB, {free / MEGABYTE:.0f} MB are free and "
                f"{self._least_free_bytes / MEGABYTE:.0f} MB are kept free; save fewer minutes, or delete recordings"
            )

    def _progress(self, what: str) -> Callable[[int, int], None]:
        reported = 0

        def progress(done: int, total: int) -> None:
            nonlocal reported
            quarters = 4 * done // max(total, 1)
            if quarters > reported:
                reported = quarters
                self._log.info("%s: %d %% of %.0f MB", what, 25 * quarters, total / MEGABYTE)

        return progress

    async def _in_thread(self, function: Callable[..., Any], *args: Any) -> Any:
        """As ``Module.compute``, in another thread: long work here delays no other work of the module."""
        return await asyncio.to_thread(self._charge, function, *args)


def _hold(sink: Sink, at: float, seconds: float | None) -> HeldSegments:
    if not isinstance(sink, Ring):
        raise RecorderUnavailable(NO_RING)
    return sink.hold(at, seconds)


async def _held(held: Future[HeldSegments]) -> HeldSegments:
    """Wait for it; held segments that arrive after the caller was cancelled are released, else they would stay for
    ever."""
    try:
        return await asyncio.shield(asyncio.wrap_future(held))
    except asyncio.CancelledError:
        held.add_done_callback(_let_go)
        raise


def _let_go(held: Future[HeldSegments]) -> None:
    if held.exception() is None:
        held.result().release()
