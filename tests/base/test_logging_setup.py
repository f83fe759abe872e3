"""What a log line looks like, to people and to machines."""

from __future__ import annotations

import io
import json
import logging
import re
from collections.abc import Iterator

import pytest

from app.base import logging_setup


@pytest.fixture(autouse=True)
def _put_logging_back() -> Iterator[None]:
    """``configure`` changes the process; other tests must not notice."""
    root = logging.getLogger()
    before = (root.handlers[:], root.level)
    known = {
        name: logger.level for name, logger in root.manager.loggerDict.items() if isinstance(logger, logging.Logger)
    }
    yield
    root.handlers[:], level = before
    root.setLevel(level)
    logging.captureWarnings(False)
    for name, logger in root.manager.loggerDict.items():
        if isinstance(logger, logging.Logger):
            logger.setLevel(known.get(name, logging.NOTSET))


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_an_event_is_one_line_of_time_level_module_message_and_pairs() -> None:
    out = io.StringIO()
    logging_setup.configure("info", stream=out)
    logging.getLogger("hbba.QRCodeDetector").info(
        "code %s found", "door-1", extra={"sigma_m": 0.0213456789, "where": "by the door", "none": ""}
    )
    assert re.fullmatch(
        r"\d\d:\d\d:\d\d\.\d\d\d INFO    QRCodeDetector  code door-1 found  "
        r'sigma_m=0\.0213457 where="by the door" none=""\n',
        out.getvalue(),
    )


def test_a_message_of_several_lines_stays_one_line() -> None:
    out = io.StringIO()
    logging_setup.configure(stream=out)
    logging.getLogger("app.attention.timeline").warning("one\ntwo")
    assert out.getvalue().endswith("WARNING attention.timeline  one two\n")


def test_only_a_terminal_gets_colours() -> None:
    plain, terminal = io.StringIO(), Terminal()
    for stream in (plain, terminal):
        logging_setup.configure(stream=stream)
        logging.getLogger("hbba.link").error("gone", extra={"key": 1})
    assert "\x1b" not in plain.getvalue()
    assert re.sub(r"\x1b\[[0-9;]*m", "", terminal.getvalue()).split(" ", 1)[1] == plain.getvalue().split(" ", 1)[1]
    assert "\x1b[31mERROR" in terminal.getvalue()


def test_json_has_one_object_a_line_and_its_own_members_win() -> None:
    out = io.StringIO()
    logging_setup.configure(as_json=True, stream=out)
    logging.getLogger("hbba.link").info("φ set", extra={"phi": 2, "level": "loud", "path": io.StringIO})
    (line,) = out.getvalue().splitlines()
    event = json.loads(line)
    assert event["time"].endswith("+00:00")
    assert {key: event[key] for key in ("level", "module", "message", "phi")} == {
        "level": "info",
        "module": "link",
        "message": "φ set",
        "phi": 2,
    }


def test_a_logged_exception_keeps_its_traceback() -> None:
    text, machine = io.StringIO(), io.StringIO()
    for stream, as_json in ((text, False), (machine, True)):
        logging_setup.configure(as_json=as_json, stream=stream)
        try:
            _ = [][1]
        except IndexError:
            logging.getLogger("hbba.link").exception("lost")
    first, *rest = text.getvalue().splitlines()
    assert first.endswith("lost")
    assert rest
    assert all(line.startswith("    ") for line in rest)
    assert "IndexError" in json.loads(machine.getvalue())["exception"]


def test_libraries_are_quiet_until_they_warn() -> None:
    out = io.StringIO()
    logging_setup.configure("info", stream=out)
    for name in ("uvicorn.access", "websockets.server", "viser"):
        logging.getLogger(name).info("chatter")
        logging.getLogger(name).warning("trouble")
    assert "chatter" not in out.getvalue()
    assert out.getvalue().count("trouble") == 3


def test_levels_hide_what_is_less_severe() -> None:
    out = io.StringIO()
    logging_setup.configure("warning", stream=out)
    logging.getLogger("hbba.x").info("no")
    logging.getLogger("hbba.x").warning("yes")
    assert "no" not in out.getvalue().split()
    assert "yes" in out.getvalue().split()
