"""Figures of what every module computes from the reference log, and their comparison with reference values.

``lab.mcap`` beside this file is a recorded minute of the simulated lab, ``lab.yaml`` the figures of
the modules of ``config/lab.yaml`` on it, with tolerances.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from app.base import paths
from app.logs.open import open_log
from app.logs.replay.headless import ReplayWatch, run_headless
from app.logs.replay.options import ReplayOptions
from app.logs.replay.report import ReplaySummary
from app.messages import EncodedImage, Exploitation, Faces, Landmarks, PointCloud, QRCodes

FOLDER = Path(__file__).parent
LOG = FOLDER / "lab.mcap"
VALUES = FOLDER / "lab.yaml"

Values = dict[str, Any]

_HEADER = """\
# Figures of the modules on lab.mcap: written by `make references`, compared by tests/logs/replay/test_references.py.
# A value may differ by the tolerance of the longest name here that its own begins with, absolutely or, where it is
# written in per cent, relative to the value here. All others are equal, or something has changed.
"""

#: By the beginning of a value's name. Decoders and libraries differ a little from build to build; attention may not.
TOLERANCES: Mapping[str, float | str] = {
    "channels.qr_codes": 0,
    "channels.landmarks": 2,
    "qr_codes": 2,
    "landmarks": 0.02,
    "landmarks.sigma": 0.005,
    "landmarks.sightings": 2,
    "clouds.points": "1 %",
    "clouds.mean": 0.01,
    "clouds.spread": 0.01,
    "pictures.bytes": "3 %",
    "driving.distance": 0.01,
    "driving.turned": 0.02,
}


def measure(log_file: Path = LOG, config: Path | None = None) -> Values:
    """Replay ``log_file`` through the program of ``config`` (default: the lab) and boil down what came of it.

    Raises LogError, LinkFailed, ConfigError.
    """
    log = open_log(log_file)
    figures = _Figures()
    options = ReplayOptions(config=config or paths.config_dir() / "lab.yaml")
    try:
        report = run_headless(log, options, watch=ReplayWatch(message=figures.take), digests=False)
    finally:
        log.close()
    return {"channels": _counts(report), **figures.values(), "intentions": _intentions(report)}


def compare(measured: Values, reference: Mapping[str, Any]) -> list[str]:
    """Differences from ``reference`` beyond its ``tolerances``, one sentence each."""
    tolerances: Mapping[str, float | str] = reference.get("tolerances", {})
    now = flat(measured)
    then = flat({name: value for name, value in reference.items() if name != "tolerances"})
    differences = []
    for name in sorted({*now, *then}):
        if name not in then:
            differences.append(f"{name} is new: {now[name]}")
        elif name not in now:
            differences.append(f"{name} is gone: it was {then[name]}")
        elif not _alike(now[name], then[name], _tolerance(name, tolerances)):
            differences.append(f"{name} is {now[name]}, it was {then[name]}")
    return differences


def load_values(path: Path = VALUES) -> dict[str, Any]:
    """The reference values. Raises OSError."""
    values: dict[str, Any] = yaml.safe_load(path.read_text(encoding="utf-8"))
    return values


def write_values(path: Path, measured: Values) -> None:
    """Write ``measured`` as the reference from now on."""
    text = yaml.safe_dump(
        {"tolerances": dict(TOLERANCES), **measured},
        sort_keys=False,
        allow_unicode=True,
        width=110,
        default_flow_style=None,
    )
    path.write_text(_HEADER + text, encoding="utf-8")


def flat(values: Mapping[str, Any]) -> dict[str, Any]:
    """``{"a": {"b": [1, 2]}}`` as ``{"a.b.0": 1, "a.b.1": 2}``."""
    found: dict[str, Any] = {}

    def walk(name: str, value: Any) -> None:
        if isinstance(value, Mapping):
            for key, item in value.items():
                walk(f"{name}.{key}" if name else str(key), item)
        elif isinstance(value, list | tuple):
            for number, item in enumerate(value):
                walk(f"{name}.{number}", item)
        else:
            found[name] = value

    walk("", values)
    return found


def _tolerance(name: str, tolerances: Mapping[str, float | str]) -> float | str:
    fitting = [beginning for beginning in tolerances if name == beginning or name.startswith(f"{beginning}.")]
    return tolerances[max(fitting, key=len)] if fitting else 0


def _alike(now: Any, then: Any, tolerance: float | str) -> bool:
    numbers = all(isinstance(value, int | float) and not isinstance(value, bool) for value in (now, then))
    if not numbers:
        return bool(now == then)
    allowed = abs(then) * float(tolerance.rstrip(" %")) / 100 if isinstance(tolerance, str) else tolerance
    return bool(abs(now - then) <= allowed + 1e-9)


def _counts(report: ReplaySummary) -> dict[str, int]:
    """Messages of each channel that had any; a module more in the program, at rest, changes none of them."""
    return {
        name: channel.messages
        for name, channel in report.channels.items()
        if channel.messages and name != "module_states"
    }


def _intentions(report: ReplaySummary) -> list[dict[str, Any]]:
    """Stamp, selected and fulfilled names, Ω, and φ of every open filter."""
    return [
        {
            "at": round(line.stamp - report.begin, 3),
            "strategies": list(line.strategies),
            "fulfilled": list(line.fulfilled),
            "omega": line.omega,
            "phi": {name: int(phi) for name, phi in line.divisors.items() if not math.isinf(phi)},
        }
        for line in report.intentions
    ]


@dataclass
class _Figures:
    """Sums over the messages of a replay."""

    codes: Counter[str] = field(default_factory=Counter)
    landmarks: Landmarks | None = None
    faces: int = 0
    points: list[int] = field(default_factory=list)
    means: list[NDArray[np.float64]] = field(default_factory=list)
    spreads: list[NDArray[np.float64]] = field(default_factory=list)
    pictures: list[EncodedImage] = field(default_factory=list)
    drivers: Counter[str] = field(default_factory=Counter)
    distance_m: float = 0.0
    turned_rad: float = 0.0
    _last: Exploitation | None = None

    def take(self, _: str, message: Any) -> None:
        """Add one message of any channel."""
        known: dict[type[Any], Callable[[Any], None]] = {
            QRCodes: self._codes,
            Landmarks: self._landmarks,
            Faces: self._faces,
            PointCloud: self._cloud,
            EncodedImage: self.pictures.append,
            Exploitation: self._exploitation,
        }
        if handler := known.get(type(message)):
            handler(message)

    def values(self) -> Values:
        """The figures as the file holds them; metres and radians to the millimetre and milliradian."""
        landmarks = self.landmarks.landmarks if self.landmarks is not None else ()
        return {
            "qr_codes": dict(sorted(self.codes.items())),
            "landmarks": {
                "place": {mark.text: [round(x, 3) for x in mark.p_FQ] for mark in landmarks},
                "sigma": {mark.text: round(mark.sigma_m, 3) for mark in landmarks},
                "sightings": {mark.text: mark.sightings for mark in landmarks},
            },
            "faces": self.faces,
            "clouds": {
                "points": sum(self.points),
                "mean": _rounded(np.mean(self.means, axis=0)) if self.means else [],
                "spread": _rounded(np.mean(self.spreads, axis=0)) if self.spreads else [],
            },
            "pictures": {
                "bytes": sum(len(picture.jpeg) for picture in self.pictures),
                "sizes": dict(sorted(Counter(f"{p.width}x{p.height}" for p in self.pictures).items())),
            },
            "driving": {
                "drivers": dict(sorted(self.drivers.items())),
                "distance": round(self.distance_m, 3),
                "turned": round(self.turned_rad, 3),
            },
        }

    def _codes(self, message: QRCodes) -> None:
        self.codes.update(code.text for code in message.codes)

    def _landmarks(self, message: Landmarks) -> None:
        self.landmarks = message

    def _faces(self, message: Faces) -> None:
        self.faces += len(message.faces)

    def _cloud(self, cloud: PointCloud) -> None:
        self.points.append(len(cloud.points))
        if len(cloud.points):
            self.means.append(cloud.points.mean(axis=0, dtype=np.float64))
            self.spreads.append(cloud.points.std(axis=0, dtype=np.float64))

    def _exploitation(self, now: Exploitation) -> None:
        """The path that the published commands would have driven."""
        if now.group != "base":
            return
        self.drivers[now.behavior or "nobody"] += 1
        if self._last is not None:
            elapsed_s = now.stamp - self._last.stamp
            self.distance_m += abs(self._last.twist.linear_mps) * elapsed_s
            self.turned_rad += abs(self._last.twist.angular_radps) * elapsed_s
        self._last = now


def _rounded(values: NDArray[np.float64]) -> list[float]:
    return [round(float(value), 3) for value in values]
