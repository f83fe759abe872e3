"""The sweeps of any log: ranges, geometry and odometry at each sweep's own time."""

from __future__ import annotations

import argparse
import hashlib
import math
import zipfile
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from app.base.errors import ConfigError
from app.base.geometry import Pose2
from app.base.npz_source import read_arrays
from app.base.pose_buffer import PoseBuffer
from app.commands.arguments import find_log
from app.logs.stamps import JITTER_S, Onward
from app.messages import LaserScan, Odometry

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from app.logs.log import Log
    from app.modules.perception.slam.offline_mapping import Sweep

_RANGE_MIN_M = 0.05
_RANGE_MAX_M = 80.0
#: A greatest reading that so large a share of all have (at least) is the laser's word for "nothing".
_CODE_SHARE = 1e-3
#: A scan waits for odometry no longer than this (s).
_WAIT_S = 2.0


@dataclass(slots=True, eq=False)
class SweepSource:
    """``sweeps`` are read as they are asked for; ``seen`` keeps their ranges where a reference needs them."""

    path: Path
    count: int
    sweeps: Iterator[Sweep]
    notes: list[str] = field(default_factory=list)
    #: Of each sweep so far: a key of its readings, by which the same sweep is known in another log.
    keys: list[bytes] = field(default_factory=list)
    timed: bool = True


def sweep_key(ranges: NDArray[np.floating[Any]]) -> bytes:
    """By which a sweep is known again in another file: its readings below 80 m, to a centimetre."""
    near = np.where(np.asarray(ranges, dtype=np.float64) < _RANGE_MAX_M, ranges, 0.0)
    readings = np.round(np.nan_to_num(near) * 100.0).astype(np.int32)
    return hashlib.blake2b(readings.tobytes(), digest_size=16).digest()


def open_sweeps(args: argparse.Namespace) -> SweepSource:
    """The sweeps of ``args.log``. Raises ConfigError for what cannot be read."""
    path = find_log(args.log)
    if path.is_file() and zipfile.is_zipfile(path):
        return _arrays(path, args)
    for option in ("angle_min", "angle_step", "range_max", "laser_x"):
        if getattr(args, option) is not None:
            raise ConfigError(f"--{option.replace('_', '-')} is for .npz; {path} says it itself")
    from app.logs.importers.remap import load_remap
    from app.logs.log import LogError
    from app.logs.open import ACCEPTED, open_log

    try:
        log = open_log(path, None if args.remap is None else load_remap(args.remap))
    except LogError as failure:
        also = ", and arrays (.npz)" if str(failure).endswith(ACCEPTED) else ""
        raise ConfigError(f"{failure}{also}") from None
    channels = log.info.channels
    types = {name: channel.message_type for name, channel in channels.items()}
    try:
        scans = _channel(path, types, wanted=LaserScan, named=args.scans, option="--scans", usual="scan")
        odometry = _channel(path, types, wanted=Odometry, named=args.odometry, option="--odometry", usual="odometry")
    except ConfigError as lack:
        log.close()
        lines = [f"{what}: {why}" for what, why in log.info.ignored.items() if not what.startswith("/")]
        raise ConfigError(f"{lack}; not read are {'; '.join(lines)}" if lines else str(lack)) from None
    # Topics that are of no use here go without saying; a log that ends too soon does not.
    unread = [f"not read: {what}: {why}" for what, why in log.info.ignored.items() if not what.startswith("/")]
    notes = [*log.info.notes, *unread]
    source = SweepSource(path, channels[scans].count, iter(()), notes, timed=log.info.timed)
    source.sweeps = _of_log(source, log, scans, odometry)
    return source


def _channel(
    path: Path, types: dict[str, type[Any]], wanted: type[Any], named: str | None, option: str, usual: str
) -> str:
    fitting = [name for name, kind in types.items() if kind is wanted]
    if named is not None:
        if named not in fitting:
            raise ConfigError(f"{option}: {path} has no such channel {named!r}; it has {', '.join(fitting) or 'none'}")
        return named
    if usual in fitting:
        return usual
    if len(fitting) == 1:
        return fitting[0]
    if not fitting:
        what = "laser scans" if wanted is LaserScan else "odometry"
        raise ConfigError(f"{path}: has no {what} that can be read; mapping needs scans and odometry")
    raise ConfigError(f"{path}: has several channels; choose with {option}: {', '.join(fitting)}")


def _of_log(source: SweepSource, log: Log, scans: str, odometry: str) -> Iterator[Sweep]:
    """Raises ConfigError where the log is damaged."""
    from app.logs.log import LogError
    from app.modules.perception.slam.beam_cache import BeamCache
    from app.modules.perception.slam.offline_mapping import Sweep

    poses = PoseBuffer(span_s=10.0)
    twist = (0.0, 0.0, 0.0)
    newest = -math.inf
    waiting: deque[LaserScan] = deque()
    beams = BeamCache()
    order = {scans: Onward(), odometry: Onward()}
    readings = _Readings()
    poseless = 0

    def ready(scan: LaserScan) -> Iterator[Sweep]:
        nonlocal poseless
        if (X_OB := poses.at(scan.stamp)) is None:
            poseless += 1
            return
        source.keys.append(sweep_key(scan.ranges))
        readings.count(scan.ranges, scan.range_min)
        yield Sweep(scan.stamp, scan.ranges, beams=beams(scan), X_OB=X_OB, twist=twist, sweep_s=scan.duration_s)

    try:
        for logged in log.messages(channels=(scans, odometry)):
            message = logged.message
            stamp = order[logged.channel].next(message.stamp)
            if isinstance(message, Odometry):
                # Odometry that goes back in time is skipped; its neighbours give the robot's pose.
                poses.add(message.stamp, message.X_OB)
                twist = (message.linear_mps, message.angular_radps, message.lateral_mps)
                newest = max(newest, message.stamp)
            else:
                waiting.append(message if stamp == message.stamp else replace(message, stamp=stamp))
            while waiting and (waiting[0].stamp <= newest or logged.at - waiting[0].stamp > _WAIT_S):
                yield from ready(waiting.popleft())
        for scan in waiting:
            yield from ready(scan)
    except LogError as failure:
        raise ConfigError(str(failure)) from None
    finally:
        log.close()
    source.notes += [_went_back(channel, stamps) for channel, stamps in order.items() if stamps.most_back_s > JITTER_S]
    source.notes += readings.notes()
    if poseless:
        source.notes.append(f"{poseless} scans are left out, and not numbered: no odometry is within 0.1 s of them")


