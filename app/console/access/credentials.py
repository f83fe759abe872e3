"""What opens the console: the token, and the passwords of roles out of a file."""

from __future__ import annotations

import hmac
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, TypeAlias

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, PlainValidator

from app.base.errors import ConfigError
from app.base.yaml_source import load_yaml
from app.console.access.passwords import PasswordHash, parsed
from app.console.access.roles import Role

#: Each takes a try's time at a login.
MOST_OF_A_ROLE = 8


def _one_or_more(value: Any) -> Any:
    return [value] if isinstance(value, str) else value


def _hash(value: Any) -> PasswordHash:
    if not isinstance(value, str):
        raise ValueError("is no hash of a password: write the line that `hbba password` prints")
    return parsed(value)


_Hashes = Annotated[
    tuple[Annotated[PasswordHash, PlainValidator(_hash)], ...],
    BeforeValidator(_one_or_more),
    Field(max_length=MOST_OF_A_ROLE),
]


class _AccessFile(BaseModel):
    """Hashes of passwords by role."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    spectator: _Hashes = ()
    operator: _Hashes = ()
    supervisor: _Hashes = ()


#: Each with the role that it opens.
Passwords: TypeAlias = tuple[tuple[Role, PasswordHash], ...]


@dataclass(frozen=True, slots=True)
class Credentials:
    """The ``token``, which is a supervisor's, and the ``passwords`` of roles; neither: no login is asked for."""

    token: str | None = None
    passwords: Passwords = ()

    @property
    def asked(self) -> bool:
        """Whether a login is needed."""
        return self.token is not None or bool(self.passwords)

    def is_token(self, secret: str) -> bool:
        """Whether ``secret`` is the token (compared in constant time)."""
        if self.token is None:
            return False
        return hmac.compare_digest(self.token.encode(), secret.encode(errors="surrogatepass"))

    def role_of_password(self, secret: str) -> Role | None:
        """The highest role that the password ``secret`` opens; None: none. Blocks: for a worker thread."""
        # All are tried, so that the time does not say which role a guess is near to.
        opened = [role for role, password in self.passwords if password.matches(secret)]
        return max(opened, key=list(Role).index, default=None)


def read_access(file: Path) -> Passwords:
    """The passwords in ``file``, by role. Raises ConfigError naming file and line."""
    document = load_yaml(file)
    access = document.validate(_AccessFile)
    passwords = tuple((role, each) for role in Role for each in getattr(access, role.value))
    if not passwords:
        raise ConfigError(f"{file}: no role has a password here; `hbba password` makes the line for one")
    return passwords
