"""Positions and gains of an array's microphones by claps: faults found first, then order, positions, and a verdict."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.modules.perception.voices.array_calibration.arrival_times import Arrivals, arrivals_of
from app.modules.perception.voices.array_calibration.claps import Clap
from app.modules.perception.voices.array_calibration.faults import faults_of, gains_db
from app.modules.perception.voices.array_calibration.refinement import Fit, Geometry, refine
from app.modules.perception.voices.array_calibration.results import (
    Calibration,
    ClapResult,
    MicrophoneResult,
    NotEnough,
)
from app.modules.perception.voices.array_calibration.structure import (
    affine_structure,
    aligned,
    directions,
    likely_orders,
)
from app.modules.perception.voices.array_calibration.verdict import BELIEVED, ENOUGH, LEAST, judge, unseen_of
from app.modules.perception.voices.microphone_array import MicrophoneArray
from app.modules.perception.voices.steering_vectors import SPEED_OF_SOUND

#: Claps used at most: the clearest.
MOST = 60
#: Fewer microphones have no shape that sound could show.
LEAST_MICROPHONES = 3
#: The configured size may be too small by this factor and this (m).
_LARGER, _LARGER_M = 2.0, 0.1
#: Least agreement of a clear clap's direct sounds, of the median microphone.
AGREEING = 0.4
#: The median direction of a plane array is longer than this only if the configured size is too small.
_TOO_SMALL = 1.02
#: Other orders are tried where microphones lie, on average, farther from their places than this share of the least
#: distance between two, or arrival times contradict any positions by so much (m).
_OFF, _OFF_M = 0.1, 0.004
#: Orders tried, and how much farther (factor, m) the places of another may be for the array to keep its own order.
_ORDERS, _ALIKE, _ALIKE_M = 24, 1.3, 0.002


def longest_lag_s(array: MicrophoneArray) -> float:
    """Greatest difference (s) of arrival times looked for, for an array that may be larger than configured."""
    size = float(np.linalg.norm(array.positions[array.first] - array.positions[array.second], axis=1).max())
    return (_LARGER * size + _LARGER_M) / SPEED_OF_SOUND


def rough_direction(arrivals: Arrivals, array: MicrophoneArray) -> NDArray[np.float64]:
    """The direction (3,) of a clap by the configured positions; of a plane array, on its upper or front side."""
    (found,) = directions(SPEED_OF_SOUND * arrivals.times[None], array.offsets)
    length = float(np.linalg.norm(found))
    if array.dimensions == 3:
        return np.asarray(found / max(length, 1e-9))
    across = array.extents[1][array.dimensions :]
    aside = across[int(np.abs(across[:, 2]).argmax())]
    aside = aside if aside[2] >= 0 else -aside
    return np.asarray(found / max(length, 1.0) + np.sqrt(max(0.0, 1 - length**2)) * aside)


def calibrate(claps: Sequence[Clap], array: MicrophoneArray) -> Calibration:
    """Calibrate ``array``, the configured one, by ``claps`` around it. Raises NotEnough."""
    if (array.dimensions == 1 and len(array) < 4) or len(array) < LEAST_MICROPHONES:
        raise NotEnough(
            f"the array has {len(array)} microphones{' on a line' if array.dimensions == 1 else ''}: sound shows the "
            f"shape of {LEAST_MICROPHONES} and more, of 4 and more on a line"
        )
    longest_s = longest_lag_s(array)
    all_heard = [arrivals_of(clap, longest_s) for clap in claps]
    faults = faults_of(all_heard, array.positions)
    whole = np.array([channel for channel in range(len(array)) if not faults[channel].silences])
    if len(whole) < LEAST_MICROPHONES:
        names = "; ".join(f"channel {channel} {fault.words}" for channel, fault in enumerate(faults) if fault.words)
        raise NotEnough(f"only {len(whole)} of {len(array)} microphones can be used: {names}")
    if len(whole) < len(array):
        cut = [Clap(one.at_s, one.sound[:, whole], one.rate, one.onset, one.clipped) for one in claps]
        heard = [arrivals_of(clap, longest_s) for clap in cut]
    else:
        heard = all_heard
    clear = [row for row, one in enumerate(heard) if np.median(one.agreement) >= AGREEING]
    clear = sorted(sorted(clear, key=lambda row: -float(np.median(heard[row].agreement)))[:MOST])
    if len(clear) < LEAST:
        raise NotEnough(
            f"{len(clear)} of {len(claps)} claps are clear at the microphones; at least {LEAST} are needed, and "
            f"{ENOUGH} and more are better"
        )
    times = SPEED_OF_SOUND * np.array([heard[row].times for row in clear])
    kept = [claps[row] for row in clear]
    solution = _solve(times, array.positions[whole], array)
    return _report(
        array, kept, whole=whole, solution=solution, heard=[all_heard[row] for row in clear],
        faults=[fault.words for fault in faults],
    )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class _Solution:
    """``order`` of the channels used, ``prior`` (in this order) and the ``fit``, about ``middle`` (3,) m; the
    held-out errors (m)."""

    order: tuple[int, ...]
    prior: Geometry
    middle: NDArray[np.float64]
    fit: Fit
    before_m: float
    after_m: float


def geometry(positions: NDArray[np.float64], body_m: float) -> Geometry:
    """What a configuration says of microphones at ``positions`` (M, 3) m."""
    array = MicrophoneArray(positions, body_m=body_m)
    return Geometry(array.offsets, array.extents[1], array.dimensions, body_m)


def _solve(times: NDArray[np.float64], configured: NDArray[np.float64], array: MicrophoneArray) -> _Solution:
    """By arrival times (K, M) m at the microphones ``configured`` (M, 3), which may be some of the array's."""
    asis = tuple(range(len(configured)))
    order, fit = asis, _best_fit(times, geometry(configured, array.body_m))
    if _is_off(fit, configured):
        order, fit = _reordered(times, configured, array.body_m, fit)
    prior = geometry(configured[list(order)], array.body_m)
    before, after = [], []
    for fold in range(2):
        seen, unseen = times[fold::2], times[1 - fold :: 2]
        found = refine(seen, _not_too_small(seen, prior), start=fit.positions)
        before.append(_typical(refine(unseen, geometry(configured, array.body_m), prior_m=0.0).residuals))
        after.append(_typical(refine(unseen, _at(prior, found.positions), prior_m=0.0).residuals))
    middle = configured.mean(axis=0)
    return _Solution(order, prior, middle, fit, before_m=float(np.mean(before)), after_m=float(np.mean(after)))


