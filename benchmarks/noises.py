"""Loud noises in an hour of a laboratory's sound, beside the thesis's plain rule: ``python -m benchmarks.noises``.

The sound is ``benchmarks.lab_noise``'s (seeds 201 to 204, by which nothing was chosen; ``--quick``: five minutes).
*Found* is the share of its claps and calls with an event within 0.3 s of their arrival, *right* the share of events
that belong to one of them, each counted once. The peer is the thesis's rule: the energy of a frame of 512 samples over
20 times the mean of the 200 before it, from the first frame on, with one event until it has been quiet for the hold-off
of ours. *CPU* is what the module's own meter says at 93.75 frames of 8 channels a second, on the event loop; *latency*
is from a clap's arrival at the microphone to the published event, the frame it has to fill included.

``python -m benchmarks.noises --plot FILE.png`` draws found and right over ratio and window, and ratio and hold-off.
"""

from __future__ import annotations

import asyncio
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from app.messages import Audio, LoudNoise
from app.modules.perception.loud_noises import FRAME, BandEnergy, LoudnessRule, OnsetDetector, whole_energy
from app.runtime.channel_table import ChannelSpec
from app.runtime.clock import RealClock
from app.runtime.graph import Graph, ModuleSpec
from app.runtime.supervisor import Supervisor
from benchmarks.lab_noise import RATE, Script, blocks, script
from benchmarks.report import Row, benchmark_main, row

Times = NDArray[np.float64]
_CHANNELS = 8
#: A noise is found by an event at most this long (s) after its arrival; a frame may begin before the noise in it.
_LATE_S = 0.3
_EARLY_S = FRAME / RATE + 0.001


@dataclass(frozen=True)
class Hour:
    """The energies of each frame of a script's sound, in the band and whole."""

    plan: Script
    band: list[float]
    whole: list[float]


def listen(plan: Script) -> Hour:
    """Generate the sound of ``plan`` block by block, and keep its energies alone."""
    energies = BandEnergy(RATE)
    band: list[float] = []
    whole: list[float] = []
    rest = np.zeros(0, np.int16)
    for block in blocks(plan):
        samples = np.concatenate((rest, block))
        frames = len(samples) // FRAME * FRAME
        samples, rest = samples[:frames], samples[frames:]
        band += [energies.frame(frame) for frame in samples.reshape(-1, FRAME)]
        whole += [whole_energy(frame) for frame in samples.reshape(-1, FRAME)]
    return Hour(plan, band, whole)


def events_of_ours(hour: Hour, rule: LoudnessRule) -> Times:
    """Times (s) of our events."""
    detector = OnsetDetector(rule)
    frames = []
    for n, (e, w) in enumerate(zip(hour.band, hour.whole, strict=True)):
        if detector.update(e, partial(float, w)) is not None:
            frames.append(n)
    return np.array(frames, np.float64) * (FRAME / RATE)


def events_of_the_plain_rule(hour: Hour, rule: LoudnessRule) -> Times:
    """When (s) the thesis's rule does, computed for all frames at once."""
    energy = np.array(hour.whole)
    sums = np.concatenate(((0.0,), np.cumsum(energy)))
    frames = np.arange(len(energy))
    count = np.minimum(frames, rule.window)
    mean = (sums[frames] - sums[frames - count]) / np.maximum(count, 1)
    loud = np.flatnonzero(energy > rule.ratio * mean)
    first = np.diff(loud, prepend=-(1 << 30)) > rule.hold_off
    return np.asarray(loud[first] * (FRAME / RATE))


def score(events: Times, truth: Times) -> tuple[float, float]:
    """(right, found): the share of events in ``events`` that are noises of ``truth``, and the share of those with an
    event."""
    found: set[int] = set()
    for at in events:
        nearest = int(np.searchsorted(truth, at + _EARLY_S)) - 1
        if nearest >= 0 and at - truth[nearest] <= _LATE_S:
            found.add(nearest)
    return len(found) / max(1, len(events)), len(found) / max(1, len(truth))


# --- The module ------------------------------------------------------------------------------------------------------


