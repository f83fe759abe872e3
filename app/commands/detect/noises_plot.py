"""The plot of ``hbba detect noises --draw``: a recording's level, and what would have been loud, over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from app.base.errors import ConfigError
from app.modules.perception.loud_noises import decibels

#: Greatest number of points in a plot: of neighbours, the one nearest to the threshold is drawn.
_MOST = 4096
_INK, _LINE, _FOUND = "#1b4965", "#ca6702", "#9b2226"


class Levels:
    """Frames' energies and thresholds over time, of a recording of any length in bounded memory."""

    def __init__(self) -> None:
        self._points: list[tuple[float, float, float | None]] = []
        self._each = 1
        self._waiting: list[tuple[float, float, float | None]] = []

    def add(self, time_s: float, energy: float, threshold: float | None) -> None:
        """The next frame (of any channel)."""
        self._waiting.append((time_s, energy, threshold))
        if len(self._waiting) == self._each:
            self._points.append(max(self._waiting, key=_nearness))
            self._waiting.clear()
        if len(self._points) == _MOST:
            self._points = [
                max(pair, key=_nearness) for pair in zip(self._points[::2], self._points[1::2], strict=True)
            ]
            self._each *= 2

    def draw(self, file: Path, title: str, noises: Sequence[Mapping[str, Any]]) -> None:
        """Write the plot with the ``noises`` marked (PNG). Raises ConfigError where it cannot be written."""
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        points = [*self._points, *self._waiting]
        times = [time_s for time_s, _, _ in points]
        figure = Figure(figsize=(10, 3.6), layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.subplots()
        axes.plot(times, [decibels(energy) for _, energy, _ in points], color=_INK, linewidth=0.8, label="level")
        loud = [float("nan") if threshold is None else decibels(threshold) for _, _, threshold in points]
        axes.plot(times, loud, color=_LINE, linewidth=1.2, label="threshold")
        for noise in noises:
            axes.axvline(noise["time_s"], color=_FOUND, linewidth=0.8, alpha=0.6)
        count = len(noises)
        axes.set_title(f"{title}: {count} loud noise{'s' * (count != 1)}", fontsize=10, loc="left", parse_math=False)
        axes.set_xlabel("s")
        axes.set_ylabel("dB of full scale, 0.3 to 6 kHz")
        axes.set_ylim(bottom=-100)
        axes.grid(alpha=0.25)
        if points:
            axes.legend(loc="upper right", fontsize=8)
        try:
            figure.savefig(file, dpi=130)
        except OSError as failure:
            raise ConfigError(f"--draw: {file} cannot be written: {failure.strerror or failure}") from None


def _nearness(point: tuple[float, float, float | None]) -> float:
    """Ratio of a frame's level to the threshold; before a threshold is known, its level."""
    _, energy, threshold = point
    return energy if threshold is None else energy / threshold
