"""The webhooks of a robot as they are kept: who is called, of what, and with which secret."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import msgspec
from msgspec import Meta

from app.base.named_library import data_folder
from app.base.web_address import checked_url
from app.base.whole_file import write_whole
from app.console.webhooks.signing import secret_bytes
from app.messages import EventKind

MOST_HOOKS = 20
_FILE = "webhooks.json"


class WebhooksUnreadable(Exception):
    """The file of webhooks is none; the message names it, and what to do."""


@dataclass(frozen=True, slots=True)
class Webhook:
    """``url`` gets the events of ``kinds``, and of one ``subject`` where that is not empty, signed with ``secret``."""

    id: str
    url: str
    kinds: Annotated[tuple[EventKind, ...], Meta(min_length=1)]
    subject: str
    secret: str

    def __post_init__(self) -> None:
        checked_url(self.url)
        secret_bytes(self.secret)


def default_file() -> Path:
    """Where they are kept: in ``$HBBA_WEBHOOKS``, a folder, or ``hbba/webhooks`` in the user's data folder."""
    return data_folder("HBBA_WEBHOOKS", "webhooks") / _FILE


def read_webhooks(file: Path) -> tuple[Webhook, ...]:
    """Those kept in ``file``; none where there is no file. Raises WebhooksUnreadable, OSError."""
    try:
        content = file.read_bytes()
    except FileNotFoundError:
        return ()
    try:
        return msgspec.json.decode(content, type=tuple[Webhook, ...])
    except (msgspec.DecodeError, ValueError) as error:
        raise WebhooksUnreadable(f"{file}: {error}; mend the file, or remove it to have no webhooks") from None


def write_webhooks(file: Path, hooks: Iterable[Webhook]) -> None:
    """Keep ``hooks`` in ``file``, wholly or not at all, readable by this user alone. Raises OSError."""
    file.parent.mkdir(parents=True, exist_ok=True)
    write_whole(file, msgspec.json.format(msgspec.json.encode(tuple(hooks)), indent=2) + b"\n", mode=0o600)
