"""Self check of a map: consistency by its own data, without ground truth.

Keyframes are in the order of time. At each cut between consecutive keyframes, views from before are compared with views
from after (``scan_overlap``). After a break of the map (wheel slip, a gap in the log, a wrong match) views from both
sides contradict wherever they overlap; without overlap only odometry connects the two parts, and their relative pose is
unknown.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from app.modules.perception.slam.offline_mapping import MappedLog
from app.modules.perception.slam.pose_graph import graph_arrays, uncertainties
from app.modules.perception.slam.scan_overlap import Pairs, compared
from app.modules.perception.slam.types import Keyframe

#: ``yes``: no inconsistency; ``no``: the data contradict the map; ``unknown``: not decidable.
Intact = Literal["yes", "no", "unknown"]


@dataclass(frozen=True, slots=True)
class CheckSettings:
    #: Share of contradicting among deciding pairs across a cut from which the map is broken. Intact maps of the public
    #: logs have at most 0.3, broken ones at least 0.6.
    contradicting: float = 0.4
    #: Least number of contradicting pairs: a few are moved furniture.
    least_contradicting: int = 10
    #: Agreeing pairs across a cut below which the two parts are unconnected.
    least_agreeing: int = 5
    #: Least number of keyframes of a reported part.
    least_keyframes: int = 5
    #: Share of misfitting scans from which the poses are doubtful.
    unmatched_share: float = 0.01
    #: A match farther than this (m, rad) from odometry ...
    surprising_m: float = 1.0
    surprising_rad: float = 0.5
    #: ... needs this many agreeing pairs across it that are not neighbours in time.
    least_confirming: int = 5
    #: Standard deviation of a keyframe (m, by the whole graph) from which it is doubtful.
    unsure_m: float = 1.0


@dataclass(frozen=True, slots=True)
class Inconsistency:
    """One finding against a map, before the keyframe of index ``keyframe``; −1: not at one place."""

    intact: Intact
    keyframe: int
    text: str


@dataclass(frozen=True, slots=True, eq=False)
class Cuts:
    """For the cut before each keyframe (N,): numbers of pairs of views across it that agree, that contradict, and that
    agree although far apart in time."""

    agreeing: NDArray[np.int64]
    contradicting: NDArray[np.int64]
    confirming: NDArray[np.int64]


#: Distance in keyframes beyond which two are no neighbours: no submap contains both.
_NEIGHBOURS = 48


def cuts_of(pairs: Pairs, keyframes: int) -> Cuts:
    """Number of ``pairs`` across each cut."""
    apart = pairs.second - pairs.first > _NEIGHBOURS
    return Cuts(
        _across(pairs, pairs.agree, keyframes),
        _across(pairs, pairs.contradict, keyframes),
        _across(pairs, pairs.agree & apart, keyframes),
    )


def _across(pairs: Pairs, chosen: NDArray[np.bool_], keyframes: int) -> NDArray[np.int64]:
    steps = np.zeros(keyframes + 1, np.int64)
    np.add.at(steps, pairs.first[chosen] + 1, 1)
    np.add.at(steps, pairs.second[chosen] + 1, -1)
    found: NDArray[np.int64] = np.cumsum(steps)[:keyframes]
    return found


def view_inconsistencies(
    keyframes: Sequence[Keyframe],
    poses: NDArray[np.float64],
    surprises: Sequence[tuple[int, float, float]] = (),
    settings: CheckSettings | None = None,
) -> list[Inconsistency]:
    """Findings of the views of ``keyframes`` at ``poses`` (N, 3): the worst place of each kind.

    ``surprises``: by keyframe, distance (m, rad) of a match from odometry just before it.
    """
    settings = settings or CheckSettings()
    cuts = cuts_of(compared(keyframes, poses), len(keyframes))
    inner = slice(settings.least_keyframes, max(len(keyframes) - settings.least_keyframes + 1, 0))
    inconsistencies: list[Inconsistency] = []
    agreeing, contradicting = cuts.agreeing[inner], cuts.contradicting[inner]
    if not len(agreeing):
        return inconsistencies
    share = contradicting / np.maximum(agreeing + contradicting, 1)
    share[contradicting < settings.least_contradicting] = 0.0
    worst = int(np.argmax(share))
    if share[worst] > settings.contradicting:
        both = int(agreeing[worst] + contradicting[worst])
        inconsistencies.append(
            Inconsistency(
                "no",
                inner.start + worst,
                f"what was seen before and after contradicts: {contradicting[worst]} of {both} pairs of views see "
                "through each other's walls",
            )
        )
    loose = np.flatnonzero(agreeing < settings.least_agreeing)
    if loose.size and not inconsistencies:
        at = inner.start + int(loose[np.argmin(agreeing[loose])])
        inconsistencies.append(
            Inconsistency(
                "unknown", at, "odometry alone holds what was seen before and after together: no view shows both"
            )
        )
    for keyframe, off_m, off_rad in surprises:
        far = off_m > settings.surprising_m or off_rad > settings.surprising_rad
        if far and 0 < keyframe < len(keyframes) and cuts.confirming[keyframe] < settings.least_confirming:
            inconsistencies.append(
                Inconsistency(
                    "unknown",
                    keyframe,
                    f"a scan was matched {off_m:.1f} m and {np.degrees(off_rad):.0f}° from where odometry led, and no "
                    "later visit confirms it",
                )
            )
            break
    return inconsistencies


@dataclass(frozen=True, slots=True)
class CheckResult:
    """Whether a map is ``intact``, the reasons in words, and each keyframe's standard deviation by the whole graph
    (m)."""

    intact: Intact
    inconsistencies: tuple[str, ...]
    sigmas_m: Mapping[int, float]


def checked(log: MappedLog, settings: CheckSettings | None = None) -> CheckResult:
    """Check the map of a whole log with at least one used scan."""
    settings = settings or CheckSettings()
    state = log.slam.state()
    ids = [keyframe.id for keyframe in state.keyframes]
    order = {id: number for number, id in enumerate(ids)}
    poses = np.array([(p.x, p.y, p.theta) for p in state.poses])
    # Removed keyframes count with the next remaining one.
    surprises = [
        (int(np.searchsorted(ids, row.keyframe)), *row.off)
        for row in log.rows
        if row.off[0] > settings.surprising_m or row.off[1] > settings.surprising_rad
    ]
    inconsistencies = view_inconsistencies(state.keyframes, poses, surprises, settings)
    sigmas = uncertainties(graph_arrays(dict(zip(ids, state.poses, strict=True)), state.edges))
    unsure = int(np.argmax(sigmas))
    if sigmas[unsure] > settings.unsure_m:
        count = int((sigmas > settings.unsure_m).sum())
        text = f"where {count} of {len(ids)} keyframes are is known to no better than ±{sigmas[unsure]:.1f} m"
        inconsistencies.append(Inconsistency("unknown", unsure, text))
    unmatched = log.unmatched()
    if unmatched > settings.unmatched_share * len(log.rows):
        share = 100 * unmatched / len(log.rows)
        inconsistencies.append(Inconsistency("unknown", -1, f"{unmatched} scans ({share:.1f} %) did not fit the map"))
    scans = {order[row.keyframe]: row for row in reversed(log.rows) if row.keyframe in order}
    said = []
    for doubt in inconsistencies:
        row = scans.get(doubt.keyframe)
        said.append(doubt.text if row is None else f"at scan {row.number} ({row.stamp:.1f} s): {doubt.text}")
    intact: Intact = "no" if any(d.intact == "no" for d in inconsistencies) else "unknown" if inconsistencies else "yes"
    return CheckResult(intact, tuple(said), dict(zip(ids, sigmas.tolist(), strict=True)))
