"""Who makes a request: noted in its ASGI scope by the door, read by routes."""

from __future__ import annotations

from dataclasses import dataclass

from starlette.types import Scope

from app.console.access.roles import Role, in_words
from app.console.problems import Problem
from app.console.records.program import RoleName

_KEY = "hbba.identity"


@dataclass(frozen=True, slots=True)
class Identity:
    """A role, None for a visitor; and the ``key`` of a login, the same for all that a browser does until it ends."""

    role: Role | None
    key: str


#: Anyone on this computer, where no login is asked for.
LOCAL = Identity(Role.SUPERVISOR, "local")
#: A phone with the key of a tour's run, which the door lets in to what is for visitors alone.
VISITOR = Identity(None, "visitor")


def note_identity(scope: Scope, identity: Identity) -> None:
    """Note who makes the request of ``scope``."""
    scope[_KEY] = identity


def identity_of(scope: Scope) -> Identity | None:
    """Who makes a request; None: no login was asked for at its path."""
    identity: Identity | None = scope.get(_KEY)
    return identity


def require(identity: Identity | None, needed: Role, what: str) -> None:
    """Raises Problem where ``identity`` may not do ``what``, which needs the role ``needed``.

    A visitor may: the door has let it in to nothing else. None, where no login was asked for, may not."""
    if identity is None:
        raise Problem(401, "login-needed", f"{what} needs a login.")
    if identity.role is not None and not identity.role.covers(needed):
        detail = f"{what} needs the role {needed}; you are logged in as {in_words(identity.role)}."
        raise Problem(403, "role-needed", detail, role=identity.role.value, needed=needed.value)


def role_name(identity: Identity) -> RoleName:
    """The role as the page is given it. Raises ValueError for a visitor."""
    match identity.role:
        case Role.SPECTATOR:
            return "spectator"
        case Role.OPERATOR:
            return "operator"
        case Role.SUPERVISOR:
            return "supervisor"
        case None:
            raise ValueError("a visitor has no role")
