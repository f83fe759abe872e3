"""From here to a goal: the way, or the nearest that can be reached, or why there is none, in words for people."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.geometry import Pose2
from app.modules.behaviors.navigation.inflation import CostField


@dataclass(frozen=True, slots=True)
class PlanSettings:
    """``near_m``: how far from a goal that cannot be stood on a place may be that is taken instead. ``free_start_m``:
    how far a robot that stands too near to something may go to get free. ``spacing_m`` between the path's poses."""

    near_m: float = 1.0
    free_start_m: float = 0.6
    spacing_m: float = 0.05


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """A way on the map, or why there is none.

    ``code``: ``way`` (to the goal itself), ``near`` (to ``target``, the nearest place that can be reached), or without
    a way: ``outside`` (the goal is off the map), ``obstacle`` (it lies on one, nothing free near it), ``walled_off``,
    ``keep_out`` (zones are in the way), ``unknown`` (only unknown space, which is blocked, leads there), ``in_the_way``
    (something that the map does not know stands in the only way; it may go), ``start_stuck`` (the robot itself cannot
    get free), ``start_outside``. ``reason`` says it to people, "" for ``way`` from a free start. ``poses`` (N, 3)
    float64 x, y, heading on the map, evenly spaced, (0, 3) without a way. ``target`` is where the way ends, its heading
    NaN if none was asked for. ``length_m`` of the way, ``cost`` of it (metres in the open).
    """

    code: str
    reason: str
    poses: NDArray[np.float64]
    target: Pose2 | None
    length_m: float
    cost: float


def plan(field: CostField, start: Pose2, goal: Pose2, settings: PlanSettings | None = None) -> Plan:
    """The cheapest way from ``start`` to ``goal`` (heading NaN: any), both on the map, over ``field``."""
    raise NotImplementedError


@dataclass(frozen=True, slots=True)
class PathCheck:
    """What is left of a path: ``nearest`` pose's index, ``off_m`` from it, ``remaining_m`` to the end, and
    ``blocked_m`` along it to where it leads through what is lethal now (None: free)."""

    nearest: int
    off_m: float
    remaining_m: float
    blocked_m: float | None


def check_path(field: CostField, poses: NDArray[np.float64], pose: Pose2, from_index: int = 0) -> PathCheck:
    """Look along ``poses`` (N >= 1, 3) from where the robot is (``pose``, on the map; not before ``from_index``)."""
    raise NotImplementedError


def why_replan(check: PathCheck, off_limit_m: float = 0.5) -> str:
    """Why a new way must be planned, in words; "" while the old one is good."""
    raise NotImplementedError
