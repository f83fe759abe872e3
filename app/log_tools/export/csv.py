"""Messages of numbers and words as CSV: a row each, nested fields as columns ``a.b``, with units where known."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import msgspec
import numpy as np

from app.base.geometry import Pose2, Pose3
from app.log_tools.export.target import Format, Target, Write
from app.log_tools.export.wav import is_audio
from app.logs.log import LoggedChannel
from app.messages import (
    Divisors,
    EncodedImage,
    Image,
    JointState,
    LaserScan,
    LoadReport,
    ModuleReport,
    PointCloud,
)
from app.messages.base import field_names, is_record

#: Units that the names of fields do not say; a field's own ``_s``, ``_mps``, ... stays as it is.
UNITS: Mapping[type[Any], Mapping[str, str]] = {
    LaserScan: {
        "ranges": "m", "angle_min": "rad", "angle_increment": "rad", "range_min": "m", "range_max": "m",
    },
    LoadReport: {"process_cpu": "percent", "budget": "percent"},
    ModuleReport: {"cpu": "percent", "cpu_budget": "percent"},
    Pose2: {"x": "m", "y": "m", "theta": "rad"},
}  # fmt: skip
#: Fields of any class that are times of the robot's clock.
TIMES = frozenset({"stamp", "created", "expires", "first_seen", "last_seen", "began"})
#: Fields that give the columns of another their names.
NAMED: Mapping[type[Any], Mapping[str, str]] = {
    JointState: {"positions": "names", "efforts": "names"},
    Divisors: {"divisors": "filters"},
}
#: Fields of records that have a name, each in columns of this name.
BY_NAME: Mapping[type[Any], str] = {LoadReport: "modules"}
BULKY = (Image, EncodedImage, PointCloud)

Row = dict[str, Any]


class Csv(Format):
    """``<channel>.csv``. Columns are those of all messages, so every message is looked at before."""

    surveys = True

    def __init__(self) -> None:
        self._columns: dict[str, dict[str, None]] = {}

    def accepts(self, message_type: type[Any]) -> bool:
        return message_type not in BULKY and not is_audio(message_type)

    def survey(self, channel: str, message: Any) -> None:
        columns = self._columns.setdefault(channel, {})
        # A dict keeps the order in which columns were met.
        columns.update(dict.fromkeys(flat(message)))

    @contextmanager
    def writer(self, channel: LoggedChannel, target: Target) -> Iterator[Write]:
        name = f"{channel.name}.csv"
        target.check(name)
        columns = list(self._columns.get(channel.name, {}))
        count = 0

        def write(message: Any) -> None:
            nonlocal count
            row = flat(message)
            table.writerow([row.get(column, "") for column in columns])
            count += 1

        with target.file(name) as part, part.open("w", newline="", encoding="utf-8") as stream:
            table = csv.writer(stream)
            table.writerow(columns)
            yield write
        target.written.append(f"{target.folder / name}: {count} rows of {len(columns)} columns")


def flat(message: Any) -> Row:
    """A message's values by column. Empty where there is none, JSON where a column cannot hold it."""
    row: Row = {}
    arrays: Row = {}
    _flatten(message, "", row, arrays)
    return row | arrays


def _flatten(value: Any, prefix: str, row: Row, arrays: Row) -> None:
    """Into ``row``, but into ``arrays`` what makes many columns, so that these come last."""
    kind = type(value)
    for field in field_names(kind):
        content = getattr(value, field)
        key = prefix + _with_unit(kind, field)
        if names := NAMED.get(kind, {}).get(field):
            row.update(zip((f"{key}.{name}" for name in getattr(value, names)), content, strict=False))
        elif field == BY_NAME.get(kind):
            for each in content:
                _flatten(each, f"{key}.{each.name}.", row, arrays)
        elif field not in NAMED.get(kind, {}).values():
            _cell(content, key, row, arrays)


def _cell(content: Any, key: str, row: Row, arrays: Row) -> None:
    if isinstance(content, Pose3):
        numbers = (*content.translation.tolist(), *content.quaternion_wxyz())
        row.update(zip((f"{key}.{part}" for part in _POSE3), numbers, strict=True))
    elif isinstance(content, np.ndarray):
        if content.ndim == 1:
            digits = "%.9g" if content.dtype == np.float32 else "%.17g"
            write: Callable[[Any], Any] = digits.__mod__ if content.dtype.kind == "f" else int
            arrays.update({f"{key}.{index}": write(number) for index, number in enumerate(content.tolist())})
        else:
            row[key] = json.dumps(content.tolist())
    elif is_record(type(content)):
        _flatten(content, f"{key}.", row, arrays)
    elif isinstance(content, Mapping) and all(isinstance(each, float) for each in content.values()):
        row.update({f"{key}.{name}": each for name, each in content.items()})
    elif isinstance(content, tuple | Mapping):
        row[key] = json.dumps(msgspec.to_builtins(content, enc_hook=np.ndarray.tolist), ensure_ascii=False)
    elif isinstance(content, bytes):
        row[key] = content.hex()
    else:
        row[key] = content if content is not None else ""


_POSE3 = ("x_m", "y_m", "z_m", "qw", "qx", "qy", "qz")


def _with_unit(kind: type[Any], name: str) -> str:
    unit = "s" if name in TIMES else UNITS.get(kind, {}).get(name)
    return f"{name}_{unit}" if unit else name
