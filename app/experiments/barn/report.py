"""The BARN challenge's table, and pictures of worlds with the driven path."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PatchCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon

from app.base.errors import ConfigError
from app.experiments.barn.result import OUTCOMES, BarnSummary, WorldResult
from app.experiments.barn.worlds import BarnWorld

_SAID = {"success": "successes", "collision": "collisions", "timeout": "timeouts", "failed": "failed"}
_BLUE, _RED, _GREY = "#1b4965", "#ca6702", "#8d99ae"


def table(results: Sequence[WorldResult]) -> str:
    summary = BarnSummary.of(results)
    rows = [("worlds", str(summary.worlds))]
    rows += [(f"{_SAID[outcome]}, %", f"{100 * summary.shares[outcome]:.1f}") for outcome in OUTCOMES]
    rows += [
        ("mean time of successes, s", "–" if math.isnan(summary.mean_time_s) else f"{summary.mean_time_s:.2f}"),
        ("score, mean of success · T*/clip(T, 2T*, 8T*)", f"{summary.score:.4f}"),
        ("recoveries a world", f"{sum(result.recoveries for result in results) / max(len(results), 1):.2f}"),
    ]
    return "\n".join(["| | |", "|---|---|", *(f"| {what} | {value} |" for what, value in rows)])


def failures(results: Sequence[WorldResult]) -> list[str]:
    return [
        f"world {result.world}: {result.outcome} after {result.time_s:.1f} s, {result.left_m:.1f} m before the goal"
        + (f" ({result.reason})" if result.reason else "")
        for result in results
        if result.outcome != "success"
    ]


def plot(world: BarnWorld, result: WorldResult | None, footprint: Sequence[tuple[float, float]], path: Path) -> None:
    """Draw ``world`` and the way driven in it. Raises ConfigError where it cannot be written."""
    figure = Figure(figsize=(5, 9), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    axes.add_collection(PatchCollection([Circle((x, y), radius) for x, y, radius in world.cylinders], facecolor=_GREY))
    if world.path:
        axes.plot(*zip(*world.path, strict=True), ":", color=_GREY, label="the file's path")
    axes.add_patch(Circle(world.goal, world.goal_tolerance, fill=False, color=_BLUE, ls="--"))
    axes.plot(*world.goal, "*", color=_BLUE, ms=10)
    axes.plot(*world.start[:2], "^", color=_BLUE)
    title = f"World {world.name}"
    if result is not None and result.trace:
        times, xs, ys, _ = zip(*result.trace, strict=True)
        axes.plot(xs, ys, "-", color=_RED, label="driven")
        for number in range(0, len(times), 10):
            _draw_body(axes, footprint, result.trace[number], 0.35)
        _draw_body(axes, footprint, result.trace[-1], 1.0)
        title += f": {result.outcome}, {result.time_s:.1f} s, score {result.score:.2f}"
        if result.reason:
            figure.supxlabel(result.reason, fontsize=8, wrap=True)
    axes.set_title(title, loc="left", fontsize=11)
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.legend(loc="upper right", fontsize=8)
    try:
        figure.savefig(path, dpi=110)
    except (OSError, ValueError) as failure:
        raise ConfigError(f"cannot be written: {failure}", str(path)) from None


def _draw_body(
    axes: Axes, footprint: Sequence[tuple[float, float]], at: tuple[float, float, float, float], alpha: float
) -> None:
    _, x, y, theta = at
    c, s = math.cos(theta), math.sin(theta)
    corners = [(x + c * px - s * py, y + s * px + c * py) for px, py in footprint]
    axes.add_patch(Polygon(corners, fill=False, color=_RED, alpha=alpha, lw=1))
