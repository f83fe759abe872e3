"""Replays in processes of their own: up, replaced, failed, ended, and never left behind."""

from __future__ import annotations

import asyncio
import os
import signal
import sys
import tempfile
from collections.abc import AsyncIterator
from pathlib import Path

import psutil
import pytest

from app.console.access.token import VARIABLE
from app.console.replays import ReplayFailed, ReplayReplaced, Replays, reached_by
from tests.patience import PATIENCE_S

#: Prints its address and process id, and stays.
UP = """
echo "a note first"
echo "HBBA replays tour.mcap: http://127.0.0.1:4711/#pid=$$  (Ctrl-C stops it)"
exec sleep 60
"""
#: Comes up with a few hundred kilobytes of chatter on both its outputs.
CHATTY = """
import sys
for stream in (sys.stdout, sys.stderr):
    stream.write("nothing to see here. " * 20_000 + "\\n")
print("HBBA replays tour.mcap: http://127.0.0.1:4711  (Ctrl-C stops it)", flush=True)
sys.stdout.write("more. " * 100_000)
sys.stdout.flush()
sys.stderr.write("enough\\n")
"""


@pytest.fixture
async def replays() -> AsyncIterator[Replays]:
    """Nothing replayed yet; nothing left behind."""
    replays = Replays("127.0.0.1", None)
    replays.command = ("sh", "-c", UP)
    yield replays
    await replays.close()
    assert replays.current is None


def process_of(url: str) -> psutil.Process:
    """The process that said ``url``."""
    return psutil.Process(int(url.partition("#pid=")[2]))


async def gone(process: psutil.Process) -> bool:
    """Whether the process ends now."""
    try:
        await asyncio.to_thread(process.wait, 5)
    except psutil.TimeoutExpired:
        return False
    return True


async def test_one_that_is_up_has_a_url_until_it_is_ended(replays: Replays) -> None:
    url = await replays.start("tour", Path("tour.mcap"))
    assert url.startswith("http://127.0.0.1:4711/#")
    assert replays.current == ("tour", url)
    process = process_of(url)
    assert not await replays.end("another")
    assert await replays.end("tour")
    assert await gone(process)
    assert replays.current is None
    assert not await replays.end("tour")


async def test_a_new_one_ends_the_former(replays: Replays) -> None:
    first = process_of(await replays.start("tour", Path("tour.mcap")))
    url = await replays.start("bump", Path("bump.mcap"))
    assert await gone(first)
    assert replays.current == ("bump", url)


async def test_one_that_is_not_up_yet_ends_as_replaced(replays: Replays) -> None:
    replays.command = ("sh", "-c", "exec sleep 60")
    first = asyncio.create_task(replays.start("tour", Path("tour.mcap")))
    await asyncio.sleep(0)
    replays.command = ("sh", "-c", UP)
    url = await replays.start("bump", Path("bump.mcap"))
    with pytest.raises(ReplayReplaced, match="another replay"):
        await first
    assert replays.current == ("bump", url)


async def test_its_arguments_say_where_to_listen_and_when_to_end(replays: Replays) -> None:
    replays.command = ("sh", "-c", 'echo "http://127.0.0.1:1/#$(echo "$@" | tr " " ,) "; exec sleep 60', "sh")
    url = await replays.start("tour", Path("/somewhere/tour.mcap"))
    assert url.endswith("#--port,0,--scene-port,0,--host,127.0.0.1,--exit-when-unwatched,180,--,/somewhere/tour.mcap")


@pytest.mark.parametrize(
    ("script", "words"),
    [
        ("echo one >&2; echo 'hbba replay: tour.mcap holds no sensors' >&2; exit 2", "tour.mcap holds no sensors"),
        ("exit 3", "it ended with status 3 and said nothing"),
        ("kill -9 $$", "it ended with status -9 and said nothing"),
    ],
)
async def test_one_that_fails_says_why(replays: Replays, script: str, words: str) -> None:
    replays.command = ("sh", "-c", script)
    with pytest.raises(ReplayFailed) as failure:
        await replays.start("tour", Path("tour.mcap"))
    assert str(failure.value) == words
    assert replays.current is None


async def test_one_that_cannot_be_started_says_why(replays: Replays) -> None:
    replays.command = ("/no/such/program",)
    with pytest.raises(ReplayFailed, match="No such file"):
        await replays.start("tour", Path("tour.mcap"))


