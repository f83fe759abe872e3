"""Which files may read the computer's clock: code that does not use the robot's clock differs between two replays."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

APP = Path(__file__).resolve().parent.parent / "app"

#: Calls that say what time it is. CPU time (``thread_time``, ``process_time``) is work that was done, and no clock.
OF_TIME = {"time", "time_ns", "monotonic", "monotonic_ns", "perf_counter", "perf_counter_ns"}
#: Say the time of now where they are given fewer arguments than this.
OF_NOW = {"localtime": 1, "gmtime": 1, "ctime": 1, "asctime": 1, "strftime": 2}
OF_DATETIME = {"now", "today", "utcnow"}

#: Files that read it, and why the robot's clock would be wrong there.
ALLOWED = {
    "runtime/pressure.py": "the load of this computer between two looks at its counters",
    "attention/cpsat.py": "the solver's time limit: how long people wait for an intention",
    "attention/class_options.py": "the solver's time limit",
    "attention/reasons.py": "the time limit of reasons, likewise",
    "attention/search.py": "the solver's time limit",
    "attention/graded.py": "the solver's time limit",
    "attention/proof/certificate.py": "the time limit of a proof, for people",
    "attention/proof/prover.py": "likewise",
    "attention/problem.py": "how long the solver took",
    "attention/solver.py": "the solver's time limit, and how long it took",
    "attention/variants.py": "the time limit of reasons",
    "commands/calibrate.py": "the date in a calibration file",
    "commands/progress.py": "how often a line of progress is printed",
    "commands/solve.py": "the time limit that a person gave",
    "commands/time_limit.py": "likewise",
    "console/link_shaper.py": "when what passes a shaped link arrives at people's pages",
    "console/live/endpoint.py": "how late a page's acknowledgement of a picture is",
    "console/live/outbox.py": "how long a picture is on its way to a page",
    "console/access/auth.py": "how long sessions last and wrong tokens are slowed, for people",
    "console/live/tour_visitors.py": "how often a visitor's phone says something",
    "console/rehearsals.py": "when a rehearsal began, for people",
    "console/rest/visitor.py": "how often a visitor's phone asks for something",
    "console/server.py": "how late the event loop was where a connection's time is over",
    "console/view/scene_thread.py": "how long drawing for people took",
    "console/view/relay.py": "how fast a viewer's network is",
    "experiments/barn/trial.py": "how long a trial took on this computer",
    "experiments/observation.py": "how late the event loop is, which is what the experiment measures",
    "experiments/tour/tour_run.py": "how long a trial took on this computer",
    "remote/node.py": "how far the robot's clock is from this computer's own",
    "base/log_rate_limit.py": "how often a line of the log is repeated",
    "tours/media.py": "the age of a file that an upload left behind",
    "maps/library.py": "the age of a file that somebody left behind",
    "modules/recording/recorder.py": "how long the thread that writes may take to end",
    "logs/mcap/disk_time.py": "how long the disk was waited for, in the thread that writes",
    "logs/mcap/writer.py": "when a file is flushed, in the thread that writes",
    "modules/viewers/ros2/node.py": "how often it is looked who listens, in the process in the graph",
    "logs/replay/headless.py": "how long a replay took, and its pace where one is asked for",
    "robots/devices/link.py": "a body's own clock, by which it stamps",
    "robots/devices/image_inputs.py": "the pace of a camera, or of a video that plays one",
    "robots/devices/reader_thread.py": "a pause before a device is tried again",
    "robots/devices/streams.py": "the pace of sound",
    "robots/drivers/body_loop.py": "a body's own clock, in the link's process",
    "robots/drivers/link.py": "a body's own clock, by which its camera and sound are stamped",
    "robots/drivers/port.py": "how long the last word of a line that is closed may take to leave",
    "robots/ros2/body_loop.py": "a body's own clock, in the link's process",
    "robots/ros2/body_node.py": "likewise",
    "robots/ros2/node.py": "likewise",
    "robots/ros2/rosbridge/connection.py": "when a server was heard, in the link's process",
    "robots/ros2/rosbridge/node.py": "a body's own clock, in the link's process",
    "robots/ros2/joint_actions.py": "how long an action's server takes to answer, in the link's process",
    "robots/ros2/survey.py": "how far a robot's clock is from the computer's, and its topics' rates, for people",
    "robots/simulated/parts/player.py": "the clock of the boards of a robot that is played, in a process of its own",
    "robots/simulated/ros2_joint_action.py": "how long a simulated robot pursues a goal, in a process of its own",
    "robots/simulated/ros2_player.py": "when a simulated robot moved, for tests that watch it from another process",
    "robots/simulated/rosbridge_player.py": "likewise",
    "robots/simulated/rosbridge_server.py": "how often a topic is passed on, in the process of a robot that is played",
    "robots/simulated/link.py": "the CPU time of this program, which its battery is discharged by",
    "robots/simulated/camera_thread.py": "how old a picture that waits to be drawn is, in the link's process",
    "robots/simulated/serve.py": "how long the world took to start, in the link's process",
    "robots/simulated/realtime_loop.py": "a body's own clock, in the link's process",
    "runtime/channel.py": "the deadline of a send, by the loop's time, which is virtual where the clock is",
    "runtime/clock.py": "what all others read it by",
    "runtime/load.py": "the real time that CPU time is a share of",
    "runtime/replay_clock.py": "the real time that a recording is played by",
    "runtime/supervisor.py": "how long a module's thread may take to end",
    "runtime/watchdog.py": "how late the event loop is",
}


def readings(source: str) -> Iterator[int]:
    """The lines of ``source`` that read the computer's clock, or could by another name."""
    for node in ast.walk(ast.parse(source)):
        if not isinstance(node, ast.ImportFrom | ast.Call | ast.Attribute):
            continue
        named = isinstance(node, ast.ImportFrom) and node.module == "time" and any(a.name in _ALL for a in node.names)
        of_now = isinstance(node, ast.Call) and _is_of_now(node)
        if named or of_now or (isinstance(node, ast.Attribute) and _is_reading(node)):
            yield node.lineno


