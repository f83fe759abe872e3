"""The graph corrected in another process: the same answer, also after that process was killed."""

from __future__ import annotations

import os
import signal

import numpy as np
import pytest

from app.base.geometry import Pose2
from app.modules.perception.slam.information import diagonal
from app.modules.perception.slam.optimizer import OptimizerProcess
from app.modules.perception.slam.pose_graph import graph_arrays, optimized
from app.modules.perception.slam.types import Edge


@pytest.mark.slow
def test_another_process_gives_the_same_answer_and_may_die() -> None:
    poses = {k: Pose2(k + 0.1 * (k % 2), 0.0, 0.0) for k in range(5)}
    edges = [Edge(k, k + 1, Pose2(1.0, 0.0, 0.0), diagonal(1e4, 1e4, 1e5), loop=False) for k in range(4)]
    graph = graph_arrays(poses, edges)
    optimizer = OptimizerProcess()
    try:
        np.testing.assert_allclose(optimizer(graph), optimized(graph), atol=1e-12)
        assert optimizer._pool is not None
        (process,) = optimizer._pool._processes
        os.kill(process, signal.SIGKILL)
        np.testing.assert_allclose(optimizer(graph)[:, 0], range(5), atol=1e-3)
    finally:
        optimizer.close()
