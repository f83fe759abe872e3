"""Table and picture of the overload experiment."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from app.experiments.observation import RESULTS, Outcome

TITLES = {
    "qr_codes": "QR codes looked for",
    "faces": "faces looked for",
    "loud_noises": "loud noises",
    "sound_sources": "sounds located",
    "camera_jpeg": "pictures for people",
    "point_cloud": "point clouds",
    "robot_audio": "sound for people",
    "exploitation": "arbiter of the base",
}
_WITHOUT, _WITH = ("#ca6702", "everything at φ = 1"), ("#1b4965", "with attention")


def table(without: Outcome, kept: Outcome) -> str:
    rows: list[tuple[str, str, str]] = [
        ("program's CPU, % of a core", f"{without.cpu:.0f}", f"{kept.cpu:.0f}"),
        ("world's CPU, % of a core", f"{without.body_cpu:.0f}", f"{kept.body_cpu:.0f}"),
        ("world's time over real time", f"{without.world_rate:.2f}", f"{kept.world_rate:.2f}"),
        ("event loop late, p99, ms", _ms(without.loop_late_p99_s), _ms(kept.loop_late_p99_s)),
        ("10 Hz beats of the base missed", _missed(without), _missed(kept)),
        ("wheels stopped by the guard, command too old", str(without.stops), str(kept.stops)),
        ("messages dropped at full inboxes", str(sum(without.dropped.values())), str(sum(kept.dropped.values()))),
        ("the drive", without.script, kept.script),
        ("modules restarted", str(without.failures), str(kept.failures)),
    ]
    for name in RESULTS:
        if name in without.ages or name in kept.ages:
            cells = [_age(o, name) for o in (without, kept)]
            rows.append((f"{TITLES[name]}: age p50 / p95 / worst, ms (rate, Hz)", cells[0], cells[1]))
    rows += [
        (f"{kind} found", str(without.found[kind]), str(kept.found[kind]))
        for kind in ("codes", "faces", "noises", "voices")
    ]
    rows.append(("(claps there were)", str(without.true_claps), str(kept.true_claps)))
    lines = ["| | everything at φ = 1 | with attention |", "|---|---|---|"]
    lines += [f"| {what} | {one} | {other} |" for what, one, other in rows]
    return "\n".join(lines)


#: CPU of other programs (% of a core) above which the figures are doubtful.
OTHERS = 25.0


def doubts(outcomes: Sequence[Outcome], budget: float) -> list[str]:
    """Reasons why the figures are not valid, as sentences; empty if they are."""
    said = []
    for outcome in outcomes:
        what = "with attention" if outcome.attention else "with everything at φ = 1"
        ours = outcome.others_cpu - (100.0 - budget)  # without the busy process of the confinement
        if ours > OTHERS:
            said.append(f"other programs took {ours:.0f} % of a core meanwhile ({what})")
        if outcome.world_rate < 0.9:
            said.append(f"the world ran at {outcome.world_rate:.2f} of real time ({what})")
    return said


def plot(without: Outcome, kept: Outcome, path: Path) -> None:
    """Draw ages over time, distributions of ages, and CPU. Raises OSError if the file cannot be written."""
    figure = Figure(figsize=(11, 7), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplot_mosaic([["faces", "bars"], ["exploitation", "bars"]], width_ratios=[1.4, 1])
    for name in ("faces", "exploitation"):
        _ages_over_time(axes[name], without, kept, name)
    _bars(axes["bars"], without, kept)
    figure.suptitle(f"Program on a small computer: {without.cpu:.0f} % of a core, {kept.cpu:.0f} % with attention")
    figure.savefig(path, dpi=130)


def _ages_over_time(axes: Axes, without: Outcome, kept: Outcome, name: str) -> None:
    for outcome, (color, label) in ((without, _WITHOUT), (kept, _WITH)):
        points = outcome.series.get(name, [])
        if points:
            times, ages = zip(*points, strict=True)
            axes.plot(times, [max(1.0, 1e3 * age) for age in ages], ".", ms=3, color=color, label=label)
    axes.set_yscale("log")
    axes.set_title(TITLES[name], loc="left", fontsize=11)
    axes.set_ylabel("age when it came (ms)")
    axes.set_xlabel("s")
    axes.grid(alpha=0.25)
    if axes.has_data():
        axes.legend(loc="upper right", fontsize=9)


def _bars(axes: Axes, without: Outcome, kept: Outcome) -> None:
    names = [name for name in RESULTS if name in without.ages or name in kept.ages]
    for offset, outcome, (color, label) in ((-0.2, without, _WITHOUT), (0.2, kept, _WITH)):
        ages = [1e3 * outcome.ages[name].p95 if name in outcome.ages else math.nan for name in names]
        axes.barh([i + offset for i in range(len(names))], ages, height=0.38, color=color, label=label)
    axes.set_yticks(range(len(names)), [TITLES[name] for name in names])
    axes.invert_yaxis()
    axes.set_xscale("log")
    axes.set_xlabel("age, 95th percentile (ms)")
    axes.grid(alpha=0.25, axis="x")
    axes.legend(fontsize=9)


def _age(outcome: Outcome, name: str) -> str:
    ages = outcome.ages.get(name)
    if ages is None:
        return "–"
    return f"{1e3 * ages.median:.0f} / {1e3 * ages.p95:.0f} / {1e3 * ages.worst:.0f} ({outcome.rates[name]:.1f})"


def _missed(outcome: Outcome) -> str:
    return f"{outcome.missed} of {outcome.beats + outcome.missed}"


def _ms(seconds: float) -> str:
    return f"{1e3 * seconds:.0f}"
