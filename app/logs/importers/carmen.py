"""CARMEN laser logs: text, one message per line, plain or packed by gzip.

Such a log has no index: one pass at its opening counts messages and damage and notes marks where reading can begin.
Memory stays bounded, whatever the log's length.
"""

from __future__ import annotations

import gzip
import math
import statistics
import zlib
from bisect import bisect_left
from collections import Counter
from collections.abc import Collection, Iterator
from copy import deepcopy
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO, cast

import numpy as np

from app.base.geometry import Pose2, Pose3
from app.base.plain_file import open_plain
from app.logs.importers.carmen_clock import ASSUMED_PERIOD_S, Advance, CarmenClock, Clock
from app.logs.importers.carmen_lines import KINDS, CarmenOdometry, CarmenScan, Param, parse
from app.logs.importers.range_limit import FarEnd
from app.logs.log import LogError, Logged, LoggedChannel, LogInfo
from app.logs.manifest import Manifest
from app.logs.stamps import JITTER_S
from app.messages import LaserScan, Odometry, read_only

#: A line is no longer (bytes): a thousand rays take some 20 kB. Of a longer one nothing is read,
_LONGEST_LINE = 1 << 20
#: and one that is longer than this is no line of a log: a packed file may hold gigabytes of nothing.
_NO_LINE = 64_000_000
#: Characters kept of the name of a line and of its mistake, and the number of names kept.
_LONGEST_KIND, _LONGEST_COMPLAINT, _MOST_KINDS = 40, 200, 1_000
#: Bytes between the places where reading may begin.
_MARK_EVERY = 1 << 20
#: A message is logged less than this (s) after its capture.
_LATENCY_S = 1.0
#: Lines that are read to find when a log begins.
_FIRST_LINES = 21
#: From this value (m) on, a reading of SICK's LMS is one of its codes for "nothing seen", in centimetres or
#: millimetres.
_LMS_CODES_CM = 80.0
_LMS_CODES_MM = (8.183, 8.192)
_RANGE_MIN_M = 0.01
#: Which line gives which channel; the first kind that a log has is taken.
_LASERS = {"scan": ("ROBOTLASER1", "FLASER", "RAWLASER1"), "rear_scan": ("ROBOTLASER2", "RLASER", "RAWLASER2")}
_OFFSET_PARAMS = {"scan": "robot_frontlaser_offset", "rear_scan": "robot_rearlaser_offset"}


def is_carmen(head: bytes) -> bool:
    """Whether ``head``, the beginning of a file, is that of a CARMEN log: text whose lines begin with its names."""
    if b"\x00" in head:
        return False
    lines = head.decode("utf-8", "replace").splitlines()
    if len(lines) > 1:
        lines = lines[:-1]  # cut off, perhaps
    first = [line.split(maxsplit=1)[0] for line in lines if line.strip() and not line.startswith("#")]
    if first:
        return first[0] in KINDS | {"SYNC", "TRUEPOS"}
    return any("CARMEN" in line or "message formats defined" in line for line in lines)


@dataclass(frozen=True, slots=True)
class _Mark:
    """A mark where reading can begin: ``offset`` (bytes of text), and the state of the reader there."""

    offset: int
    clock: Clock
    twist: tuple[float, float]


@dataclass(slots=True)
class _Survey:
    """Facts from one pass through a log."""

    marks: list[_Mark]
    kinds: Counter[str] = field(default_factory=Counter)
    untimed: Counter[str] = field(default_factory=Counter)
    malformed: int = 0
    complaint: str = ""
    begin: float = math.inf
    end: float = -math.inf
    params: dict[str, str] = field(default_factory=dict)
    farthest_m: dict[str, float] = field(default_factory=dict)
    far_ends: dict[str, FarEnd] = field(default_factory=dict)
    #: Readings that are no distance, and lines that say no maximum range, by kind.
    blank: Counter[str] = field(default_factory=Counter)
    wordless: Counter[str] = field(default_factory=Counter)
    #: Notes about stamps that go back, and about unusable times.
    back: str = ""
    wrong_times: str = ""
    truncated: str = ""


