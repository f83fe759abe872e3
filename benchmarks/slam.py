"""Mapping the public laser logs: how true, how fast, and from how few scans.

*relation error* is that of Kuemmerle et al. (2009), on relations by checked pairwise scan ICP. φ on the Intel log
counts from 5 scans a second; scans between those taken get poses from odometry on both sides. The peer is openslam's
GMapping with ROS's settings (30 particles), built and run on the same logs and relations on another day; on Fr079 it
doubles the map six times of six. *720 rays* are Fr079's scans with a ray between each two. *Corridors* are 1.7 km,
synthetic (``corridors.py``), with odometry of the given scale of each metre and radian: *revisits* are pairs of scans
within 2 m of each other, with 500 scans or more between them. *Off the reference* is the trajectory's root mean square
distance from poses by Freiburg's GMapping; *walls off a right angle* and *astray* show which of both is the truer
(``walls.py``): the peer is that reference. The rest needs the reference data (HBBA_REFERENCE_DATA).
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.commands.slam.sweeps import sweep_key
from app.commands.slam.truth import read_reference
from app.modules.perception.slam.offline_mapping import MappedLog, Sweep, mapped
from app.modules.perception.slam.relations import RelationErrors, between, filled_in, relation_errors, trajectory_error
from app.modules.perception.slam.scans import BeamGeometry
from benchmarks.corridors import ANGLES, drive
from benchmarks.report import Row, benchmark_main, row
from benchmarks.walls import squareness, wall_pieces

DATA = Path(os.environ.get("HBBA_REFERENCE_DATA") or Path(__file__).resolve().parents[2] / "shared" / "data") / "slam"
REFERENCES = {"intel": "intel-corrected.log.gz", "fr079": "freiburg-079-corrected.log.gz"}
NAMES = {"intel": "Intel", "fr079": "Fr079"}
PEER = "GMapping"
#: Mean relation error (m) and CPU time (s) of the peer.
PEERS = {"intel": (0.0183, 69.0), "fr079": (None, 75.0)}
PHIS = (2, 4, 8, 16, 32)
RANGE_MAX_M = 80.0
#: Seed, and the values of odometry for a metre and a radian.
CORRIDORS = ((1, 1.02, 1.03), (2, 0.96, 1.06))
REVISIT_M, REVISIT_SCANS = 2.0, 500


def measure(quick: bool) -> list[Row]:
    """All rows; ``quick`` leaves out the sweep of φ and the corridors."""
    corridors = [] if quick else [made for case in CORRIDORS for made in _corridor_rows(*case)]
    if not (DATA / "intel.npz").is_file():
        print(f"the public laser logs are not there: {DATA} (set HBBA_REFERENCE_DATA)", file=sys.stderr)
        return corridors
    rows = corridors
    for name in NAMES:
        log = mapped(_sweeps(name))
        peer_m, peer_s = PEERS[name]
        errors = _errors(name, log)
        peer = {"peer_name": PEER}
        rows += [
            _row(name, "relation error", "m", errors.mean_m, None if peer_m is None else [peer_m], **peer),
            _row(name, "relation error, rotation", "°", errors.mean_deg),
            _row(name, "gross errors", "relations", errors.gross),
            _row(name, "whole log", "s CPU", log.cpu_s, [peer_s], **peer),
            *_scan_rows(NAMES[name], log),
            *_reference_rows(name, log),
        ]
    rows += _scan_rows("720 rays", mapped(_sweeps("fr079", between=True)))
    for phi in () if quick else PHIS:
        log = mapped(_sweeps("intel"), phi=phi)
        errors = _errors("intel", log)
        case = f"Intel, φ = {phi}"
        rows += [
            row("slam", case, "relation error", "m", [errors.mean_m]),
            row("slam", case, "gross errors", "relations", [errors.gross]),
            row("slam", case, "believed (mean σ)", "m", [float(np.hypot(*log.sigmas()[:, :2].T).mean())]),
        ]
    return rows


def _corridor_rows(seed: int, scale: float, turn: float) -> list[Row]:
    case = f"corridors, odometry × {scale}, turns × {turn}"
    made = drive(seed, scale, turn)
    beams = BeamGeometry(ANGLES, 0.05, RANGE_MAX_M)
    sweeps = (
        Sweep(0.3 * number, scan, beams, Pose2(*(float(v) for v in pose)))
        for number, (scan, pose) in enumerate(zip(made.ranges, made.odometry, strict=True))
    )
    log = mapped(sweeps)
    poses = filled_in(log.numbers(), log.poses(), log.odometry_poses())
    first, second = np.random.default_rng(0).integers(0, len(poses), (2, 400_000))
    off = np.hypot(*(made.truth[first, :2] - made.truth[second, :2]).T)
    revisits = (off < REVISIT_M) & (np.abs(first - second) > REVISIT_SCANS)
    first, second = first[revisits], second[revisits]
    errors = relation_errors(poses[first], poses[second], between(made.truth[first], made.truth[second]))
    return [
        row("slam", case, "off the truth, rms", "m", [trajectory_error(poses, made.truth)[1]]),
        row("slam", case, "revisits, mean", "m", [errors.mean_m]),
        row("slam", case, "revisits, greatest", "m", [errors.max_m]),
        row("slam", case, f"gross of {errors.relations} revisits", "relations", [errors.gross]),
        row("slam", case, "whole log", "s CPU", [log.cpu_s]),
    ]


def _row(name: str, metric: str, unit: str, ours: float, peer: list[float] | None = None, peer_name: str = "") -> Row:
    return row("slam", NAMES[name], metric, unit, [ours], peer, peer_name if peer else "")


def _scan_rows(case: str, log: MappedLog) -> list[Row]:
    ms = 1e3 * np.array(log.scan_s)
    return [
        row("slam", case, "a scan, mean", "ms CPU", [float(ms.mean())]),
        row("slam", case, "a scan, p99", "ms CPU", [float(np.percentile(ms, 99))]),
    ]


def _reference_rows(name: str, log: MappedLog) -> list[Row]:
    """How far both are apart, and how square the building is by each."""
    reference = read_reference(DATA / REFERENCES[name])
    rows = {sweep_key(sweep.ranges): number for number, sweep in enumerate(_sweeps(name))}
    taken = {int(number): row for row, number in enumerate(log.numbers())}
    pairs = [(rows[key], row) for row, key in enumerate(reference.keys) if rows.get(key) in taken]
    ours = log.poses()[[taken[number] for number, _ in pairs]]
    theirs = reference.poses[[row for _, row in pairs]]
    sweeps = list(_sweeps(name))
    pieces = [wall_pieces(sweeps[number].ranges, sweeps[number].beams.angles) for number, _ in pairs]
    square, peer = squareness(ours[:, 2], pieces), squareness(theirs[:, 2], pieces)
    return [
        _row(name, "off the reference, rms", "m", trajectory_error(ours, theirs)[1]),
        _row(name, "walls off a right angle", "°", square.skew_deg, [peer.skew_deg], "the reference"),
        _row(name, "walls astray, median", "°", square.astray_deg, [peer.astray_deg], "the reference"),
    ]


def _sweeps(name: str, *, between: bool = False) -> Iterator[Sweep]:
    """The sweeps of a log; ``between``: with a ray between each two, of their mean range where they are alike."""
    with np.load(DATA / f"{name}.npz") as archive:
        ranges, poses = archive["ranges"], archive["pose"]
    count = ranges.shape[1]
    angles: NDArray[np.float64] = np.linspace(-np.pi / 2, np.pi / 2, count, endpoint=False)
    if between:
        after = np.concatenate((ranges[:, 1:], ranges[:, -1:]), axis=1)
        middle = np.where(np.abs(after - ranges) < 0.2, (ranges + after) / 2, ranges)
        ranges = np.stack((ranges, middle), axis=2).reshape(len(ranges), 2 * count)
        angles = np.linspace(-np.pi / 2, np.pi / 2, 2 * count, endpoint=False)
    beams = BeamGeometry(angles, 0.05, RANGE_MAX_M)
    for number, (scan, pose) in enumerate(zip(ranges, poses, strict=True)):
        yield Sweep(0.2 * number, scan, beams, Pose2(*(float(v) for v in pose)))


def _errors(name: str, log: MappedLog) -> RelationErrors:
    relations = np.loadtxt(DATA / f"{name}.relations.txt")
    poses = filled_in(log.numbers(), log.poses(), log.odometry_poses())
    first, second = relations[:, 0].astype(int), relations[:, 1].astype(int)
    return relation_errors(poses[first], poses[second], relations[:, 2:5])


if __name__ == "__main__":
    sys.exit(benchmark_main(__doc__, measure))
