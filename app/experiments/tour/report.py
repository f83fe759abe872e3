"""Tables of the tour experiment, and a map with the ways of robot and visitors."""

from __future__ import annotations

import csv
import io
import itertools
from collections.abc import Iterable, Sequence
from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from app.base.errors import ConfigError
from app.experiments.tour.result import TourResult, TourSummary
from app.messages import OccupancyGrid, Place

_BLUE, _RED, _STOP, _GREENS = "#1b4965", "#ca6702", "#9b2226", ("#2a9d8f", "#9b5de5")
COLUMNS = (
    *("seed", "min", "m", "stops", "off m", "off rad", "texts to the end", "pointing °", "left behind s", "farthest m"),
    *("contacts", "person m", "CPU budget %", "questions", "waits", "waited s", "problems"),
)
"""Of the table of runs: ``off`` is the greatest of the stops, ``left behind`` as in TourResult."""


def rows(results: Iterable[TourResult]) -> list[list[str]]:
    """A row for each run, as :data:`COLUMNS`."""
    return [
        [
            str(r.seed),
            f"{r.duration_s / 60:.1f}",
            f"{r.driven_m:.0f}",
            f"{r.presented}/{r.stops}",
            _figure(max((arrival.off_m for arrival in r.arrivals), default=None)),
            _figure(max((abs(arrival.off_rad) for arrival in r.arrivals), default=None)),
            f"{sum(said.ended for said in r.texts)}/{len(r.texts)}",
            _figure(max(r.pointed_deg, default=None), 1),
            f"{r.left_behind_s:.1f}",
            f"{r.farthest_m:.1f}",
            str(r.touched),
            _figure(r.people_m),
            f"{100 * r.cpu_share:.0f}",
            f"{r.answered}/{r.asked}",
            str(r.waits),
            f"{r.waited_s:.0f}",
            str(len(r.problems)),
        ]
        for r in results
    ]


def runs_table(results: Sequence[TourResult]) -> str:
    """A line for each run."""
    lines = [COLUMNS, ["--:"] * len(COLUMNS), *rows(results)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def summary_table(results: Sequence[TourResult]) -> str:
    """All runs together."""
    s = TourSummary.of(results)
    lines = [
        ("runs", str(s.runs)),
        ("runs without a problem", str(s.good)),
        ("stops presented", f"{s.stops_presented} of {s.stops}"),
        ("greatest true error at a stop", f"{_figure(s.worst_off_m)} m, {_figure(s.worst_off_rad)} rad"),
        ("texts said to their end", f"{s.texts - s.interrupted} of {s.texts}"),
        ("greatest error of pointing, °", _figure(s.worst_pointed_deg, 1)),
        ("longest time that a visitor was left behind, s", f"{s.longest_left_behind_s:.1f}"),
        ("contacts", str(s.touched)),
        ("least distance to a person's trunk, m", _figure(s.least_people_m)),
        ("greatest share of attention's CPU budget, %", f"{100 * s.most_cpu_share:.0f}"),
        ("mean time, min", _figure(None if s.mean_duration_s is None else s.mean_duration_s / 60, 1)),
    ]
    return "\n".join(["| | |", "|---|---|", *(f"| {what} | {value} |" for what, value in lines)])


def problems(results: Iterable[TourResult]) -> list[str]:
    """A line for each problem."""
    return [f"seed {result.seed}: {problem}" for result in results for problem in result.problems]


def table_csv(results: Iterable[TourResult]) -> str:
    """The table of runs (RFC 4180)."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\r\n").writerows([COLUMNS, *rows(results)])
    return text.getvalue()


def plot(result: TourResult, grid: OccupancyGrid, stops: Sequence[Place], path: Path) -> None:
    """Draw the way driven on the map, the visitors' ways, and where the robot waited. Raises ConfigError where it
    cannot be written."""
    figure = Figure(figsize=(9, 6.5), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    (x, y), (height, width) = grid.origin, grid.cells.shape
    extent = (x, x + width * grid.resolution_m, y, y + height * grid.resolution_m)
    axes.imshow(grid.cells >= 50, origin="lower", extent=extent, cmap="Greys", alpha=0.5, interpolation="nearest")
    names = ("one who asks", "one who lags")
    for number, (name, colour) in enumerate(zip(names, _GREENS, strict=True)):
        ways = [sample.people[number] for sample in result.trace if number < len(sample.people)]
        if ways:
            axes.plot(*zip(*ways, strict=True), "-", color=colour, lw=1, label=name)
    driven = [sample.robot[:2] for sample in result.trace]
    if driven:
        axes.plot(*zip(*driven, strict=True), "-", color=_BLUE, lw=1.5, label="robot")
    if driven:
        axes.plot(*driven[0], "s", color=_BLUE, ms=8, label="begin")
    label: str | None = "waited for visitors"
    for state, group in itertools.groupby(result.trace, key=lambda sample: sample.state):
        first = next(group)
        if state == "waiting":
            axes.plot(*first.robot[:2], "o", color=_RED, ms=7, label=label)
            label = None
    for number, place in enumerate(stops, 1):
        axes.plot(place.x, place.y, "o", color=_STOP, ms=15, mec="white", label=f"{number} {place.name}")
        axes.text(place.x, place.y, str(number), color="white", fontsize=9, weight="bold", ha="center", va="center")
    everywhere = [*driven, *(at for sample in result.trace for at in sample.people)]
    if everywhere:
        xs, ys = zip(*everywhere, strict=True)
        axes.set_xlim(min(xs) - 1.5, max(xs) + 1.5)
        axes.set_ylim(min(ys) - 1.5, max(ys) + 1.5)
    axes.set_aspect("equal")
    axes.set_title(f"Seed {result.seed}: {result.duration_s / 60:.1f} min, {result.driven_m:.0f} m", loc="left")
    axes.set(xlabel="x on the map (m)", ylabel="y on the map (m)")
    figure.legend(loc="outside right upper", fontsize=9, labelspacing=1.0)
    try:
        figure.savefig(path, dpi=110)
    except (OSError, ValueError) as failure:
        raise ConfigError(f"cannot be written: {failure}", str(path)) from None


def _figure(value: float | None, digits: int = 2) -> str:
    return "–" if value is None else f"{value:.{digits}f}"
