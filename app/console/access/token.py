"""The token that a console asks for: where it comes from, and what it must be like."""

from __future__ import annotations

import os
import secrets
from collections.abc import MutableMapping
from pathlib import Path

from app.base.errors import ConfigError

#: The environment variable that may hold it.
VARIABLE = "HBBA_TOKEN"
SHORTEST = 8
#: More than a token can be: a wrong file was named.
LONGEST = 1024


def given_token(file: Path | None, environment: MutableMapping[str, str] | None = None) -> str | None:
    """The token in ``file``, else that of the variable HBBA_TOKEN, which is taken out of ``environment`` (default: this
    process's), so that no child process has it; None where there is neither.

    It is never taken from the command line, which every user of the computer can read. Raises ConfigError.
    """
    variable = (os.environ if environment is None else environment).pop(VARIABLE, None)
    if file is not None:
        return _read(file)
    if variable is None:
        return None
    return _checked(variable.strip(), f"the variable {VARIABLE}")


def new_token() -> str:
    """A token to print at the start: 128 random bits."""
    return secrets.token_urlsafe(16)


def _read(file: Path) -> str:
    try:
        with file.open("rb") as opened:
            content = opened.read(LONGEST + 1)
        return _checked(content.decode().strip(), f"--token-file {file}")
    except OSError as failure:
        raise ConfigError(f"--token-file {file}: cannot be read: {failure.strerror or failure}") from None
    except UnicodeDecodeError:
        raise ConfigError(f"--token-file {file}: holds no text in UTF-8") from None


def _checked(token: str, where: str) -> str:
    if not SHORTEST <= len(token) <= LONGEST or not token.isprintable():
        raise ConfigError(f"{where}: a token has {SHORTEST} to {LONGEST} characters, in one line")
    return token
