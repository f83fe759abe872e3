"""The figures of a mapped log: how much, how fast, how well."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from app.base.errors import ConfigError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from app.commands.slam.sweeps import SweepSource
    from app.commands.slam.truth import Reference, Relations
    from app.modules.perception.slam.offline_mapping import MappedLog
    from app.modules.perception.slam.self_check import CheckResult

#: A time of a relation or reference names a scan not farther away than this (s).
_SAME_S = 0.05
#: Beyond this distance (m) a relation between poses from odometry concerns the map, too.
GROSS_M = 0.5


def figures(
    source: SweepSource,
    log: MappedLog,
    phi: int,
    check: CheckResult,
    relations: Relations | None,
    reference: Reference | None,
) -> dict[str, Any]:
    """The whole report, for JSON. Raises ConfigError if relations or reference are of another log."""
    from app.modules.perception.slam.relations import filled_in

    scan_ms = 1e3 * np.array(log.scan_s)
    poses = log.poses()
    whole = np.array(list(check.sigmas_m.values()))
    document: dict[str, Any] = {
        "log": str(source.path),
        "notes": source.notes,
        "phi": phi,
        "scans": log.scans,
        "taken": len(log.rows),
        "path_m": round(float(np.hypot(*np.diff(poses[:, :2], axis=0).T).sum()), 1),
        "keyframes": len(log.slam.keyframes),
        "loops": log.slam.loops,
        "unmatched": log.unmatched(),
        "sigma_m": _rounded(np.hypot(log.sigmas()[:, 0], log.sigmas()[:, 1]), 4),
        "map_sigma_m": _rounded(whole, 4) if np.isfinite(whole).all() else None,
        "cpu_s": round(log.cpu_s, 2),
        "loops_cpu_s": round(log.jobs_s, 2),
        "scan_ms": _rounded(scan_ms, 3),
    }
    everywhere = filled_in(log.numbers(), poses, log.odometry_poses())
    if relations is not None:
        document["relations"] = _related(source, log, everywhere, relations)
    if reference is not None:
        document["reference"] = _compared(source, log, poses, reference)
    gross = _gross(document)
    doubts = [f"{gross} relations are wrong by more than 0.5 m or 5°"] if gross else []
    document["intact"] = "no" if gross else check.intact
    document["doubts"] = [*doubts, *check.inconsistencies]
    return document


def _rounded(values: NDArray[np.float64], digits: int) -> dict[str, float]:
    return {
        "mean": round(float(values.mean()), digits),
        "p99": round(float(np.percentile(values, 99)), digits),
        "max": round(float(values.max()), digits),
    }


def _related(
    source: SweepSource, log: MappedLog, everywhere: NDArray[np.float64], relations: Relations
) -> dict[str, Any]:
    from app.modules.perception.slam.relations import relation_errors

    first, second = (_rows(source, log, ends, relations) for ends in (relations.first, relations.second))
    known = (first >= 0) & (second >= 0)
    if not known.any():
        raise ConfigError(f"--relations: {relations.path} names no scan of {source.path}")
    first, second = first[known], second[known]
    errors = relation_errors(everywhere[first], everywhere[second], relations.measured[known])
    taken = np.zeros(log.scans, np.bool_)
    taken[log.numbers()] = True
    rounded = {name: round(value, 5) for name, value in asdict(errors).items()}
    return {"file": str(relations.path), **rounded, "between_taken": int((taken[first] & taken[second]).sum())}


def _rows(source: SweepSource, log: MappedLog, ends: NDArray[np.float64], relations: Relations) -> NDArray[np.int64]:
    """Scans of the log by number; −1 where a time has none. Raises ConfigError for a number that there is not."""
    if relations.timed:
        return _nearest(np.array([row.stamp for row in log.rows]), log.numbers(), ends)
    rows = ends.astype(np.int64)
    if (rows != ends).any() or (rows < 0).any():
        raise ConfigError(f"--relations: {relations.path}: scans are numbered 0, 1, 2 …")
    if (rows >= log.scans).any():
        raise ConfigError(
            f"--relations: {relations.path} names scan {rows.max()}, but {source.path} has {log.scans} scans"
        )
    return rows


def _nearest(stamps: NDArray[np.float64], numbers: NDArray[np.int64], wanted: NDArray[np.float64]) -> NDArray[np.int64]:
    after = np.searchsorted(stamps, wanted).clip(1, max(1, len(stamps) - 1))
    nearest = np.where(
        np.abs(stamps[after - 1] - wanted) <= np.abs(stamps[after % len(stamps)] - wanted), after - 1, after
    )
    nearest = nearest.clip(max=len(stamps) - 1)
    return np.where(np.abs(stamps[nearest] - wanted) <= _SAME_S, numbers[nearest], -1)


def _compared(source: SweepSource, log: MappedLog, poses: NDArray[np.float64], reference: Reference) -> dict[str, Any]:
    from app.modules.perception.slam.relations import trajectory_error

    place = {key: row for row, key in enumerate(source.keys)}
    by_number = {int(number): row for row, number in enumerate(log.numbers())}
    pairs = [
        (by_number[place[key]], row)
        for row, key in enumerate(reference.keys)
        if key in place and place[key] in by_number
    ]
    if len(pairs) < 3 and source.timed and reference.timed:
        numbers = _nearest(log.stamps(), np.arange(len(log.rows)), reference.stamps)
        pairs = [(int(number), row) for row, number in enumerate(numbers) if number >= 0]
    if len(pairs) < 3:
        raise ConfigError(f"--reference: {reference.path} shares {len(pairs)} scans with {source.path}; 3 are needed")
    ours, theirs = (np.array(rows) for rows in zip(*pairs, strict=True))
    mean, rmse, most = (round(error, 4) for error in trajectory_error(poses[ours], reference.poses[theirs]))
    return {"file": str(reference.path), "scans": len(pairs), "mean_m": mean, "rmse_m": rmse, "max_m": most}


def _gross(document: dict[str, Any]) -> int:
    """Gross relations that concern the map: between scans that were not matched, a wrong angle alone is odometry's."""
    related = document.get("relations")
    if related is None or (document["phi"] > 1 and related["max_m"] <= GROSS_M):
        return 0
    return int(related["gross"])


