"""Planning to one goal: the path, or the path to the nearest reachable place, or the reason for none, in words."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.modules.behaviors.navigation.costmap.footprint import clearances
from app.modules.behaviors.navigation.costmap.inflation import (
    AT_KEEP_OUT,
    AT_OCCUPIED,
    AT_TEMPORARY,
    KEEP_OUT,
    OCCUPIED,
    UNKNOWN,
    CostField,
)
from app.modules.behaviors.navigation.costmap.zone_layer import keep_out
from app.modules.behaviors.navigation.planning.astar import ReachedCells, explore
from app.modules.behaviors.navigation.planning.smoothing import length_of, smooth, with_headings

#: Clearance beyond the body's radius of a place to turn at: the body stops up to so far (m) beside it.
_TURNING_M = 0.15
#: Codes of plans that end at a substitute place.
SUBSTITUTES = frozenset({"near", "taken"})


@dataclass(frozen=True, slots=True)
class PlanSettings:
    """``near_m``: greatest distance of a substitute place from a goal that is occupied. ``free_start_m``: longest way
    out for a robot too near to an obstacle; ``leave_zone_m``: longest way out of a keep-out zone.
    ``spacing_m``: distance between the path's poses. ``room_to_turn``: at a substitute place, the body can turn on the
    spot."""

    near_m: float = 1.0
    room_to_turn: bool = False
    free_start_m: float = 0.6
    leave_zone_m: float = 8.0
    spacing_m: float = 0.05


@dataclass(frozen=True, slots=True, eq=False)
class GlobalPlan:
    """A path on the map, or the reason for none.

    ``code``: ``way`` (to the goal itself), ``near`` (to ``target``, the nearest reachable place), ``taken`` (the
    same, where a transient obstacle at the goal may go; of the global planner), or without a path:
    ``outside`` (the goal is off the map), ``obstacle`` (the goal and all places near it are occupied), ``walled_off``,
    ``keep_out`` (zones block), ``unknown`` (only unknown space leads there, and it is blocked), ``in_the_way`` (a
    transient obstacle blocks the only path), ``arms`` (only with the arms at rest there is a path), ``start_stuck``
    (the robot itself cannot get free), ``start_outside``.
    ``reason`` is a sentence for people, "" for none.

    ``poses`` (N, 3) float64 x, y, heading on the map, about ``spacing_m`` apart, (0, 3) without a path. ``target``: end
    of the path, heading NaN if none was asked for. ``length_m``: its length.
    """

    code: str
    reason: str
    poses: NDArray[np.float64]
    target: Pose2 | None
    length_m: float

    def away_m(self, goal: Pose2) -> float:
        """How far from ``goal`` it ends (m); infinite without a path."""
        return math.inf if self.target is None else math.dist((self.target.x, self.target.y), (goal.x, goal.y))


def plan(field: CostField, start: Pose2, goal: Pose2, settings: PlanSettings | None = None) -> GlobalPlan:
    """The cheapest path from ``start`` to ``goal`` (heading NaN: any), both on the map, over ``field``."""
    settings = settings or PlanSettings()
    frame = field.frame
    start_cell, goal_cell = frame.cell(start.x, start.y), frame.cell(goal.x, goal.y)
    if start_cell is None:
        return _none("start_outside", "the robot is off the map")
    if goal_cell is None:
        right, top = frame.x + frame.columns * frame.resolution_m, frame.y + frame.rows * frame.resolution_m
        covers = f"x {frame.x:.1f} to {right:.1f} and y {frame.y:.1f} to {top:.1f} m"
        return _none("outside", f"the goal is off the map, which covers {covers}")
    said, out = "", np.empty((0, 2), dtype=np.int64)
    if not np.isfinite(field.cost[start_cell]):
        out = _way_out(field, start_cell, goal_cell, settings)
        if not len(out):
            return _none("start_stuck", f"the robot cannot get free: {_what_is_at(field, start, start_cell)}")
        said = f"first gets free: {_what_is_at(field, start, start_cell)}"
        start_cell = (int(out[-1, 0]), int(out[-1, 1]))
    fits = body_fits(field, goal)
    reached = explore(field, start_cell, goal_cell if fits else None)
    if fits and reached.has(goal_cell):
        return _way(reached, "way", reason=said, out=out, start=start, target=goal, cell=goal_cell, settings=settings)
    if fits:
        return _why_not(field, start_cell, goal_cell)
    target = _nearest(reached, goal, goal_cell, settings)
    why = _what_is_at(field, goal, goal_cell, "the goal")
    if target is None:
        return _none("obstacle", f"{why}, and no place within {settings.near_m:g} m of it can be reached")
    cell, place = target
    away = math.hypot(place.x - goal.x, place.y - goal.y)
    substitute = f"{why}: goes to the nearest place that can be reached, {away:.2f} m from it"
    return _way(
        reached,
        "near",
        reason="; ".join(filter(None, (substitute, said))),
        out=out,
        start=start,
        target=place,
        cell=cell,
        settings=settings,
    )


def _way(
    reached: ReachedCells,
    code: str,
    reason: str,
    out: NDArray[np.int64],
    start: Pose2,
    target: Pose2,
    cell: tuple[int, int],
    settings: PlanSettings,
) -> GlobalPlan:
    field, frame = reached.field, reached.field.frame
    points = _middles(field, reached.way(cell))
    # The ends are the exact poses, except for a start that is not free: its way out stays as it is.
    if not len(out):
        points = np.concatenate(([[start.x, start.y]], points))
    points = np.concatenate((points, [[target.x, target.y]]))
    way = smooth(field, points, settings.spacing_m)
    if len(out):
        step = max(1, round(settings.spacing_m / frame.resolution_m))
        way = np.concatenate(([[start.x, start.y]], _middles(field, out[step:-1:step]), way))
    poses = with_headings(way, start.theta, target.theta)
    return GlobalPlan(code, reason, poses, target, length_of(poses))


def _why_not(field: CostField, start: tuple[int, int], goal: tuple[int, int]) -> GlobalPlan:
    """The goal's cell is free, but no path leads there: the layers that would have to vanish."""
    bits = AT_KEEP_OUT | AT_TEMPORARY
    if field.known is None and not field.zones and field.settings.unknown != "blocked":
        return _none("walled_off", "obstacles on the map wall the goal off")
    reached = explore(field, start, goal, passable=bits)
    if not reached.has(goal):
        return _none("walled_off", "obstacles on the map wall the goal off")
    cells = reached.way(goal)
    lethal = cells[~np.isfinite(field.cost[cells[:, 0], cells[:, 1]])]
    layers = field.layers[lethal[:, 0], lethal[:, 1]]
    shut = layers & AT_KEEP_OUT != 0
    if shut.any():
        places = _middles(field, lethal[shut])[:: max(1, shut.sum() // 50)]
        margin = field.lethal_m + 1.5 * field.frame.resolution_m
        names = dict.fromkeys(filter(None, (keep_out(field.zones, x, y, margin) for x, y in places)))
        which = ", ".join(f"“{name}”" for name in names)
        return _none("keep_out", f"zones that the robot keeps out of are in the way: {which}")
    blocked = layers & AT_TEMPORARY != 0
    if blocked.any():
        x, y = _middles(field, lethal[blocked][:1])[0]
        return _none(
            "in_the_way", f"something that is not on the map stands in the only way, near x {x:.1f}, y {y:.1f} m"
        )
    return _none("unknown", "only unknown space leads to the goal, and the robot may not go there")


def body_fits(field: CostField, pose: Pose2) -> bool:
    """Whether the body fits there, at its heading if one is asked for."""
    cell = field.frame.cell(pose.x, pose.y)
    if cell is None or not np.isfinite(field.cost[cell]):
        return False
    if not math.isfinite(pose.theta) or field.clearance[cell] >= field.footprint.circumscribed_m:
        return True
    return bool(_body_fits(field, np.array([[pose.x, pose.y, pose.theta]]))[0])


def _body_fits(field: CostField, poses: NDArray[np.float64]) -> NDArray[np.bool_]:
    frame = field.frame
    free = clearances(field.clearance, (frame.x, frame.y), frame.resolution_m, field.footprint, poses)
    return np.asarray(free > 0.5 * frame.resolution_m)


def _nearest(
    reached: ReachedCells, goal: Pose2, goal_cell: tuple[int, int], settings: PlanSettings
) -> tuple[tuple[int, int], Pose2] | None:
    """The reached cell nearest to the goal where the body fits; among cells equally near (to a cell), the one with more
    clearance."""
    field, frame, near_m = reached.field, reached.field.frame, settings.near_m
    reach = math.ceil(near_m / frame.resolution_m)
    (row, column), cost = goal_cell, field.cost
    top, left = max(row - reach, 0), max(column - reach, 0)
    rows, columns = np.nonzero(np.isfinite(cost[top : row + reach + 1, left : column + reach + 1]))
    cells = np.stack((rows + top, columns + left), axis=-1)
    places = _middles(field, cells)
    away = np.hypot(places[:, 0] - goal.x, places[:, 1] - goal.y)
    score = away + 0.2 * frame.resolution_m * cost[cells[:, 0], cells[:, 1]]
    order = np.argsort(np.where(away <= near_m, score, np.inf), kind="stable")[: int((away <= near_m).sum())]
    for k in order.tolist():
        cell = (int(cells[k, 0]), int(cells[k, 1]))
        place = Pose2(float(places[k, 0]), float(places[k, 1]), goal.theta)
        turns = field.clearance[cell] > field.footprint.circumscribed_m + _TURNING_M
        if reached.has(cell) and (turns if settings.room_to_turn else body_fits(field, place)):
            return cell, place
    return None


def _way_out(
    field: CostField, start: tuple[int, int], goal: tuple[int, int], settings: PlanSettings
) -> NDArray[np.int64]:
    """Cells (N, 2) from a lethal ``start`` to the nearest that is not lethal; none if none is near enough."""
    from app.modules.behaviors.navigation.planning.path_kernels import escape

    bits = int(field.layers[start])
    if bits & AT_KEEP_OUT and not bits & (AT_OCCUPIED | AT_TEMPORARY):
        # Leave a zone on the side that leads to the goal, if there is one
        reached = explore(field, start, goal, passable=AT_KEEP_OUT)
        if reached.has(goal):
            cells = reached.way(goal)
            free = np.isfinite(field.cost[cells[:, 0], cells[:, 1]])
            first = int(free.argmax())
            if free[first:].all():
                return cells[: first + 1]
    reach = (settings.leave_zone_m if bits & AT_KEEP_OUT else settings.free_start_m) / field.frame.resolution_m
    return escape(field.layers, field.cost, *start, reach, OCCUPIED)


def _what_is_at(field: CostField, pose: Pose2, cell: tuple[int, int], who: str = "it") -> str:
    layer = int(field.layers[cell])
    if layer & KEEP_OUT or (layer & AT_KEEP_OUT and not layer & (AT_OCCUPIED | AT_TEMPORARY)):
        name = keep_out(field.zones, pose.x, pose.y, field.lethal_m + 1.5 * field.frame.resolution_m)
        where = "lies in" if layer & KEEP_OUT else "is too near to"
        return f"{who} {where} the zone “{name}”, which the robot keeps out of"
    if layer & OCCUPIED:
        return f"{who} lies on an obstacle of the map"
    if layer & AT_OCCUPIED:
        wide = "the stretched arms reach" if field.footprint.with_arms else "the body is wide"
        return f"{who} is nearer to an obstacle of the map than {wide}"
    if layer & AT_TEMPORARY:
        return f"{who} is too near to something that is not on the map"
    if layer & UNKNOWN and not np.isfinite(field.cost[cell]):
        return f"{who} lies in unknown space, where the robot may not go"
    return f"{who} leaves no room to stand with the heading that was asked for"


def _middles(field: CostField, cells: NDArray[np.int64]) -> NDArray[np.float64]:
    frame = field.frame
    return np.asarray((cells[:, ::-1] + 0.5) * frame.resolution_m + np.array([frame.x, frame.y]))


def _none(code: str, reason: str) -> GlobalPlan:
    return GlobalPlan(code, reason, np.empty((0, 3)), None, 0.0)


@dataclass(frozen=True, slots=True)
class PathCheck:
    """State of a path: index of the ``nearest`` pose, ``off_m`` from it, ``remaining_m`` to the end, and ``blocked_m``
    along it to the first lethal place now (None: free)."""

    nearest: int
    off_m: float
    remaining_m: float
    blocked_m: float | None


def check_path(
    field: CostField, poses: NDArray[np.float64], pose: Pose2, from_index: int = 0, within_m: float = math.inf
) -> PathCheck:
    """Check ``poses`` (N >= 1, 3) from the robot's ``pose`` on, on the current map, zones and obstacles. The nearest
    pose is searched from ``from_index`` on, ``within_m`` along the path."""
    from app.modules.behaviors.navigation.planning.path_kernels import first_lethal

    frame = field.frame
    steps = np.hypot(*np.diff(poses[:, :2], axis=0).T) if len(poses) > 1 else np.empty(0)
    along = np.concatenate(([0.0], np.cumsum(steps)))
    last = max(int(np.searchsorted(along, along[from_index] + within_m, side="right")), from_index + 1)
    away = np.hypot(poses[from_index:last, 0] - pose.x, poses[from_index:last, 1] - pose.y)
    nearest = from_index + int(np.argmin(away))
    cells = np.ascontiguousarray((poses[:, 1::-1] - np.array([frame.y, frame.x])) / frame.resolution_m - 0.5)
    blocked = first_lethal(field.cost, cells, nearest, len(poses) - 1)
    return PathCheck(
        nearest,
        float(away[nearest - from_index]),
        float(along[-1] - along[nearest]),
        None if blocked < 0 else float(along[blocked] - along[nearest]),
    )


def why_replan(check: PathCheck, off_limit_m: float = 0.5) -> str:
    """The reason for a new path, in words; "" while the old one is good."""
    if check.blocked_m is not None:
        return f"the way is blocked {check.blocked_m:.1f} m ahead"
    if check.off_m > off_limit_m:
        return f"the robot is {check.off_m:.1f} m off its way"
    return ""
