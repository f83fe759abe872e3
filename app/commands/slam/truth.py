"""References for a trajectory: relations between scans, and a log with corrected poses."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from app.base.errors import ConfigError
from app.base.plain_file import read_plain
from app.commands.slam.sweeps import sweep_key
from app.messages import LaserScan, Odometry

#: A list of relations is no longer.
_MOST_BYTES = 100_000_000


@dataclass(frozen=True, slots=True, eq=False)
class Relations:
    """``first`` and ``second`` (R,): scans by number, or by time (s) if ``timed``; ``measured`` (R, 3) m, rad."""

    path: Path
    first: NDArray[np.float64]
    second: NDArray[np.float64]
    measured: NDArray[np.float64]
    timed: bool


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """Corrected poses (K, 3) of sweeps, by their time (s), if ``timed``, and by their readings."""

    path: Path
    stamps: NDArray[np.float64]
    keys: list[bytes]
    poses: NDArray[np.float64]
    timed: bool = True


def read_relations(path: Path) -> Relations:
    """The relations in ``path``. Raises ConfigError with the line."""
    try:
        text = read_plain(path, _MOST_BYTES).decode("utf-8")
    except OSError as failure:
        raise ConfigError(f"--relations: {path} cannot be read: {failure.strerror or failure}") from None
    except UnicodeDecodeError:
        raise ConfigError(f"--relations: {path} cannot be read: it is no text in UTF-8") from None
    rows: list[list[float]] = []
    for line, words in enumerate((line.split() for line in text.splitlines()), 1):
        if not words or words[0].startswith("#"):
            continue
        try:
            row = [float(word) for word in words]
        except ValueError:
            raise ConfigError("a relation is numbers alone", str(path), line) from None
        if len(row) < 5 or (rows and len(row) != len(rows[0])) or not np.isfinite(row).all():
            raise ConfigError("a relation is `i j dx dy dtheta` or `t1 t2 x y z roll pitch yaw`", str(path), line)
        rows.append(row)
    if not rows:
        raise ConfigError(f"--relations: {path} has no relation")
    table = np.array(rows)
    timed = table.shape[1] >= 8
    measured = table[:, [2, 3, 7]] if timed else table[:, 2:5]
    return Relations(path, table[:, 0], table[:, 1], measured, timed)


def read_reference(path: Path) -> Reference:
    """The corrected poses of ``path``: that of each scan's line. Raises ConfigError."""
    from app.logs.log import LogError
    from app.logs.open import open_log

    stamps: list[float] = []
    keys: list[bytes] = []
    poses: list[tuple[float, float, float]] = []
    try:
        log = open_log(path)
        last: Odometry | None = None
        for logged in log.messages(channels=("scan", "odometry")):
            if isinstance(logged.message, Odometry):
                last = logged.message
            elif isinstance(logged.message, LaserScan) and last is not None and last.stamp == logged.message.stamp:
                stamps.append(logged.message.stamp)
                keys.append(sweep_key(logged.message.ranges))
                poses.append((last.X_OB.x, last.X_OB.y, last.X_OB.theta))
        log.close()
    except LogError as failure:
        raise ConfigError(f"--reference: {failure}") from None
    if len(poses) < 3:
        raise ConfigError(f"--reference: {path} has {len(poses)} scans with a pose; at least 3 are needed")
    return Reference(path, np.array(stamps), keys, np.array(poses), log.info.timed)
