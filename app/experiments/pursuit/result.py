"""Results of the pursuit study: one run, and the runs of one condition."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

import msgspec
import numpy as np

from app.base.errors import ConfigError

Task = Literal["follow", "course"]
SCRIPTED = "script"


@dataclass(frozen=True, slots=True, order=True)
class Condition:
    """``task``: a person is followed, or a course is driven. ``mode``: 1, head ahead, or 2, the head follows the view.
    ``delay_ms`` of a round trip ± ``jitter_ms``. ``prediction``: whether the operator sees where the robot will be."""

    task: Task
    mode: int
    delay_ms: float
    jitter_ms: float
    prediction: bool

    @property
    def words(self) -> str:
        """For people, as ``300 ± 50 ms, predicted``."""
        jitter = f" ± {self.jitter_ms:g}" if self.jitter_ms else ""
        return f"{self.delay_ms:g}{jitter} ms, {'predicted' if self.prediction else 'measured'}"


@dataclass(frozen=True, slots=True)
class PursuitResult:
    """One run, by the truth of its world.

    ``operator``: who drove, "script" for the scripted one. ``ended``: the person's walk, or the course, was followed to
    its end. ``time_s``, ``driven_m`` of the robot; ``contacts``: how often it was stopped by what it would have run
    into; ``monitor_stops``: by its collision monitor, and ``limited`` the share of the time that this slowed it.
    ``distance_m`` to the person, mean and 95th percentile, ``visible``: the share of the time that the person was in
    the camera's picture; all None on a course. ``late_share``: mean share of the speed that commands were allowed for
    their age, ``late``: how many moved nothing because they came too late. ``trace``: x and y (m) of the robot each
    half second.
    """

    condition: Condition
    seed: int
    course: str
    ended: bool
    time_s: float
    driven_m: float
    contacts: int
    monitor_stops: int
    limited: float
    distance_m: float | None = None
    distance_p95_m: float | None = None
    visible: float | None = None
    late_share: float = 1.0
    late: int = 0
    operator: str = SCRIPTED
    trace: tuple[tuple[float, float], ...] = ()

    @property
    def speed_mps(self) -> float:
        """Mean speed over ground."""
        return self.driven_m / self.time_s if self.time_s > 0 else 0.0

    def document(self) -> dict[str, Any]:
        """As JSON."""
        return asdict(self)


@dataclass(frozen=True, slots=True)
class PursuitSummary:
    """The runs of one operator in one condition; means over runs, sums of ``contacts`` and ``monitor_stops``.
    ``distance_p95_m``: of the worst run. ``speed_share``: of the mean time without delay on the same courses, None
    without such runs."""

    operator: str
    condition: Condition
    runs: int
    ended: int
    contacts: int
    monitor_stops: int
    limited: float
    time_s: float
    driven_m: float
    speed_mps: float
    late_share: float
    late: int
    distance_m: float | None
    distance_p95_m: float | None
    visible: float | None
    speed_share: float | None

    def document(self) -> dict[str, Any]:
        """As JSON."""
        return asdict(self)


def summaries(results: Sequence[PursuitResult]) -> tuple[PursuitSummary, ...]:
    """One for each operator and condition, in order."""
    groups: dict[tuple[str, Condition], list[PursuitResult]] = {}
    for result in results:
        groups.setdefault((result.operator, result.condition), []).append(result)
    return tuple(_summary(group, results) for _, group in sorted(groups.items(), key=lambda item: item[0]))


def _summary(group: Sequence[PursuitResult], results: Iterable[PursuitResult]) -> PursuitSummary:
    first = group[0]
    driven, seconds = sum(each.driven_m for each in group), sum(each.time_s for each in group)
    p95 = [each.distance_p95_m for each in group if each.distance_p95_m is not None]
    return PursuitSummary(
        operator=first.operator,
        condition=first.condition,
        runs=len(group),
        ended=sum(each.ended for each in group),
        contacts=sum(each.contacts for each in group),
        monitor_stops=sum(each.monitor_stops for each in group),
        limited=_mean([each.limited for each in group]) or 0.0,
        time_s=seconds / len(group),
        driven_m=driven / len(group),
        speed_mps=driven / seconds if seconds > 0 else 0.0,
        late_share=_mean([each.late_share for each in group]) or 0.0,
        late=sum(each.late for each in group),
        distance_m=_mean([each.distance_m for each in group]),
        distance_p95_m=max(p95, default=None),
        visible=_mean([each.visible for each in group]),
        speed_share=_speed_share(group, results),
    )


def _speed_share(group: Sequence[PursuitResult], results: Iterable[PursuitResult]) -> float | None:
    """Time without delay over time with it, on a course, seed by seed; of runs that ended alone."""
    wanted = group[0].condition
    without = {
        each.seed: each.time_s
        for each in results
        if each.operator == group[0].operator
        and each.ended
        and each.condition.delay_ms == 0
        and (each.condition.task, each.condition.mode) == (wanted.task, wanted.mode)
        and each.condition.prediction == wanted.prediction
    }
    pairs = [(without[each.seed], each.time_s) for each in group if each.ended and each.seed in without]
    if wanted.task != "course" or not pairs:
        return None
    return sum(first for first, _ in pairs) / sum(second for _, second in pairs)


def _mean(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if known else None


def results_of(file: Path) -> tuple[PursuitResult, ...]:
    """The ``runs`` of a file of results, as ``--json`` prints them or as a person's runs are written. Raises
    ConfigError."""
    try:
        found = msgspec.convert(json.loads(file.read_text(encoding="utf-8")), _RunsFile, strict=True)
    except OSError as failure:
        raise ConfigError(f"cannot be read: {failure.strerror or failure}", str(file)) from None
    except (ValueError, msgspec.ValidationError) as failure:
        raise ConfigError(f"is no file of runs of the pursuit study: {failure}", str(file)) from None
    return found.runs


@dataclass(frozen=True, slots=True)
class _RunsFile:
    runs: tuple[PursuitResult, ...]
