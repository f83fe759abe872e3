"""The pose graph corrected in a process of its own: GTSAM holds the interpreter's lock, and a robot is driving."""

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

#: The driving itself comes first.
_NICENESS = 5


class OptimizerProcess:
    """``Slam(optimize=OptimizerProcess())``: the same answers as :func:`optimized`. It starts when first needed.

    Called by one thread at a time, which waits meanwhile without the interpreter's lock; :meth:`close` ends it.
    """

    def __init__(self, least_edges: int = 0) -> None:
        """Graphs of fewer than ``least_edges`` are solved here: that takes less than the handing over."""
        self._least_edges = least_edges
        self._pool: ProcessPoolExecutor | None = None

    def __call__(self, graph: GraphArrays) -> NDArray[np.float64]:
        """The corrected poses (N, 3). A process that was killed is replaced; the second time, BrokenProcessPool."""
        if len(graph.ends) < self._least_edges:
            return optimized(graph)
        try:
            return self._submitted(graph).result()
        except BrokenProcessPool:
            self.close()
            return self._submitted(graph).result()

    def close(self) -> None:
        """End the process, if there is one."""
        if self._pool is not None:
            self._pool.shutdown(wait=True, cancel_futures=True)
            self._pool = None

    def _submitted(self, graph: GraphArrays) -> Future[NDArray[np.float64]]:
        if self._pool is None:
            # Not forked: threads of this process may hold locks just now.
            context = multiprocessing.get_context("spawn")
            self._pool = ProcessPoolExecutor(1, mp_context=context, initializer=_begin)
        with safe_path():  # the first one starts it
            return self._pool.submit(optimized, graph)


def _begin() -> None:
    """Leave Ctrl-C to the parent, and do not outlive it."""
    import gtsam  # noqa: F401

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_parent()
    os.nice(_NICENESS)