class CarmenLog:
    """A CARMEN log: channels ``scan`` and, where there is a laser behind, ``rear_scan`` (LaserScan), and ``odometry``.

    A scan's line says where odometry had the robot at its capture: that pose goes to ``odometry`` just before the scan.
    """

    def __init__(self, path: Path) -> None:
        """Go through the log once. Raises LogError where nothing in it can be read."""
        self._path = path
        self._survey = survey = _surveyed(path)
        kinds = survey.kinds
        self._lasers = {
            channel: next((kind for kind in choices if kinds[kind]), None) for channel, choices in _LASERS.items()
        }
        self._channel_of = {kind: channel for channel, kind in self._lasers.items() if kind is not None}
        self._pile_m = {kind: end.limit() for kind, end in survey.far_ends.items() if kind in self._channel_of}
        poses = kinds["ODOM"] + sum(kinds[kind] for kind in self._channel_of if not kind.startswith("RAW"))
        counts = {
            **{channel: (LaserScan, kinds[kind]) for kind, channel in self._channel_of.items()},
            **({"odometry": (Odometry, poses)} if poses else {}),
        }
        if not counts:
            raise LogError(f"{path}: has no line of a laser or of odometry that could be read. {survey.complaint}")
        duration = survey.end - survey.begin
        channels = {
            name: LoggedChannel(name, kind, count, (count - 1) / duration if duration > 0 and count > 1 else None)
            for name, (kind, count) in counts.items()
        }
        #: ``ignored`` also counts the lines that are damaged or have no time.
        self.info = LogInfo(
            path,
            "CARMEN",
            begin=survey.begin,
            end=survey.end,
            channels=channels,
            bytes=path.stat().st_size,
            ignored=self._ignored(),
            notes=self._notes(),
            timed=not survey.wrong_times,
        )
        streams = {"stream.hokuyo": "scan", "stream.odometry": "odometry"}
        self.manifest = Manifest(facts={stream: name for stream, name in streams.items() if name in channels})

    def messages(self, begin: float | None = None, channels: Collection[str] | None = None) -> Iterator[Logged]:
        """Messages from ``begin`` on; the text before it is unpacked but not read. Raises LogError where damaged."""
        mark = self._survey.marks[0]
        if begin is not None:
            # The last mark whose lines are all earlier: marks' clocks do not go back.
            mark = self._survey.marks[max(0, bisect_left(self._survey.marks, begin, key=lambda m: m.clock.at) - 1)]
        wanted = set(self.info.channels if channels is None else channels)
        clock, twist = deepcopy(mark.clock), mark.twist
        for line in self._text(mark.offset):
            try:
                row = parse(line)
            except ValueError:
                continue  # counted when the log was opened
            if row is None or isinstance(row, Param):
                continue
            times = clock.next(row.kind, row.times)
            if times is None:
                continue
            at, stamp = times
            twist = row.twist or twist
            if begin is not None and at < begin:
                continue
            for channel, message in self._messages_of(row, stamp, twist, wanted):
                yield Logged(at, channel, message)

    def close(self) -> None:
        """Nothing is held open between readings."""

    def _text(self, offset: int) -> Iterator[str]:
        try:
            for _, line in _lines(self._path, offset):
                yield line
        except LogError:
            if not self._survey.truncated:  # it was whole when it was opened
                raise

    def _messages_of(
        self, row: CarmenOdometry | CarmenScan, stamp: float, twist: tuple[float, float], wanted: Collection[str]
    ) -> Iterator[tuple[str, LaserScan | Odometry]]:
        if isinstance(row, CarmenOdometry):
            if "odometry" in wanted:
                yield "odometry", Odometry(stamp, row.pose, *row.twist)
            return
        channel = self._channel_of.get(row.kind)
        if channel is None:
            return
        if row.robot is not None and "odometry" in wanted:
            yield "odometry", Odometry(stamp, row.robot, *twist)
        if channel in wanted:
            yield channel, self._scan(channel, row, stamp)

    def _scan(self, channel: str, row: CarmenScan, stamp: float) -> LaserScan:
        limit = self._limit(row)
        ranges = np.where(row.ranges < limit, row.ranges, np.float32(np.inf))
        intensities = np.zeros_like(ranges) if row.intensities is None else row.intensities
        return LaserScan(
            stamp,
            "laser" if channel == "scan" else "rear_laser",
            ranges=read_only(ranges),
            intensities=read_only(intensities),
            angle_min=row.angle_min,
            angle_increment=row.angle_increment,
            range_min=_RANGE_MIN_M,
            range_max=limit,
            duration_s=0.0,
            X_BL=self._mount(channel, row),
        )

    def _limit(self, row: CarmenScan) -> float:
        """The range (m) from which a reading says that nothing was seen."""
        pile = self._pile_m.get(row.kind)
        if row.maximum is None and pile is not None:
            return pile
        low, top = _LMS_CODES_MM
        codes = low if low <= self._survey.farthest_m[row.kind] < top else _LMS_CODES_CM
        return min(codes, row.maximum or math.inf)

    def _mount(self, channel: str, row: CarmenScan) -> Pose3:
        """Pose of the laser in the base: as the line's two poses say, or the parameters, where those are the same."""
        turn = 0.0 if channel == "scan" else math.pi
        if row.robot is not None and row.laser is not None and row.robot != row.laser:
            return (row.robot.inverse() @ row.laser).to_pose3()
        try:
            offset = float(self._survey.params.get(_OFFSET_PARAMS[channel], "0"))
        except ValueError:
            offset = 0.0
        return (Pose2(0.0, 0.0, turn) @ Pose2(offset)).to_pose3()

    def _notes(self) -> tuple[str, ...]:
        survey = self._survey
        notes = [survey.wrong_times, survey.back]
        for kind, pile in self._pile_m.items():
            if pile is not None and survey.wordless[kind]:
                notes.append(
                    f"{kind}: readings from {pile:.1f} m on are its laser's for nothing seen: they pile up there"
                )
        notes += [
            f"{kind}: {count} readings are no distance (no number, or below 0): they say nothing"
            for kind, count in survey.blank.items()
            if kind in self._channel_of
        ]
        return tuple(note for note in notes if note)

    def _ignored(self) -> dict[str, str]:
        survey = self._survey
        read = {"PARAM", "ODOM", *self._channel_of}
        ignored = {}
        for kind, count in survey.kinds.items():
            if kind in KINDS and kind not in read:
                same = next(c for c, kinds in _LASERS.items() if kind in kinds)
                ignored[kind] = f"{count} lines: {self._lasers[same]} says the same with more"
            elif kind not in read:
                ignored[kind] = f"{count} lines: no message of this program says this"
        for kind, count in survey.untimed.items():
            ignored[f"{kind} without a time"] = f"{count} lines: their time cannot be that of their place in the log"
        if survey.malformed:
            ignored["malformed lines"] = f"{survey.malformed}: {survey.complaint}"
        if survey.truncated:
            ignored["end of the file"] = survey.truncated
        return ignored


