"""The picture of a calibration: CPU use and events against 1/φ, one row a filter (the thesis's figure 4.4)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from app.attention.calibration import CostCalibration, CostFit, Relation

_INK, _LINE = "#1b4965", "#ca6702"


def plot(calibration: CostCalibration, path: Path) -> None:
    """Draw ``calibration`` into ``path`` (PNG or SVG, by its name). Raises OSError where it cannot be written."""
    count = max(1, len(calibration.relations))
    figure = Figure(figsize=(9, 0.9 + 2.9 * count), layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(f"What φ costs and finds on {calibration.host}", fontsize=12)
    axes = figure.subplots(count, 2, squeeze=False)
    for (left, right), (name, relation) in zip(axes, calibration.relations.items(), strict=False):
        _panel(left, relation, "cpu", "CPU (% of one core)", f"{name}: cost")
        _panel(right, relation, "events", "events per second", f"{name}: events")
    figure.savefig(path, dpi=130)


def _panel(axes: Axes, relation: Relation, what: str, label: str, title: str) -> None:
    phis = [point.phi for point in relation.points]
    values = [getattr(point, what) for point in relation.points]
    line: CostFit = getattr(relation, what)
    x = np.linspace(0, 1 / min(phis), 50)
    axes.plot(x, line.base + line.slope * x, color=_LINE, linewidth=1.5, zorder=1)
    half = [point.cpu_spread / 2 if what == "cpu" else 0 for point in relation.points]
    axes.errorbar(
        [1 / phi for phi in phis],
        values,
        yerr=half,
        fmt="o",
        color=_INK,
        markersize=5,
        capsize=3,
        linewidth=1,
        zorder=2,
    )
    axes.set_title(title, fontsize=10, loc="left")
    axes.set_ylabel(label)
    axes.set_xlabel("1/φ")
    shown = _apart(phis)
    axes.set_xticks([1 / phi for phi in shown], [f"1/{phi}" if phi > 1 else "1" for phi in shown])
    axes.set_xlim(0, 1.05 / min(phis))
    axes.set_ylim(bottom=min(0.0, *values))
    axes.grid(alpha=0.25)
    words = f"{line.base:.3g} + {line.slope:.3g}/φ\nresidual {line.residual:.2g}"
    axes.annotate(words, (0.03, 0.95), xycoords="axes fraction", va="top", fontsize=9, color=_LINE)


def _apart(phis: list[int]) -> list[int]:
    """A subset of ``phis`` whose labels do not overlap; small ones are preferred."""
    shown: list[int] = []
    widest = 1 / min(phis)
    for phi in sorted(phis):
        if not shown or 1 / shown[-1] - 1 / phi > 0.07 * widest:
            shown.append(phi)
    return shown
