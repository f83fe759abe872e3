"""A body that dies is started again while the program stays up."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from pathlib import Path

import pytest

from app.attention.desires import Source
from app.base.geometry import Pose2
from app.link import LinkFailed
from app.messages import Odometry
from app.program.body_restart import LONGEST_DELAY_S, MOST_IN_A_ROW, TRUSTED_AFTER_S, RestartBackoff
from app.program.system import System
from app.runtime.clock import VirtualClock, in_virtual_time
from tests.console.program import Body, build


class Mortal(Body):
    """A body that dies on demand, and does not come up ``stillborn`` times."""

    def __init__(self) -> None:
        super().__init__()
        self.description = replace(self.description, restartable=True)
        self.starts: list[float] = []
        self.stillborn = 0
        self._death: asyncio.Future[LinkFailed] | None = None

    async def start(self) -> None:
        self.starts.append(asyncio.get_running_loop().time())
        if len(self.starts) > 1 and self.stillborn:
            self.stillborn -= 1
            raise LinkFailed("The body's cable is out.")
        self._death = asyncio.get_running_loop().create_future()

    async def wait_failed(self) -> LinkFailed:
        assert self._death is not None
        return await asyncio.shield(self._death)

    def die(self) -> None:
        assert self._death is not None
        self._death.set_result(LinkFailed("The body's process was killed by signal 9."))


@pytest.fixture
def built(tmp_path: Path) -> tuple[System, Mortal]:
    """The program, in virtual time, on a body that may die."""
    body = Mortal()
    return build(tmp_path, body=body, clock=VirtualClock())[0], body


def test_starts_come_later_and_later_and_end() -> None:
    restarts = RestartBackoff()
    restarts.up(0.0)
    delays = [restarts.failed(float(number)) for number in range(MOST_IN_A_ROW)]
    assert delays == [0.5, 1.0, 2.0, 4.0, None]
    assert all(delay is None or delay <= LONGEST_DELAY_S for delay in delays)


def test_a_body_that_stayed_up_is_trusted_again() -> None:
    restarts, now = RestartBackoff(), 0.0
    for _ in range(3 * MOST_IN_A_ROW):
        restarts.up(now)
        now += TRUSTED_AFTER_S
        assert restarts.failed(now) == 0.5


def test_the_program_goes_on_with_a_new_body(built: tuple[System, Mortal]) -> None:
    system, body = built
    reports: list[str] = []

    @in_virtual_time
    async def story() -> None:
        news: asyncio.Queue[str] = asyncio.Queue()
        async with system:
            going = asyncio.create_task(system.keep_going())
            system.body_restarter.observe(news.put_nowait)
            await system.supervisor.started()
            before = {name: slot.module for name, slot in system.graph.modules.items()}
            desire = system.workspace.add("FindQRCodes", intensity=1, utility=1, source=Source("operator", "Ann"))
            body.emit("odometry", Odometry(system.clock.now(), Pose2(3.0, 0.0, 0.0), 0.0, 0.0))
            body.stillborn = 2
            body.die()
            reports.extend([await news.get() for _ in range(3)])
            assert {state.status for state in system.supervisor.states.values()} == {"stopped"}
            assert system.graph.channel("odometry").latest is not None
            reports.append(await news.get())
            await system.supervisor.started()
            assert {state.status for state in system.supervisor.states.values()} == {"running"}
            assert system.graph.channel("odometry").latest is None, "what was built on the old odometry is void"
            assert all(slot.module is not before[name] for name, slot in system.graph.modules.items())
            assert desire in system.workspace.desires(), "what people want stays"
            body.emit("odometry", Odometry(system.clock.now(), Pose2(0.0, 0.0, 0.0), 0.0, 0.0))
            assert system.graph.channel("odometry").latest is not None
            assert not going.done()
            going.cancel()

    story()
    gaps = [later - earlier for earlier, later in zip(body.starts, body.starts[1:], strict=False)]
    assert gaps[1:] == pytest.approx([1.0, 2.0], abs=0.01)
    assert reports == [
        "The body does not answer: the body's process was killed by signal 9. It is started again.",
        *["The body does not answer: the body's cable is out. It is started again."] * 2,
        "",
    ]


def test_one_that_never_comes_up_ends_the_program_in_one_sentence(built: tuple[System, Mortal]) -> None:
    system, body = built

    @in_virtual_time
    async def story() -> Exception:
        async with system:
            body.stillborn = 100
            body.die()
            return await system.keep_going()

    failure = story()
    assert isinstance(failure, LinkFailed)
    assert str(failure) == "The body's cable is out; that was the 5th time in a row, so the program ends."
    assert len(body.starts) == MOST_IN_A_ROW


def test_a_body_that_cannot_be_started_again_ends_it_at_once(built: tuple[System, Mortal]) -> None:
    system, body = built
    body.description = replace(body.description, restartable=False)

    @in_virtual_time
    async def story() -> Exception:
        async with system:
            body.die()
            return await system.keep_going()

    assert str(story()) == "The body's process was killed by signal 9."
    assert len(body.starts) == 1
