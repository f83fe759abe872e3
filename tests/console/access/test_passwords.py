"""Passwords at rest, and the file that they are in."""

from __future__ import annotations

from pathlib import Path

import pytest
from argon2 import PasswordHasher, extract_parameters

from app import cli
from app.base.errors import ConfigError
from app.console.access.credentials import Credentials, read_access
from app.console.access.passwords import hash_of, parsed
from app.console.access.roles import Role

CHEAP = PasswordHasher(time_cost=1, memory_cost=8, parallelism=1)


def test_a_password_opens_by_its_hash_alone_and_no_other_does() -> None:
    kept = parsed(str(hash_of("correct horse", CHEAP)))
    assert kept.matches("correct horse")
    assert not kept.matches("correct horsf")
    assert not kept.matches("")
    assert "horse" not in str(kept)
    assert str(hash_of("correct horse", CHEAP)) != str(kept), "each has a salt of its own"


@pytest.mark.parametrize("password", ["short", "x" * 513, "two\nlines of it"])
def test_what_is_no_password_is_refused(password: str) -> None:
    with pytest.raises(ValueError, match="8 to 512 characters, in one line"):
        hash_of(password)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("correct horse", "hbba password"),
        ("$scrypt$ln=15,r=8,p=3$AAAA$AAAA", "hbba password"),
        ("$argon2id$v=19$m=9999999,t=3,p=4$AAAAAAAAAAAAAAAAAAAAAA$AAAAAAAAAAAAAAAAAAAAAAAAAAAAAA", "m is at most"),
        ("$argon2id$v=19$m=65536,t=99,p=4$AAAAAAAAAAAAAAAAAAAAAA$AAAAAAAAAAAAAAAAAAAAAAAAAAAAAA", "t 16"),
        ("$argon2id$v=19$m=65536,t=3,p=4$AAAAAAAAAAAAAAAAAAAAAA", "cut off"),
        ("$argon2id$v=19$m=65536,t=3,p=4$AAAA$AAAA", "cut off"),
    ],
)
def test_what_is_no_hash_is_refused_with_file_and_line(tmp_path: Path, line: str, words: str) -> None:
    file = tmp_path / "access.yaml"
    file.write_text(f"# Who may.\nspectator: []\noperator: '{line}'\n")
    with pytest.raises(ConfigError, match=words) as refusal:
        read_access(file)
    assert str(refusal.value).startswith(f"{file}:3: ")


def test_a_file_gives_one_or_several_passwords_to_a_role(tmp_path: Path) -> None:
    file = tmp_path / "access.yaml"
    lines = [str(hash_of(word, CHEAP)) for word in ("ann's word", "bob's word", "the boss's word")]
    file.write_text(f"operator:\n  - {lines[0]}\n  - {lines[1]}\nsupervisor: {lines[2]}\n")
    credentials = Credentials(passwords=read_access(file))
    assert credentials.asked
    assert credentials.role_of_password("ann's word") is Role.OPERATOR
    assert credentials.role_of_password("bob's word") is Role.OPERATOR
    assert credentials.role_of_password("the boss's word") is Role.SUPERVISOR
    assert credentials.role_of_password("another word") is None


@pytest.mark.parametrize(("text", "words"), [("", "no role has a password"), ("driver: x\n", "driver")])
def test_a_file_without_passwords_or_with_another_role_is_refused(tmp_path: Path, text: str, words: str) -> None:
    file = tmp_path / "access.yaml"
    file.write_text(text)
    with pytest.raises(ConfigError, match=words):
        read_access(file)


def test_a_password_that_opens_two_roles_opens_the_higher() -> None:
    both = tuple((role, hash_of("the same word", CHEAP)) for role in (Role.SUPERVISOR, Role.SPECTATOR))
    assert Credentials(passwords=both).role_of_password("the same word") is Role.SUPERVISOR


def test_the_command_writes_a_line_that_the_file_takes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    import io

    monkeypatch.setattr("sys.stdin", io.StringIO("correct horse\n"))
    assert cli.main(["password", "--role", "supervisor"]) == 0
    file = tmp_path / "access.yaml"
    file.write_text(capsys.readouterr().out)
    ((role, kept),) = read_access(file)
    assert role is Role.SUPERVISOR
    cost = extract_parameters(str(kept))
    assert (cost.memory_cost, cost.time_cost, cost.parallelism) == (65536, 3, 4)
    assert kept.matches("correct horse")
