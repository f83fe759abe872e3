"""Logins by password: one is checked at a time, wrong ones are slowed, right ones are known."""

from __future__ import annotations

import asyncio
import threading

import pytest
from argon2 import PasswordHasher

from app.console.access import login_check
from app.console.access.credentials import Credentials
from app.console.access.login_check import MOST_WAITING, LoginCheck
from app.console.access.passwords import hash_of
from app.console.access.roles import Role
from app.console.problems import Problem
from tests.patience import PATIENCE_S

WORD = "correct horse"

CHEAP = PasswordHasher(time_cost=1, memory_cost=8, parallelism=1)


class Counted(Credentials):
    """Credentials whose checks are counted, and wait for leave."""

    def __init__(self, *words: str) -> None:
        super().__init__(passwords=tuple((Role.OPERATOR, hash_of(word, CHEAP)) for word in words))
        object.__setattr__(self, "checks", [])
        object.__setattr__(self, "started", threading.Event())
        object.__setattr__(self, "leave", threading.Event())
        self.leave.set()

    checks: list[str]
    started: threading.Event
    leave: threading.Event

    def role_of_password(self, secret: str) -> Role | None:
        self.checks.append(secret)
        self.started.set()
        assert self.leave.wait(PATIENCE_S)
        return super().role_of_password(secret)


@pytest.fixture
def credentials() -> Counted:
    """An operator's password."""
    return Counted(WORD)


async def test_a_right_password_costs_once_and_a_wrong_one_each_time(credentials: Counted) -> None:
    check = LoginCheck(credentials, lambda: 0.0)
    for _ in range(3):
        assert await check.role_of(WORD, "10.0.0.5") is Role.OPERATOR
    assert len(credentials.checks) == 1
    for _ in range(2):
        with pytest.raises(Problem, match="opens nothing"):
            await check.role_of("wrong", "10.0.0.5")
    assert len(credentials.checks) == 3


async def test_wrong_passwords_are_slowed_even_where_they_come_at_once(credentials: Counted) -> None:
    check = LoginCheck(credentials, lambda: 0.0)
    tries = (check.role_of(f"wrong {n}", "10.0.0.5") for n in range(MOST_WAITING))
    outcomes = await asyncio.gather(*tries, return_exceptions=True)
    kinds = [outcome.kind for outcome in outcomes if isinstance(outcome, Problem)]
    assert kinds == ["wrong-token"] * 6 + ["too-many-attempts"] * (MOST_WAITING - 6)
    assert await check.role_of(WORD, "10.0.0.6") is Role.OPERATOR, "another address does not wait"


async def test_few_wait_for_a_check_and_the_loop_goes_on(credentials: Counted) -> None:
    check = LoginCheck(credentials, lambda: 0.0)
    credentials.leave.clear()
    waiting = [asyncio.create_task(check.role_of(WORD, f"10.0.0.{n}")) for n in range(MOST_WAITING)]
    await asyncio.to_thread(credentials.started.wait, PATIENCE_S)
    with pytest.raises(Problem, match="Many passwords are being checked") as busy:
        await check.role_of(WORD, "10.0.1.1")
    assert busy.value.status == 503
    credentials.leave.set()
    assert set(await asyncio.gather(*waiting)) == {Role.OPERATOR}
    assert len(credentials.checks) == 1, "the others knew it by then"


async def test_few_right_passwords_are_remembered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(login_check, "MOST_KNOWN", 1)
    words = ("first password", "second password")
    credentials = Counted(*words)
    check = LoginCheck(credentials, lambda: 0.0)
    for word in (*words, words[1], words[0]):
        await check.role_of(word, "10.0.0.5")
    assert credentials.checks == [*words, words[0]]
