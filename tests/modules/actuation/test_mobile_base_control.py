from __future__ import annotations

from typing import Any

import pytest

from app.messages import Exploitation, LinkStatus, Twist
from app.runtime.clock import run_virtual
from app.runtime.graph import WiringError
from tests.modules.fakes import Bench, FakeLink, drain

MODULE = "app.modules.actuation.mobile_base_control:MobileBaseControl"
OUTPUTS = {"exploitation": Exploitation, "status": LinkStatus}
BOTH = {
    "behaviors": [
        {"input": "teleop", "behavior": "Teleop", "priority": 2},
        {"input": "follow", "behavior": "PlanAndFollowPath", "priority": 1},
    ]
}


def bench(**options: Any) -> Bench:
    return Bench(MODULE, inputs={"teleop": Twist}, outputs=OUTPUTS, link=FakeLink(without=("hokuyo",)), **options)


async def say(b: Bench, port: str, linear: float, angular: float = 0.0, times: int = 1) -> None:
    """Command ``times`` times, 50 ms apart."""
    for _ in range(times):
        b.feed(port, Twist(b.clock.now(), linear, angular))
        await b.clock.sleep(0.05)


def speeds(link: FakeLink) -> list[float]:
    return [round(twist.linear_mps, 6) for _, twist in link.commands]


def test_a_command_reaches_the_link_at_once_and_speeds_up_within_the_limits() -> None:
    async def main() -> None:
        async with bench() as b:
            await b.clock.sleep(1.02)
            b.link.commands.clear()
            asked = b.clock.now()
            await say(b, "teleop", 2.0, 0.5, times=30)
            first, twist = b.link.commands[0]
            assert first == asked, "a command waits for no beat"
            assert twist.linear_mps == pytest.approx(0.04)
            assert twist.angular_radps == pytest.approx(0.4)
            assert b.link.commands[-1][1].linear_mps == pytest.approx(0.4)
            for (t0, a), (t1, z) in zip(b.link.commands, b.link.commands[1:], strict=False):
                assert abs(z.linear_mps - a.linear_mps) <= 0.4 * (t1 - t0) + 1e-6

    run_virtual(main())


def test_a_stop_reaches_the_link_at_once() -> None:
    async def main() -> None:
        async with bench() as b:
            await say(b, "teleop", 0.4, times=30)
            b.link.commands.clear()
            asked = b.clock.now()
            await say(b, "teleop", 0.0)
            when, twist = b.link.commands[0]
            assert when == asked
            assert (twist.linear_mps, twist.angular_radps) == (0.0, 0.0)

    run_virtual(main())


def test_silence_stops_the_base_and_then_leaves_the_link_alone() -> None:
    async def main() -> None:
        async with bench() as b:
            await say(b, "teleop", 0.4, times=20)
            last = b.clock.now() - 0.05
            await b.clock.sleep(2.0)
            after = [(when, twist) for when, twist in b.link.commands if when > last]
            zeros = [when for when, twist in after if twist.linear_mps == 0.0]
            assert zeros[0] - last <= 0.35
            assert len(zeros) == 3
            assert [t.linear_mps for _, t in after[-3:]] == [0.0] * 3
            b.link.commands.clear()
            await b.clock.sleep(2.0)
            assert b.link.commands == []

    run_virtual(main())


def test_exploitation_reports_who_drives_at_10_hz_and_on_change() -> None:
    async def main() -> None:
        async with Bench(
            MODULE,
            inputs={"teleop": Twist, "follow": Twist},
            outputs=OUTPUTS,
            settings=BOTH,
            link=FakeLink(without=("hokuyo",)),
        ) as b:
            exploitations = b.listen("exploitation")
            await b.clock.sleep(1.0)
            assert [e.behavior for e in drain(exploitations)] == [None] * 10
            changed = b.clock.now()
            await say(b, "follow", 0.2, times=4)
            follow = drain(exploitations)
            assert follow[0].stamp == changed
            assert {e.behavior for e in follow} == {"PlanAndFollowPath"}
            for _ in range(4):
                b.feed("teleop", Twist(b.clock.now(), -0.1, 0.0))
                await say(b, "follow", 0.2)
            both = drain(exploitations)
            assert {e.behavior for e in both} == {"Teleop"}
            assert both[-1].twist.linear_mps == b.link.commands[-1][1].linear_mps
            await say(b, "follow", 0.2, times=8)
            assert drain(exploitations)[-1].behavior == "PlanAndFollowPath"
            await b.clock.sleep(0.5)
            assert drain(exploitations)[-1].behavior is None

    run_virtual(main())


def test_stopping_the_module_stops_the_base() -> None:
    async def main() -> None:
        async with bench() as b:
            await say(b, "teleop", 0.4, times=10)
        assert speeds(b.link)[-1] == 0.0
        assert b.link.receivers["status"] == []

    run_virtual(main())


def test_the_guards_status_is_published() -> None:
    status = LinkStatus(5.0, "idle", "no command yet", False, None, Twist(5.0, 0, 0), 1.0)

    async def main() -> None:
        async with bench() as b:
            heard = b.listen("status")
            b.link.emit("status", status)
            assert drain(heard) == [status]

    run_virtual(main())


def test_two_behaviors_on_one_input_are_refused() -> None:
    twice = {"behaviors": [{"input": "teleop", "behavior": n, "priority": 1} for n in ("A", "B")]}
    with pytest.raises(WiringError, match="an input of its own"):
        bench(settings=twice)


def test_nothing_drives_the_base_unattended() -> None:
    settings = {"behaviors": [{"input": "teleop", "behavior": "Wander", "priority": 1, "unattended": True}]}
    with pytest.raises(WiringError, match=r"Wander cannot be unattended: nothing drives the base without a desire"):
        bench(settings=settings)