_ALL = {*OF_TIME, *OF_NOW}


def _is_of_now(node: ast.Call) -> bool:
    module, _, name = ast.unparse(node.func).rpartition(".")
    return module == "time" and len(node.args) < OF_NOW.get(name, 0)


def _is_reading(node: ast.Attribute) -> bool:
    of = ast.unparse(node.value)
    if of == "time":
        return node.attr in OF_TIME
    if of.split(".")[-1] in ("datetime", "date"):
        return node.attr in OF_DATETIME
    return node.attr == "time" and (of == "loop" or of.endswith(("_loop", "_loop()")))


def test_only_these_files_read_the_computers_clock() -> None:
    sources = {str(path.relative_to(APP)): path.read_text("utf-8") for path in sorted(APP.rglob("*.py"))}
    found = {name: lines for name, source in sources.items() if (lines := sorted(set(readings(source))))}
    assert {name: lines for name, lines in found.items() if name not in ALLOWED} == {}, (
        "go by the module's `clock`, or add the file to ALLOWED with the reason"
    )
    assert [name for name in ALLOWED if name not in found] == [], "they read it no more"


@pytest.mark.parametrize(
    "source",
    [
        "import time\nnow = time.monotonic()",
        "import time\ndef f(clock=time.time): ...",
        "from time import perf_counter as p",
        "import time\ntime.strftime('%H')",
        "import time\ntime.localtime()",
        "from datetime import datetime\ndatetime.now()",
        "import datetime\ndatetime.date.today()",
        "import asyncio\nasyncio.get_running_loop().time()",
        "loop.time()",
    ],
)
def test_a_reading_is_found(source: str) -> None:
    assert len(list(readings(source))) == 1


@pytest.mark.parametrize(
    "source",
    [
        "self.clock.now()",
        "import time\ntime.thread_time()",
        "import time\ntime.strftime('%H', time.localtime(at))",
        "x.time",
    ],
)
def test_what_is_no_reading_is_not(source: str) -> None:
    assert list(readings(source)) == []