def _not_too_small(times: NDArray[np.float64], prior: Geometry) -> Geometry:
    """``prior``, of a plane array made larger if no direction would make differences of arrival times so large."""
    longest = float(np.median(np.linalg.norm(directions(times, prior.positions), axis=1)))
    if prior.dimensions != 2 or longest < _TOO_SMALL:
        return prior
    return _at(prior, prior.positions * longest)


def _best_fit(times: NDArray[np.float64], prior: Geometry) -> Fit:
    """The fit from the prior positions or, where the sound alone shows a structure, from that: the better one."""
    prior = _not_too_small(times, prior)
    fits = [refine(times, prior)]
    if prior.dimensions == 3 and (found := affine_structure(times)) is not None:
        fits.append(refine(times, prior, start=aligned(found, prior.positions, mirror=True)))
    return min(fits, key=lambda fit: fit.cost)


def _is_off(fit: Fit, configured: NDArray[np.float64]) -> bool:
    apart = np.linalg.norm(configured[:, None] - configured[None], axis=2)
    nearest = float(apart[np.triu_indices(len(configured), 1)].min())
    return _moved(fit, configured) > _OFF * nearest or _typical(fit.residuals) > _OFF_M


def _reordered(
    times: NDArray[np.float64], configured: NDArray[np.float64], body_m: float, asis: Fit
) -> tuple[tuple[int, ...], Fit]:
    """The order by which microphones are nearest to their places; of equals, the one that moves fewest channels."""
    own = tuple(range(len(configured)))
    fits = {own: asis}
    for order in likely_orders(times, configured, _ORDERS):
        if order not in fits:
            fits[order] = refine(times, _not_too_small(times, geometry(configured[list(order)], body_m)))
    moved = {order: _moved(fit, configured[list(order)]) for order, fit in fits.items()}
    alike = [order for order in fits if moved[order] <= _ALIKE * min(moved.values()) + _ALIKE_M]
    order = min(alike, key=lambda one: (sum(a != b for a, b in zip(one, own, strict=True)), fits[one].cost))
    return order, _best_fit(times, geometry(configured[list(order)], body_m))