def _surveyed(path: Path) -> _Survey:
    """Raises LogError where the file cannot be opened."""
    advance = Advance()
    survey = _gone_through(path, _first_clock(path), advance)
    # Kinds of lines whose times are checked: the laser's, or, in a log without one, odometry's.
    main = next((kind for kinds in _LASERS.values() for kind in kinds if advance.lines[kind]), "ODOM")
    clock = advance.by_order(main)
    if clock is None:
        return survey
    by_order = _gone_through(path, clock, Advance())
    unit = "scans" if main != "ODOM" else "poses"
    by_order.wrong_times = (
        f"times of this log cannot be used (a later one than before is in {advance.advancing[main]} of "
        f"{advance.lines[main]} {main} lines): lines are taken in their order, {1 / ASSUMED_PERIOD_S:g} {unit} a "
        "second are assumed"
    )
    return by_order


def _gone_through(path: Path, clock: Clock, advance: Advance) -> _Survey:
    survey = _Survey([_Mark(0, deepcopy(clock), (0.0, 0.0))])
    twist = (0.0, 0.0)
    number = 0
    first_back = 0
    lines = _lines(path, 0)
    while True:
        try:
            offset, line = next(lines)
        except StopIteration:
            break
        except LogError as failure:  # everything read before is valid
            survey.truncated = str(failure)
            break
        number += 1
        if offset - survey.marks[-1].offset >= _MARK_EVERY:
            survey.marks.append(_Mark(offset, deepcopy(clock), twist))
        try:
            row = parse(line)
        except ValueError as failure:
            survey.malformed += 1
            survey.complaint = survey.complaint or f"line {number}: {str(failure)[:_LONGEST_COMPLAINT]}"
            continue
        if row is None:
            if line.strip() and not line.startswith("#"):
                unknown = line.split(maxsplit=1)[0][:_LONGEST_KIND]
                survey.kinds[unknown if unknown in survey.kinds or len(survey.kinds) < _MOST_KINDS else "others"] += 1
            continue
        if isinstance(row, Param):
            if row.name in _OFFSET_PARAMS.values():
                survey.params[row.name] = row.value
            continue
        kind = row.kind
        times = clock.next(kind, row.times)
        advance.count(kind, row.times, times is not None)
        if times is None:
            survey.untimed[kind] += 1
            continue
        if not first_back and isinstance(clock, CarmenClock) and clock.most_back_s > JITTER_S:
            first_back = number
        twist = row.twist or twist
        survey.kinds[kind] += 1
        survey.begin = min(survey.begin, times[0])
        survey.end = times[0]
        if isinstance(row, CarmenScan) and row.ranges.size:
            _count_readings(survey, row)
    if first_back and isinstance(clock, CarmenClock):
        survey.back = (
            f"stamps that go back: {clock.back} (the first in line {first_back}; by {clock.most_back_s:.2f} s at most)"
            ": lines are taken in their order, each such stamp as the one before plus a step"
        )
    return survey