def sound_with_claps(seconds: float, seed: int = 0) -> tuple[NDArray[np.int16], Times]:
    """Fans at -50 dB and a clap about each 0.7 s after the first two; (samples, arrivals in samples)."""
    rng = np.random.default_rng(seed)
    samples = rng.normal(0, 104, round(seconds * RATE))
    arrivals = []
    at = 2.2
    while at < seconds - 0.6:
        begin = round(at * RATE)
        arrivals.append(begin)
        t = np.arange(RATE // 2) / RATE
        decay = np.exp(-t / 0.004) + 0.02 * np.exp(-t / 0.07)
        samples[begin : begin + len(t)] += rng.normal(0, rng.uniform(4000, 12000), len(t)) * decay
        at += rng.uniform(0.6, 0.8)
    return np.clip(samples, -32768, 32767).astype(np.int16), np.array(arrivals, np.float64)


async def through_the_module(seconds: float, seed: int = 0) -> tuple[float, list[float], int]:
    """Play claps in real time through the module: its CPU in % of a core, latencies (ms), and how many claps."""
    sound, arrivals = sound_with_claps(seconds, seed)
    samples = np.repeat(sound[:, None], _CHANNELS, axis=1)
    module = {
        "class": "app.modules.perception.loud_noise_detector:LoudNoiseDetector",
        "inputs": {"audio": "microphones"},
        "outputs": {"noises": "loud_noises"},
    }
    graph = Graph(
        clock=RealClock(),
        channels={
            "microphones": ChannelSpec.model_validate({"type": "Audio", "external": True, "decimable": False}),
            "loud_noises": ChannelSpec.model_validate({"type": "LoudNoise", "decimable": False}),
        },
        modules={"LoudNoiseDetector": ModuleSpec.model_validate(module)},
        services={},
    )
    published: list[float] = []

    def note(_: LoudNoise) -> None:
        published.append(time.monotonic())

    graph.channel("loud_noises").observe(note)
    microphones = graph.channel("microphones")
    positions = np.zeros((_CHANNELS, 3))
    async with Supervisor(graph.modules, RealClock()):
        await asyncio.sleep(0.05)
        meter = graph.modules["LoudNoiseDetector"].context.meter
        begin, spent = time.monotonic(), meter.cpu_ns
        for first in range(0, len(samples) - FRAME + 1, FRAME):
            # A frame is there when its last sample is.
            await asyncio.sleep(begin + (first + FRAME) / RATE - time.monotonic())
            frame = samples[first : first + FRAME]
            microphones.publish(Audio(begin + first / RATE, "microphones", frame, RATE, first, positions))
        await asyncio.sleep(0.1)
        spent = meter.cpu_ns - spent
    heard = begin + arrivals / RATE
    latencies = [1e3 * (min(at for at in published if at >= clap) - clap) for clap in heard if clap < published[-1]]
    return spent / 1e7 / (len(samples) / RATE), latencies, len(arrivals)


# --- Rows and plots --------------------------------------------------------------------------------------------------


def measure(quick: bool) -> Sequence[Row]:
    """All rows; ``quick``: some 30 seconds, else some minutes."""
    rows: list[Row] = []
    plans = [script(201, 300.0)] if quick else [script(seed) for seed in range(201, 205)]
    for plan in plans:
        hour = listen(plan)
        ours = score(events_of_ours(hour, LoudnessRule()), plan.truth)
        plain = score(events_of_the_plain_rule(hour, LoudnessRule()), plan.truth)
        case = f"{plan.duration_s / 60:.0f} min of a laboratory, seed {plan.seed}, {len(plan.truth)} noises"
        for metric, mine, other in zip(("right (precision)", "found (recall)"), ours, plain, strict=True):
            rows.append(row("noises", case, metric, "%", [100 * mine], [100 * other], "the thesis's rule"))
    cpu, latencies, count = asyncio.run(through_the_module(12.0 if quick else 60.0))
    case = f"{count} claps through the module"
    rows.append(row("noises", case, "CPU", "% of a core", [cpu]))
    shares = ((percent, float(np.percentile(latencies, percent))) for percent in (50, 95))
    return [*rows, *(row("noises", case, f"latency p{percent}", "ms", [ms]) for percent, ms in shares)]


def plot(file: Path) -> int:
    """Draw the trade-offs of the hour with seed 5 into ``file``."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    hour = listen(script(5))
    ratios = np.array([4, 7, 12, 20, 35, 60, 100, 180, 320], float)
    windows = np.array([25, 50, 100, 200, 400, 800])
    hold_offs = np.array([4, 8, 16, 24, 48, 96])
    figure, axes = plt.subplots(1, 3, figsize=(14, 4.4), constrained_layout=True)
    panels = (
        ("the thesis's rule", events_of_the_plain_rule, "window", windows),
        ("ours", events_of_ours, "window", windows),
        ("ours", events_of_ours, "hold_off", hold_offs),
    )
    for axis, (name, events_of, parameter, values) in zip(axes, panels, strict=True):
        rules = [
            [
                LoudnessRule(
                    ratio=ratio,
                    **{parameter: int(v)},
                    **({"history": min(100, int(v))} if parameter == "window" else {}),
                )
                for ratio in ratios
            ]
            for v in values
        ]
        scores = np.array([[score(events_of(hour, rule), hour.plan.truth) for rule in line] for line in rules])
        seconds = values * FRAME / RATE
        for index, (metric, color, style) in enumerate(
            (("right", "tab:blue", "solid"), ("found", "tab:red", "dashed"))
        ):
            lines = axis.contour(
                ratios, seconds, 100 * scores[..., index], levels=(50, 70, 80, 90, 95, 98, 99), colors=color,
                linestyles=style, linewidths=1.2,
            )  # fmt: skip
            axis.clabel(lines, fmt=f"%g %% {metric}", fontsize=7)
        good = scores.min(axis=2) >= 0.98
        at_window, at_ratio = np.nonzero(good)
        axis.plot(ratios[at_ratio], seconds[at_window], "o", color="tab:green", label="both at least 98 %")
        axis.plot(20, (200 if parameter == "window" else 24) * FRAME / RATE, "k+", markersize=14, label="as configured")
        axis.set(xscale="log", yscale="log", xlabel="ratio", title=name)
        axis.set_ylabel("window (s)" if parameter == "window" else "hold-off (s)")
        axis.set_xticks(ratios, [f"{r:g}" for r in ratios], fontsize=8, minor=False)
        axis.set_xticks([], minor=True)
        axis.set_yticks(seconds, [f"{s:.2g}" for s in seconds], fontsize=8)
        axis.set_yticks([], minor=True)
        axis.legend(fontsize=8, loc="lower right")
    figure.savefig(file, dpi=110)
    return 0


if __name__ == "__main__":
    if "--plot" in sys.argv[:-1]:
        sys.exit(plot(Path(sys.argv[sys.argv.index("--plot") + 1])))
    sys.exit(benchmark_main(__doc__, measure))