def _went_back(what: str, stamps: Onward) -> str:
    return (
        f"{what}: stamps that go back: {stamps.back} (the first is number {stamps.first_back}; by "
        f"{stamps.most_back_s:.2f} s at most): the log's order is kept, each such stamp is the one before plus a step"
    )


class _Readings:
    """Counts readings that are no distance."""

    def __init__(self) -> None:
        self._all = self._none = 0

    def count(self, ranges: NDArray[np.floating[Any]], range_min: float) -> None:
        """Count those of one sweep or several (m)."""
        self._all += ranges.size
        self._none += ranges.size - int(np.count_nonzero(ranges >= range_min))

    def notes(self) -> list[str]:
        """Notes about the readings."""
        if not self._none:
            return []
        share = 100 * self._none / self._all
        return [
            f"{self._none} readings ({share:.1f} %) are no distance (no number, or too near): nothing is known there"
        ]


# --- Arrays ----------------------------------------------------------------------------------------------------------


def _arrays(path: Path, args: argparse.Namespace) -> SweepSource:
    ranges, poses, stamps = _loaded(path)
    from app.logs.importers.carmen_clock import ASSUMED_PERIOD_S
    from app.logs.importers.carmen_lines import lms_angles
    from app.logs.importers.range_limit import FarEnd
    from app.modules.perception.slam.offline_mapping import Sweep
    from app.modules.perception.slam.scans import BeamGeometry

    first, step = lms_angles(ranges.shape[1])
    if args.angle_min is not None:
        first = math.radians(args.angle_min)
    if args.angle_step is not None:
        step = math.radians(args.angle_step)
    far = FarEnd()
    far.add(ranges)
    pile = far.limit()
    limit = args.range_max if args.range_max is not None else min(_limit(ranges), pile or math.inf)
    beams = BeamGeometry(
        first + step * np.arange(ranges.shape[1], dtype=np.float64), _RANGE_MIN_M, limit, Pose2(args.laser_x or 0.0)
    )
    timed = stamps is not None
    times = np.arange(len(ranges)) * ASSUMED_PERIOD_S if stamps is None else stamps
    last = math.degrees(beams.angles[-1])
    notes = [f"{ranges.shape[1]} rays from {math.degrees(first):g}° to {last:g}°, up to {limit:g} m"]
    if not timed:
        notes.append(f"no times: {1 / ASSUMED_PERIOD_S:g} scans a second are assumed")
    if args.range_max is None and limit == pile:
        notes.append(f"readings from {limit:.1f} m on are the laser's for nothing seen: they pile up there")
    order = Onward()
    times = np.array([order.next(time) for time in times.tolist()])
    if order.most_back_s > JITTER_S:
        notes.append(_went_back("scan", order))
    readings = _Readings()
    readings.count(ranges, _RANGE_MIN_M)
    notes += readings.notes()
    source = SweepSource(path, len(ranges), iter(()), notes, timed=timed)

    def sweeps() -> Iterator[Sweep]:
        for row, pose, stamp in zip(ranges, poses, times, strict=True):
            source.keys.append(sweep_key(row))
            yield Sweep(float(stamp), row, beams, Pose2(*(float(v) for v in pose)))

    source.sweeps = sweeps()
    return source


def _loaded(path: Path) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any] | None]:
    arrays = read_arrays(path, "the log")
    missing = [name for name in ("ranges", "pose") if name not in arrays]
    if missing:
        raise ConfigError(
            f"{path}: has no array {' and no array '.join(missing)}; it has {', '.join(arrays) or 'none'}"
        )
    ranges, poses = arrays["ranges"], arrays["pose"]
    numbers = all(array.dtype.kind in "iuf" for array in (ranges, poses))
    if not numbers or ranges.ndim != 2 or min(ranges.shape) < 1 or poses.shape != (len(ranges), 3):
        raise ConfigError(
            f"{path}: `ranges` must be (N, B) numbers and `pose` (N, 3), not {ranges.shape} and {poses.shape}"
        )
    if not np.isfinite(poses).all():
        raise ConfigError(f"{path}: row {int(np.argmin(np.isfinite(poses).all(axis=1)))} of `pose` is no finite pose")
    for name in ("stamp", "time", "timestamp"):
        if name in arrays and arrays[name].shape == (len(ranges),):
            stamps = arrays[name]
            if stamps.dtype.kind not in "iuf" or not np.isfinite(stamps).all():
                raise ConfigError(f"{path}: `{name}` must be times in s, every one a finite number")
            return ranges, poses, stamps
    return ranges, poses, None


def _limit(ranges: NDArray[Any]) -> float:
    """The range from which a reading means "nothing seen": 80 m, or just below the value that too many readings
    share."""
    finite = ranges[np.isfinite(ranges)]
    if not finite.size:
        return _RANGE_MAX_M
    greatest = float(finite.max())
    share = float((finite > greatest - 0.005).mean())
    return min(_RANGE_MAX_M, greatest - 0.01) if share > _CODE_SHARE else _RANGE_MAX_M
