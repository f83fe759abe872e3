"""Logs for people and for machines: one line per event.

Text: ``08:45:49.123 INFO QRCodeDetector code found text=door-1 sigma_m=0.02``, colours on a terminal only. JSON: one
object a line. Values passed as ``extra={"key": value}`` to a logging call become ``key=value``, or a member.
"""

from __future__ import annotations

import json
import logging
import sys
import traceback
from datetime import UTC, datetime
from typing import Any, TextIO

from app.base.log_rate_limit import RateLimitedHandler

LEVELS = ("debug", "info", "warning", "error")

#: Libraries whose information is of no interest here; their warnings are logged.
_TALKATIVE = (
    "absl",
    "asyncio",
    "httpcore",
    "httpx",
    "multipart",
    "OpenGL",
    "PIL",
    "trimesh",
    "uvicorn",
    "uvicorn.access",
    "uvicorn.error",
    "viser",
    "websockets",
)
_STANDARD = frozenset(vars(logging.makeLogRecord({}))) | {"message", "asctime", "color_message", "taskName"}
_COLORS = {"DEBUG": "2", "WARNING": "33", "ERROR": "31", "CRITICAL": "1;31"}


def configure(level: str = "info", *, as_json: bool = False, stream: TextIO | None = None) -> None:
    """Send all logs of the process to ``stream`` (standard error by default), from ``level`` (of LEVELS) upwards.

    Repeated lines are counted instead (:mod:`app.base.log_rate_limit`).
    """
    stream = sys.stderr if stream is None else stream
    handler = RateLimitedHandler(stream)
    handler.setFormatter(JsonFormatter() if as_json else LineFormatter(colored=stream.isatty()))
    logging.basicConfig(level=level.upper(), handlers=[handler], force=True)
    logging.captureWarnings(True)
    for name in _TALKATIVE:
        library = logging.getLogger(name)
        library.handlers.clear()
        library.propagate = True
        library.setLevel(logging.NOTSET if level == "debug" else logging.WARNING)
    if level == "debug":
        # One line for every frame of every socket is too much even for debugging.
        logging.getLogger("websockets").setLevel(logging.INFO)


class LineFormatter(logging.Formatter):
    """Formats an event as one readable line; the traceback of an exception follows, indented."""

    def __init__(self, *, colored: bool = False) -> None:
        super().__init__()
        self._colored = colored

    def format(self, record: logging.LogRecord) -> str:
        moment = datetime.fromtimestamp(record.created)
        time = f"{moment:%H:%M:%S}.{moment.microsecond // 1000:03d}"
        message = " ".join(record.getMessage().splitlines())
        pairs = "".join(f" {key}={_shown(value)}" for key, value in _fields(record).items())
        if self._colored:
            color = _COLORS.get(record.levelname, "")
            level = f"\x1b[{color}m{record.levelname:<7}\x1b[0m"
            line = f"\x1b[2m{time}\x1b[0m {level} \x1b[36m{_room(record)}\x1b[0m  {message}"
            line += f" \x1b[2m{pairs}\x1b[0m" if pairs else ""
        else:
            line = f"{time} {record.levelname:<7} {_room(record)}  {message}"
            line += f" {pairs}" if pairs else ""
        if trace := _trace(record):
            line += "\n    " + trace.replace("\n", "\n    ")
        return line


class JsonFormatter(logging.Formatter):
    """Formats an event as a JSON object: time (ISO 8601, UTC), level, module, message, then the event's own members."""

    def format(self, record: logging.LogRecord) -> str:
        event: dict[str, Any] = {
            "time": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "level": record.levelname.lower(),
            "module": _room(record),
            "message": record.getMessage(),
        }
        event.update({key: value for key, value in _fields(record).items() if key not in event})
        if trace := _trace(record):
            event["exception"] = trace
        return json.dumps(event, default=str, ensure_ascii=False)


def _room(record: logging.LogRecord) -> str:
    """The logger's name as people know it: a module's name, or a room of the program."""
    return record.name.removeprefix("hbba.").removeprefix("app.")


def _fields(record: logging.LogRecord) -> dict[str, Any]:
    return {key: value for key, value in vars(record).items() if key not in _STANDARD and not key.startswith("_")}


def _shown(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    text = str(value)
    return json.dumps(text, ensure_ascii=False) if not text or set(text) & set(' "=\n\t') else text


def _trace(record: logging.LogRecord) -> str:
    if not record.exc_info or record.exc_info[1] is None:
        return ""
    return "".join(traceback.format_exception(*record.exc_info)).rstrip()
