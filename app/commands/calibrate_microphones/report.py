"""The report of ``hbba calibrate microphones``: for people, and as one document."""

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

from app.commands.calibrate_microphones.arrays import ConfiguredArray
from app.commands.output import aligned
from app.modules.perception.voices.array_calibration.results import Calibration, Verdict
from app.modules.perception.voices.steering_vectors import SPEED_OF_SOUND

_VERDICTS = {
    Verdict.ADOPT: "Adopt these positions",
    Verdict.KEEP: "Keep the configured positions",
    Verdict.REPEAT: "Do not adopt this: clap again",
}
#: Levels that differ by more (dB) are worth a look at the sound card's mixer.
_UNEVEN_DB = 3.0


def document_of(configured: ConfiguredArray, heard: int, result: Calibration) -> dict[str, Any]:
    """All of it for programs; lengths in m, times in s, levels in dB."""
    return {
        "array": configured.name,
        "claps_heard": heard,
        "verdict": result.verdict.value,
        "reasons": result.reasons,
        "not_shown_by_sound": result.unseen,
        "order": result.order,
        "held_out_before_s": result.held_out_before_s,
        "held_out_after_s": result.held_out_after_s,
        "positions": result.positions.round(4).tolist(),
        "microphones": [asdict(one) for one in result.microphones],
        "claps": [asdict(one) for one in result.claps],
    }


def print_report(configured: ConfiguredArray, heard: int, result: Calibration, written: Path | None) -> None:
    """The same for people."""
    used = sum(clap.used for clap in result.claps)
    print(f"{configured.name}: {len(result.microphones)} microphones, {heard} claps, {used} of them used")
    print()
    print("\n".join(_clap_rows(result)))
    print()
    print("\n".join(_microphone_rows(result)))
    for line in _remarks(result):
        print(line)
    print()
    print(f"{_VERDICTS[result.verdict]}: {'; '.join(result.reasons)}.")
    for unseen in result.unseen:
        print(f"Sound does not show {unseen}.")
    if result.verdict is not Verdict.KEEP:
        print()
        print("\n".join(fragment(result)))
    if written is not None:
        print(f"\nWritten: {written}")
    elif result.verdict is Verdict.ADOPT and configured.file is not None:
        print(f"\nNothing is written; --write puts the positions into {configured.file}")


def fragment(result: Calibration) -> list[str]:
    """The lines of YAML that configure the positions."""
    lines = ["positions:"]
    for one in result.microphones:
        place = ", ".join(f"{value:.4f}" for value in one.position)
        remark = "as it was: not measured" if math.isnan(one.residual_s) else f"± {1e3 * one.deviation_m:.1f} mm"
        lines.append(f"  - [{place}]   # {remark}")
    return lines


def _clap_rows(result: Calibration) -> list[str]:
    rows = [("clap", "at s", "azimuth °", "elevation °", "error µs", "")]
    for number, clap in enumerate(result.claps, 1):
        notes = [*([] if clap.used else ["not used"]), *(["clipped"] if clap.clipped else [])]
        rows.append(
            (
                str(number),
                f"{clap.at_s:.1f}",
                f"{clap.azimuth_deg:.0f}",
                f"{clap.elevation_deg:.0f}",
                f"{1e6 * clap.residual_s:.1f}",
                ", ".join(notes),
            )
        )
    return aligned(rows, right=range(5))


def _microphone_rows(result: Calibration) -> list[str]:
    rows: list[tuple[str, ...]] = [
        (
            "channel",
            "x m",
            "y m",
            "z m",
            "moved mm",
            "± mm",
            "error µs",
            "= mm",
            "level dB",
            "± dB",
            "noise dB",
            "place",
        )
    ]
    for one in result.microphones:
        place = "" if result.order is None else f"configured as {result.order[one.channel]}"
        rows.append(
            (
                str(one.channel),
                *(f"{value:.4f}" for value in one.position),
                _number(1e3 * one.moved_m),
                _number(1e3 * one.deviation_m),
                _number(1e6 * one.residual_s),
                _number(1e3 * SPEED_OF_SOUND * one.residual_s, 2),
                _number(one.gain_db),
                _number(one.gain_deviation_db),
                _number(one.noise_db, 0),
                place,
            )
        )
    return aligned(rows, right=range(11))


def _remarks(result: Calibration) -> list[str]:
    lines = [f"Channel {one.channel} {one.fault}." for one in result.microphones if one.fault]
    if result.order is not None:
        moved = [channel for channel, place in enumerate(result.order) if place != channel]
        lines.append(
            f"The channels are in another order than configured: {', '.join(map(str, moved))} are the microphones "
            f"configured as {', '.join(str(result.order[channel]) for channel in moved)}."
        )
    gains = [one.gain_db for one in result.microphones if not math.isnan(one.gain_db)]
    if gains and max(gains) - min(gains) > _UNEVEN_DB:
        lines.append(
            f"Levels differ by {max(gains) - min(gains):.1f} dB. Directions do not depend on them; where the sound "
            "card has a gain for each channel, set them alike."
        )
    if sum(clap.clipped for clap in result.claps) > len(result.claps) / 2:
        lines.append("Most claps reach full scale: clap farther away, or turn the microphones down.")
    return lines


def _number(value: float, digits: int = 1) -> str:
    return "–" if math.isnan(value) else f"{value:.{digits}f}"