def print_figures(document: dict[str, Any]) -> None:
    """The same as a table."""
    ms, sigma, whole = document["scan_ms"], document["sigma_m"], document["map_sigma_m"]
    rows = [
        ("scans", f"{document['taken']} of {document['scans']} (φ = {document['phi']}), {document['path_m']:.0f} m"),
        ("map", f"{document['keyframes']} keyframes, {document['loops']} loops closed"),
        ("a scan", f"mean {ms['mean']:.2f} ms, p99 {ms['p99']:.2f} ms, greatest {ms['max']:.1f} ms of CPU"),
        ("all", f"{document['cpu_s']:.1f} s of CPU, {document['loops_cpu_s']:.1f} s of it for loops"),
        ("believed", f"±{sigma['mean']:.3f} m on average on the map around, p99 {sigma['p99']:.3f} m"),
    ]
    if whole is not None:
        rows.append(("", f"±{whole['mean']:.3f} m on average on the whole map, greatest {whole['max']:.3f} m"))
    if "relations" in document:
        r = document["relations"]
        metres = f"{r['mean_m']:.4f} ± {r['sd_m']:.4f} m, greatest {r['max_m']:.2f} m"
        degrees = f"{r['mean_deg']:.3f} ± {r['sd_deg']:.3f}°, greatest {r['max_deg']:.1f}°"
        rows.append(("relations", f"{metres}; {degrees}; {r['gross']} of {r['relations']} gross"))
    if "reference" in document:
        r = document["reference"]
        rows.append(
            (
                "reference",
                f"{r['mean_m']:.3f} m off ({r['scans']} scans; rms {r['rmse_m']:.3f}, greatest {r['max_m']:.2f})",
            )
        )
    print(document["log"])
    for note in document["notes"]:
        print(f"  {note}")
    for name, text in rows:
        print(f"  {name:<10} {text}")
    print(f"  {'intact':<10} {'; '.join([document['intact'], *document['doubts']])}")
    for path in document.get("written", ()):
        print(f"  written    {path}")
