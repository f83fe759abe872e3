"""Offline mapping of a whole log at full CPU speed: every scan in order, every loop searched at once."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.modules.perception.slam.loop_closure import LoopJob
from app.modules.perception.slam.mapper import Slam
from app.modules.perception.slam.relations import Poses
from app.modules.perception.slam.scans import BeamGeometry
from app.modules.perception.slam.settings import SlamSettings


@dataclass(frozen=True, slots=True, eq=False)
class Sweep:
    """One sweep of a log: ``ranges`` (N,) m of ``beams`` from ``stamp`` (s) on, with the body at ``X_OB``."""

    stamp: float
    ranges: NDArray[np.floating]
    beams: BeamGeometry
    X_OB: Pose2
    twist: tuple[float, float, float] = (0.0, 0.0, 0.0)
    sweep_s: float = 0.0


@dataclass(frozen=True, slots=True)
class _Row:
    number: int
    stamp: float
    keyframe: int
    X_KB: Pose2
    inliers: float
    matched: bool
    sigmas: tuple[float, float, float]
    off: tuple[float, float]


@dataclass(slots=True, eq=False)
class MappedLog:
    """Result of mapping a log. CPU times (s): ``scan_s`` per used scan, ``jobs_s`` of loop closure, ``cpu_s`` in
    total."""

    slam: Slam
    scans: int = 0
    odometry: list[Pose2] = field(default_factory=list)
    rows: list[_Row] = field(default_factory=list)
    scan_s: list[float] = field(default_factory=list)
    replaced: dict[int, tuple[int, Pose2]] = field(default_factory=dict)
    jobs_s: float = 0.0
    cpu_s: float = 0.0

    def numbers(self) -> NDArray[np.int64]:
        """Indices of the used scans (K,), from 0."""
        return np.array([row.number for row in self.rows], dtype=np.int64)

    def stamps(self) -> NDArray[np.float64]:
        """(K,) s of the used scans."""
        return np.array([row.stamp for row in self.rows])

    def poses(self) -> Poses:
        """(K, 3) x, y, theta on the final map of the used scans."""
        found = [self._pose(row.keyframe) @ row.X_KB for row in self.rows]
        return np.array([(p.x, p.y, p.theta) for p in found]).reshape(-1, 3)

    def kept(self, keyframe: int) -> tuple[int, Pose2]:
        """The remaining keyframe to which ``keyframe``, possibly removed, is attached, and its pose in it."""
        chain = Pose2()
        while keyframe in self.replaced:
            keyframe, X_ab = self.replaced[keyframe]
            chain = X_ab @ chain
        return keyframe, chain

    def _pose(self, keyframe: int) -> Pose2:
        kept, X_ab = self.kept(keyframe)
        return self.slam.pose(kept) @ X_ab

    def odometry_poses(self) -> Poses:
        """(N, 3) of all scans of the log, by odometry."""
        return np.array([(p.x, p.y, p.theta) for p in self.odometry]).reshape(-1, 3)

    def sigmas(self) -> NDArray[np.float64]:
        """(K, 3) standard deviations of x, y (m) and theta (rad) of the used scans, on the local map at the time."""
        return np.array([row.sigmas for row in self.rows]).reshape(-1, 3)

    def unmatched(self) -> int:
        """Number of scans that did not fit the map, bridged by odometry alone."""
        return sum(not row.matched for row in self.rows)


def mapped(
    sweeps: Iterable[Sweep],
    settings: SlamSettings | None = None,
    *,
    phi: int = 1,
    on_progress: Callable[[int, str], None] = lambda scans, text: None,
) -> MappedLog:
    """Map ``sweeps``, using the first of every ``phi``. ``on_progress(scans, text)`` reports progress."""
    log = MappedLog(Slam(settings))
    began = time.process_time()
    for sweep in sweeps:
        number = log.scans
        log.scans += 1
        log.odometry.append(sweep.X_OB)
        if number % phi:
            continue
        before = time.thread_time()
        match = log.slam.add(
            sweep.stamp, sweep.ranges, beams=sweep.beams, X_OB=sweep.X_OB, twist=sweep.twist, sweep_s=sweep.sweep_s
        )
        log.scan_s.append(time.thread_time() - before)
        if match.keyframe < 0:
            continue  # no reading so far: the map begins later
        x, y, theta = np.sqrt(np.diagonal(match.covariance))
        log.rows.append(
            _Row(
                number,
                sweep.stamp,
                keyframe=match.keyframe,
                X_KB=match.X_KB,
                inliers=match.inliers,
                matched=match.matched,
                sigmas=(float(x), float(y), float(theta)),
                off=match.off,
            )
        )
        _do(log, log.slam.pending())
        on_progress(log.scans, f"{len(log.slam.keyframes)} keyframes, {log.slam.loops} loops")
    _do(log, log.slam.settling())
    log.cpu_s = time.process_time() - began
    return log


def _do(log: MappedLog, job: LoopJob | None) -> None:
    if job is None:
        return
    before = time.process_time()
    outcome = job.run()
    log.jobs_s += time.process_time() - before
    log.slam.take(outcome)
    if outcome.pruned is not None:
        log.replaced.update(outcome.pruned.replaced)