def _moved(fit: Fit, configured: NDArray[np.float64]) -> float:
    """RMS distance (m) of the microphones from their places."""
    offsets = configured - configured.mean(axis=0)
    return float(np.sqrt(((fit.positions - offsets) ** 2).sum(axis=1).mean()))


def _at(prior: Geometry, positions: NDArray[np.float64]) -> Geometry:
    return Geometry(positions, prior.axes, prior.dimensions, prior.body_m)


def _typical(residuals: NDArray[np.float64]) -> float:
    """A robust standard deviation."""
    return 1.48 * float(np.median(np.abs(residuals)))


def _report(
    array: MicrophoneArray,
    claps: Sequence[Clap],
    *,
    whole: NDArray[np.int64],
    solution: _Solution,
    heard: Sequence[Arrivals],
    faults: Sequence[str],
) -> Calibration:
    fit = solution.fit
    count = len(array)
    places = array.positions.copy()
    places[whole] = fit.positions + solution.middle
    sources = fit.directions * fit.ranges[:, None] + solution.middle
    ways = np.linalg.norm(sources[:, None] - places, axis=2)
    gains, gain_deviations = gains_db(heard, ways)
    noise = 10 * np.log10(np.median([one.noise for one in heard], axis=0) + 1e-13)
    residuals, deviations = np.full(count, np.nan), np.full(count, np.nan)
    believed = np.maximum(fit.weights, 1e-9)
    residuals[whole] = np.sqrt((believed * fit.residuals**2).sum(axis=0) / believed.sum(axis=0)) / SPEED_OF_SOUND
    deviations[whole] = fit.deviations
    order = np.arange(count)
    order[whole] = whole[list(solution.order)]
    moved = np.linalg.norm(places - array.positions[order], axis=1)
    moved[[channel for channel in range(count) if channel not in whole]] = np.nan
    microphones = tuple(
        MicrophoneResult(
            channel,
            (float(places[channel, 0]), float(places[channel, 1]), float(places[channel, 2])),
            moved_m=float(moved[channel]),
            deviation_m=float(deviations[channel]),
            residual_s=float(residuals[channel]),
            gain_db=float(gains[channel]),
            gain_deviation_db=float(gain_deviations[channel]),
            noise_db=float(noise[channel]),
            fault=faults[channel],
        )
        for channel in range(count)
    )
    used = fit.weights.mean(axis=1) > BELIEVED
    rms = np.sqrt((fit.residuals**2).mean(axis=1)) / SPEED_OF_SOUND
    results = tuple(
        ClapResult(
            clap.at_s,
            azimuth_deg=float(np.degrees(np.arctan2(toward[1], toward[0]))),
            elevation_deg=float(np.degrees(np.arcsin(np.clip(toward[2], -1, 1)))),
            range_m=float(fit.ranges[row]),
            residual_s=float(rms[row]),
            used=bool(used[row]),
            clipped=clap.clipped,
        )
        for row, (clap, toward) in enumerate(zip(claps, fit.directions, strict=True))
    )
    reordered = order.tolist() != list(range(count))
    verdict, reasons = judge(
        fit, geometry(array.positions[whole], array.body_m), solution.before_m, solution.after_m, reordered=reordered
    )
    return Calibration(
        microphones,
        results,
        order=tuple(order.tolist()) if reordered else None,
        held_out_before_s=solution.before_m / SPEED_OF_SOUND,
        held_out_after_s=solution.after_m / SPEED_OF_SOUND,
        verdict=verdict,
        reasons=reasons,
        unseen=unseen_of(array.dimensions),
    )
