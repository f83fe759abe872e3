"""The report about sources in a recording: a table, or JSON, and the sound of each in a file of its own."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.base.errors import ConfigError
from app.commands.output import aligned

if TYPE_CHECKING:
    from app.messages import SeparatedSound, SoundSource, SoundSources

#: A track is reported as moving if its direction changed by more (degrees).
MOVED_DEG = 15.0


@dataclass(slots=True)
class TrackSummary:
    """Summary of one track."""

    begin_s: float
    end_s: float = 0.0
    active: int = 0
    voice: int = 0
    judged: int = 0
    power: float = 0.0
    directions: list[tuple[float, float, float]] = field(default_factory=list)
    ranges: list[float] = field(default_factory=list)
    file: str | None = None

    def add(self, time_s: float, source: SoundSource) -> None:
        if not source.active:
            return
        self.end_s = time_s
        self.active += 1
        self.power += 10 ** (source.level_db / 10)
        self.directions.append(source.direction)
        self.ranges.append(source.range_m)
        if not math.isnan(source.speech):
            self.judged += 1
            self.voice += source.speech > 0.5


class Writer:
    """The sound of each source in a file of its own, from its first separation on."""

    def __init__(self, folder: Path, stem: str) -> None:
        self._folder, self._stem = folder, stem
        self._open: dict[int, Any] = {}
        self._begun: dict[int, int] = {}
        self.files: dict[int, str] = {}

    def write(self, separated: SeparatedSound) -> None:
        """Append a block; where a source was not separated for a while, there is silence. Raises ConfigError."""
        import numpy as np
        import soundfile

        for track in self._open.keys() - set(separated.tracks):
            self._open.pop(track).close()
        for column, track in enumerate(separated.tracks):
            path = self._folder / f"{self._stem}.source{track}.wav"
            try:
                if track not in self.files:
                    self._open[track] = soundfile.SoundFile(path, "w", separated.rate, 1, "PCM_16")
                    self._begun[track], self.files[track] = separated.first_sample, str(path)
                elif track not in self._open:
                    self._open[track] = soundfile.SoundFile(path, "r+")
                file = self._open[track]
                file.seek(0, 2)
                missing = separated.first_sample - self._begun[track] - file.frames
                file.write(np.zeros(max(0, missing), np.int16))
                file.write(separated.samples[:, column])
            except (soundfile.LibsndfileError, OSError) as failure:
                raise ConfigError(f"--separate: {path} cannot be written: {failure}") from None

    def close(self) -> None:
        """Complete the files."""
        for file in self._open.values():
            file.close()
        self._open.clear()


# --- report ---


def _angles(direction: tuple[float, float, float]) -> tuple[float, float]:
    x, y, z = direction
    return math.degrees(math.atan2(y, x)), math.degrees(math.atan2(z, math.hypot(x, y)))


def percept(sources: SoundSources, ranges: bool) -> dict[str, Any]:
    """One line of the timeline."""
    rows = []
    for source in sources.sources:
        azimuth, elevation = _angles(source.direction)
        row: dict[str, Any] = {
            "track": source.track,
            "azimuth_deg": round(azimuth, 2),
            "elevation_deg": round(elevation, 2),
            "power": round(source.power, 4),
            "level_db": round(source.level_db, 1),
            "active": source.active,
            "speech": None if math.isnan(source.speech) else round(source.speech, 3),
        }
        if ranges:
            row |= {"range_m": round(source.range_m, 2), "range_sigma_m": round(source.range_sigma_m, 2)}
        rows.append(row)
    return {"time_s": round(sources.stamp, 4), "sources": rows}


def summary(track: int, heard: TrackSummary, ranges: bool) -> dict[str, Any]:
    """The summary of one track as a line."""
    import numpy as np

    directions = np.array(heard.directions)
    tenth = max(1, len(directions) // 10)
    mean = directions.mean(axis=0)
    (azimuth, elevation), (first, _), (last, _) = (
        _angles((float(x), float(y), float(z)))
        for x, y, z in (mean, directions[:tenth].mean(axis=0), directions[-tenth:].mean(axis=0))
    )
    row: dict[str, Any] = {
        "track": track,
        "begin_s": round(heard.begin_s, 3),
        "end_s": round(heard.end_s, 3),
        "azimuth_deg": round(azimuth, 1),
        "elevation_deg": round(elevation, 1),
        "azimuth_first_deg": round(first, 1),
        "azimuth_last_deg": round(last, 1),
        "voice": round(heard.voice / heard.judged, 3) if heard.judged else None,
        "level_db": round(10 * math.log10(max(heard.power / heard.active, 1e-12)), 1),
    }
    if ranges:
        row["range_m"] = round(float(np.median(heard.ranges)), 2)
    return row | ({"file": heard.file} if heard.file is not None else {})


def print_tables(documents: list[dict[str, Any]]) -> None:
    for document in documents:
        if "error" in document:
            continue
        tracks = document["tracks"]
        voices = sum((track["voice"] or 0) > 0.5 for track in tracks)
        print(
            f"{document['file']}: {document['duration_s']:.1f} s, {len(tracks)} source{'s' * (len(tracks) != 1)}, "
            f"{voices} of them voice{'s' * (voices != 1)}"
        )
        ranges = any("range_m" in track for track in tracks)
        head = ("source", "from s", "to s", "azimuth", "elevation", "voice", "level", "distance" if ranges else "")
        rows: list[tuple[str, ...]] = [head]
        for track in tracks:
            voice = "" if track["voice"] is None else f"{100 * track['voice']:.0f} %"
            first, last = track["azimuth_first_deg"], track["azimuth_last_deg"]
            moved = abs((last - first + 180) % 360 - 180) > MOVED_DEG
            azimuth = f"{first:.0f}° to {last:.0f}°" if moved else f"{track['azimuth_deg']:.0f}°"
            distance = f"{track['range_m']:.1f} m" if "range_m" in track else ""
            rows.append(
                (
                    str(track["track"]),
                    f"{track['begin_s']:.1f}",
                    f"{track['end_s']:.1f}",
                    azimuth,
                    f"{track['elevation_deg']:.0f}°",
                    voice,
                    f"{track['level_db']:.0f} dB",
                    distance,
                )
            )
        if tracks:
            print(*(f"  {line}" for line in aligned(rows, range(len(head)))), sep="\n")