def _count_readings(survey: _Survey, row: CarmenScan) -> None:
    if row.blank:
        survey.blank[row.kind] += row.blank
    survey.wordless[row.kind] += row.maximum is None
    near = row.ranges[np.isfinite(row.ranges)]
    if near.size:
        survey.farthest_m[row.kind] = max(survey.farthest_m.get(row.kind, 0.0), float(near.max()))
    survey.far_ends.setdefault(row.kind, FarEnd()).add(row.ranges)


def _first_clock(path: Path) -> CarmenClock:
    """The clock before the first line: at the middle of the first times, so that one wrong one does no harm."""
    first = []
    for _, line in _lines(path, 0):
        try:
            row = parse(line)
        except ValueError:
            continue
        if isinstance(row, CarmenOdometry | CarmenScan):
            first.append(row.times)
            if len(first) == _FIRST_LINES:
                break
    if not first:
        return CarmenClock(0.0, 0.0)
    middle = statistics.median_low([times.captured for times in first])
    shifts = [times.captured - times.logged for times in first]
    usual = statistics.median_low(shifts)
    # The line logged soonest after its capture gives the best estimate of the clocks' offset.
    return CarmenClock(middle, max(shift for shift in shifts if abs(shift - usual) < _LATENCY_S))


def _lines(path: Path, offset: int) -> Iterator[tuple[int, str]]:
    """Byte offset (in the text) and text of each line from ``offset`` on. Raises LogError where it cannot be read."""
    try:
        with open_plain(path) as raw, _unpacked(raw) as file:
            file.seek(offset)
            while line := file.readline(_LONGEST_LINE):
                length = len(line)
                if length == _LONGEST_LINE and not line.endswith(b"\n"):
                    # Its name alone remains: a line that is cut off.
                    length += _skipped(path, file)
                    line = line[:_LONGEST_KIND].split(maxsplit=1)[0] if line[:_LONGEST_KIND].strip() else b""
                yield offset, line.decode("utf-8", "replace")
                offset += length
    except EOFError:
        raise LogError(f"{path}: ends in the middle of its packed text") from None
    except (OSError, zlib.error) as failure:
        raise LogError(f"{path}: is damaged: {failure}") from None


def _skipped(path: Path, file: BinaryIO) -> int:
    """Go to the end of a line; how many bytes that were. Raises LogError where it does not come."""
    length = 0
    while piece := file.readline(_LONGEST_LINE):
        length += len(piece)
        if piece.endswith(b"\n"):
            break
        if length > _NO_LINE:
            raise LogError(f"{path}: has a line of more than {_NO_LINE // 10**6} MB, so it is no log")
    return length


def _unpacked(raw: BinaryIO) -> BinaryIO:
    packed = raw.read(2) == b"\x1f\x8b"
    raw.seek(0)
    return cast(BinaryIO, gzip.GzipFile(fileobj=raw)) if packed else raw