async def test_one_that_ended_by_itself_is_not_current(replays: Replays) -> None:
    replays.command = ("sh", "-c", "echo 'http://127.0.0.1:4711 '")
    await replays.start("tour", Path("tour.mcap"))
    (following,) = (task for task in asyncio.all_tasks() if task.get_name() == "replay of tour")
    await following
    assert replays.current is None
    replays.command = ("sh", "-c", UP)
    await replays.start("tour", Path("tour.mcap"))


async def test_one_that_does_not_listen_is_ended_all_the_same(replays: Replays) -> None:
    replays.command = ("sh", "-c", f"trap '' TERM; {UP.replace('exec sleep 60', 'while :; do sleep 60; done')}")
    process = process_of(await replays.start("tour", Path("tour.mcap")))
    await replays.close()
    assert await gone(process)


async def test_what_it_kept_in_its_folder_goes_with_it_however_it_ends(
    replays: Replays, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    script = f"trap '' TERM; touch $TMPDIR/kept; {UP.replace('exec sleep 60', 'while :; do sleep 60; done')}"
    replays.command = ("sh", "-c", script)
    await replays.start("tour", Path("tour.mcap"))
    assert [os.listdir(tmp_path / folder) for folder in os.listdir(tmp_path)] == [["kept"]]
    await replays.close()
    assert os.listdir(tmp_path) == []


async def test_its_output_never_fills_a_pipe(replays: Replays) -> None:
    replays.command = (sys.executable, "-c", CHATTY)
    await replays.start("tour", Path("tour.mcap"))
    (following,) = (task for task in asyncio.all_tasks() if task.get_name() == "replay of tour")
    await asyncio.wait_for(following, PATIENCE_S)


CONSOLE = """
import asyncio, sys
from pathlib import Path
from app.console.replays import Replays

async def main():
    replays = Replays("127.0.0.1", "a long secret")
    starting = asyncio.create_task(replays.start("tour", Path(sys.argv[1])))
    while replays._child is None:
        await asyncio.sleep(0.01)
    print(replays._child._process.pid, flush=True)
    await starting

asyncio.run(main())
"""


async def test_a_killed_console_leaves_no_replay_behind(tmp_path: Path) -> None:
    # Opening a pipe without a writer takes for ever: the replay stays where it begins.
    pipe = tmp_path / "tour.mcap"
    os.mkfifo(pipe)
    console = await asyncio.create_subprocess_exec(
        sys.executable, "-c", CONSOLE, str(pipe), stdout=asyncio.subprocess.PIPE
    )
    assert console.stdout is not None
    replay = psutil.Process(int(await console.stdout.readline()))
    assert replay.ppid() == console.pid
    assert "a long secret" not in " ".join(replay.cmdline())
    console.send_signal(signal.SIGKILL)
    await console.wait()
    assert await gone(replay)


async def test_the_token_goes_by_the_environment_alone_and_the_names_by_the_arguments() -> None:
    replays = Replays("127.0.0.1", "a-long-secret", ["robot.example", "robot.lan"])
    replays.command = ("sh", "-c", f'echo "http://host/?${VARIABLE}" "$@"; exec sleep 60', "replay")
    try:
        url = await replays.start("tour", Path("tour.mcap"))
        assert url == "http://host/?a-long-secret"
        assert replays._child is not None
        arguments = psutil.Process(replays._child._process.pid).cmdline()
        assert "a-long-secret" not in " ".join(arguments)
    finally:
        await replays.close()


async def test_a_replay_answers_to_the_names_of_this_console() -> None:
    replays = Replays("127.0.0.1", None, ["robot.example", "robot.lan"])
    replays.command = ("sh", "-c", 'shift 8; echo "http://host/$1/$2/$3/$4/$5 "; exec sleep 60', "replay")
    try:
        url = await replays.start("tour", Path("tour.mcap"))
        assert url == "http://host/--host-name/robot.example/--host-name/robot.lan/--"
    finally:
        await replays.close()


@pytest.mark.parametrize(
    ("url", "scheme", "host", "reached"),
    [
        ("http://127.0.0.1:4711", "http", "localhost", "http://localhost:4711"),
        ("http://127.0.0.1:4711/#token=a-b_c", "http", "robot.local", "http://robot.local:4711/#token=a-b_c"),
        ("http://[::1]:4711/#token=x", "http", "::1", "http://[::1]:4711/#token=x"),
        ("http://127.0.0.1:4711", "http", None, "http://127.0.0.1:4711"),
    ],
)
def test_a_replay_is_reached_under_the_name_this_console_has(
    url: str, scheme: str, host: str | None, reached: str
) -> None:
    assert reached_by(url, scheme, host) == reached
