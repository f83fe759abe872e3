"""The file of a fleet: where the consoles of the other robots are, and what they are asked with."""

from __future__ import annotations

import ssl
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlsplit

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from app.base.plain_file import read_plain
from app.base.web_address import checked_url
from app.base.yaml_source import load_yaml

MOST_ROBOTS = 50
_MOST_TOKEN_BYTES = 1024


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class FleetEntry(_Model):
    """The console of one robot, as the file declares it; paths are relative to the file."""

    url: str = Field(description="where its console is: scheme, host and port alone")
    token_file: Path | None = Field(None, description="file with its token, or the password of its spectators")
    ca: Path | None = Field(None, description="certificate (PEM) of the authority of its own, for https")

    @field_validator("url")
    @classmethod
    def _is_a_console(cls, url: str) -> str:
        parts = urlsplit(checked_url(url))
        if parts.path not in ("", "/") or parts.query:
            raise ValueError("a console's URL is its scheme, host and port alone")
        return f"{parts.scheme}://{parts.netloc.lower()}"

    @model_validator(mode="after")
    def _verifies(self) -> FleetEntry:
        if self.ca is not None and not self.url.startswith("https:"):
            raise ValueError("ca is for https: the url is http")
        return self


class FleetFile(_Model):
    """The file."""

    robots: tuple[FleetEntry, ...] = Field(min_length=1, max_length=MOST_ROBOTS)


@dataclass(frozen=True, slots=True)
class RobotConsole:
    """Where one robot is asked; ``token`` None: without a login; ``tls`` None: by http."""

    url: str
    token: str | None = None
    tls: ssl.SSLContext | None = None


def load_fleet(path: Path) -> tuple[RobotConsole, ...]:
    """The consoles that a fleet's file names, in its order. Raises ConfigError, with file and line."""
    document = load_yaml(path)
    consoles: dict[str, RobotConsole] = {}
    for number, entry in enumerate(document.validate(FleetFile).robots):
        if entry.url in consoles:
            raise document.error(f"{entry.url} is named twice", ("robots", number, "url"))
        try:
            token = None if entry.token_file is None else _token(path.parent / entry.token_file)
        except ValueError as failure:
            raise document.error(str(failure), ("robots", number, "token_file")) from None
        try:
            tls = _tls(entry, path.parent)
        except ValueError as failure:
            raise document.error(str(failure), ("robots", number, "ca")) from None
        consoles[entry.url] = RobotConsole(entry.url, token, tls)
    return tuple(consoles.values())


def _token(file: Path) -> str:
    try:
        token = read_plain(file, _MOST_TOKEN_BYTES).decode("ascii").strip()
    except OSError as failure:
        raise ValueError(f"{file} cannot be read: {failure.strerror}") from None
    except UnicodeDecodeError:
        token = ""
    if not token or not token.isprintable():
        raise ValueError(f"{file} should hold one line, the token")
    return token


def _tls(entry: FleetEntry, folder: Path) -> ssl.SSLContext | None:
    if not entry.url.startswith("https:"):
        return None
    if entry.ca is None:
        return ssl.create_default_context()
    file = folder / entry.ca
    try:
        return ssl.create_default_context(cafile=str(file))
    except (OSError, ssl.SSLError) as failure:
        raise ValueError(f"{file} is no certificate in PEM: {failure.strerror or failure}") from None
