"""Whether a map is whole, as far as its own data can say: no truth is needed.

Keyframes are in the order of time. The map is split between each two of them: what was seen before
is compared with what was seen after (``views``). Where the map broke, at a slip, a hole in the log, a scan that was
matched in the wrong place, views from both sides contradict each other wherever they meet again; where they do not
meet at all, nothing but odometry holds the two parts together, and how they lie to each other is not known.
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

#: ``yes``: nothing speaks against it; ``no``: the data contradict the map; ``unknown``: they cannot say.
Intact = Literal["yes", "no", "unknown"]


@dataclass(frozen=True, slots=True)
class CheckSettings:
    """From where on a map is doubted."""

    #: Of the pairs of views from both sides of a cut that agree or contradict, more than this share contradict: the
    #: map is broken. On whole maps of the public logs it is at most 0.3, on broken ones at least 0.6.
    contradicting: float = 0.4
    #: ... where so many pairs do: a few are moved furniture.
    least_contradicting: int = 10
    #: Fewer agreeing pairs than this across a cut: nothing holds the two parts together.
    least_agreeing: int = 5
    #: A part of fewer keyframes than this is not worth a word.
    least_keyframes: int = 5
    #: More scans than this share did not fit: of where they were, little is known.
    unmatched_share: float = 0.01
    #: A scan matched farther than this (m, rad) from where odometry led, ...
    surprising_m: float = 1.0
    surprising_rad: float = 0.5
    #: ... must be confirmed by so many pairs of views, from both sides, that are not neighbours on the way.
    least_confirming: int = 5
    #: A keyframe is less surely known than this (m, standard deviation, by the whole graph).
    unsure_m: float = 1.0


@dataclass(frozen=True, slots=True)
class Inconsistency:
    """What speaks against a map, before ``keyframe`` by number in their order; −1: in no one place."""

    intact: Intact
    keyframe: int
    text: str


@dataclass(frozen=True, slots=True, eq=False)
class Cuts:
    """Of the cut before each keyframe (N,): pairs of views from both sides that agree, that contradict, and that agree
    though the way between them is long.
    """

    agreeing: NDArray[np.int64]
    contradicting: NDArray[np.int64]
    confirming: NDArray[np.int64]


#: Keyframes farther apart than this on the way are no neighbours: they lie in no common submap.
_NEIGHBOURS = 48


def cuts_of(pairs: Pairs, keyframes: int) -> Cuts:
    """How many of ``pairs`` reach over each cut."""
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
    """What views say against ``keyframes`` at ``poses`` (N, 3), of the whole the worst place.

    ``surprises``: keyframe before which a scan was matched so far (m, rad) from where odometry led.
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
    """Whether a map is ``intact``, why not in words, and how surely each keyframe is known by the whole graph (m)."""

    intact: Intact
    inconsistencies: tuple[str, ...]
    sigmas_m: Mapping[int, float]


def checked(log: MappedLog, settings: CheckSettings | None = None) -> CheckResult:
    """Check the map of a whole log, of which at least one scan was taken."""
    settings = settings or CheckSettings()
    state = log.slam.state()
    ids = [keyframe.id for keyframe in state.keyframes]
    order = {id: number for number, id in enumerate(ids)}
    poses = np.array([(p.x, p.y, p.theta) for p in state.poses])
    # Keyframes that were removed since count with the next that was not.
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
