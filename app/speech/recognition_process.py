"""Recognition in a process of its own: engines hold the interpreter's lock for tens of milliseconds an utterance."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool

import numpy as np
from numpy.typing import NDArray

from app.base.child_processes import end_with_parent, safe_path
from app.speech.recognition import Recognition, RecognitionEngine, RecognizerConfig

#: Lower priority than the control cycle.
_NICENESS = 5


class RecognitionProcess:
    """A :class:`RecognitionEngine`: that of ``config`` in a process that starts on first use; :meth:`close` ends it.

    Called by one thread at a time, which waits without the interpreter's lock.
    """

    def __init__(self, config: RecognizerConfig) -> None:
        self._config = config
        self._pool: ProcessPoolExecutor | None = None

    def recognize(self, samples: NDArray[np.int16], phrases: Sequence[str], language: str) -> Recognition | None:
        """As of the engine. A killed process is replaced; the second time, raises BrokenProcessPool."""
        try:
            return self._submitted(samples, phrases, language).result()
        except BrokenProcessPool:
            self.close()
            return self._submitted(samples, phrases, language).result()

    def close(self) -> None:
        """End the process."""
        if self._pool is not None:
            self._pool.shutdown(wait=True, cancel_futures=True)
            self._pool = None

    def _submitted(
        self, samples: NDArray[np.int16], phrases: Sequence[str], language: str
    ) -> Future[Recognition | None]:
        if self._pool is None:
            # Spawned, not forked: threads of this process may hold locks.
            context = multiprocessing.get_context("spawn")
            self._pool = ProcessPoolExecutor(1, mp_context=context, initializer=_begin, initargs=(self._config,))
        with safe_path():  # the first call starts the process
            return self._pool.submit(_recognize, samples, tuple(phrases), language)


class _Child:
    """What the child process keeps between calls."""

    config: RecognizerConfig
    engine: RecognitionEngine | None = None


def _begin(config: RecognizerConfig) -> None:
    """Ignore Ctrl-C, which the parent handles, and end with the parent."""
    _Child.config = config
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_parent()
    os.nice(_NICENESS)


def _recognize(samples: NDArray[np.int16], phrases: tuple[str, ...], language: str) -> Recognition | None:
    if _Child.engine is None:
        # Not in the initializer: an exception there breaks the pool and is lost.
        _Child.engine = _Child.config.make()
    return _Child.engine.recognize(samples, phrases, language)
