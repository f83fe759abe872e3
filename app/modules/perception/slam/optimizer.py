"""Correction of the pose graph in a separate process: GTSAM holds the interpreter's lock, and a moving robot must not
wait."""

from __future__ import annotations

import multiprocessing
import os
import signal
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool

import numpy as np
from numpy.typing import NDArray

from app.base.child_processes import end_with_parent, safe_path
from app.modules.perception.slam.pose_graph import GraphArrays, optimized

#: Lower priority than the control cycle.
_NICENESS = 5


class OptimizerProcess:
    """``Slam(optimize=OptimizerProcess())``: the same results as :func:`optimized`. The process starts on first use.

    Called by one thread at a time, which waits without the interpreter's lock; :meth:`close` ends the process.
    """

    def __init__(self, least_edges: int = 0) -> None:
        """Graphs of fewer than ``least_edges`` are solved in this process: faster than the transfer."""
        self._least_edges = least_edges
        self._pool: ProcessPoolExecutor | None = None

    def __call__(self, graph: GraphArrays) -> NDArray[np.float64]:
        """The corrected poses (N, 3). A killed process is replaced; the second time, raises BrokenProcessPool."""
        if len(graph.ends) < self._least_edges:
            return optimized(graph)
        try:
            return self._submitted(graph).result()
        except BrokenProcessPool:
            self.close()
            return self._submitted(graph).result()

    def close(self) -> None:
        if self._pool is not None:
            self._pool.shutdown(wait=True, cancel_futures=True)
            self._pool = None

    def _submitted(self, graph: GraphArrays) -> Future[NDArray[np.float64]]:
        if self._pool is None:
            # Spawned, not forked: threads of this process may hold locks.
            context = multiprocessing.get_context("spawn")
            self._pool = ProcessPoolExecutor(1, mp_context=context, initializer=_begin)
        with safe_path():  # the first call starts the process
            return self._pool.submit(optimized, graph)


def _begin() -> None:
    """Ignore Ctrl-C, which the parent handles, and end with the parent."""
    import gtsam  # noqa: F401

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_parent()
    os.nice(_NICENESS)
