"""The webhooks of a robot as they are kept: who is called, of what, and with which secret."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated
from urllib.parse import SplitResult, urlsplit

import msgspec
from msgspec import Meta

from app.base.named_library import data_folder
from app.console.webhooks.signing import secret_bytes
from app.messages import EventKind

MOST_HOOKS = 20
LONGEST_URL = 2000
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


def checked_url(url: str) -> str:
    """``url``, if it is one that can be posted to. Raises ValueError, in words for people."""
    rule = "a URL begins with https:// or http:// and names a host; it has no user, password or fragment"
    if len(url) > LONGEST_URL:
        raise ValueError(f"a URL has at most {LONGEST_URL} characters, this one {len(url)}")
    if re.search(r"[\s\x00-\x1f\x7f]", url):
        raise ValueError("a URL has no white space and no control characters")
    try:
        parts = urlsplit(url)
        fit = parts.scheme in ("http", "https") and parts.hostname and not _private(parts) and parts.port != 0
    except ValueError:  # of what urlsplit cannot read, a port beyond 65535 among them
        fit = False
    if not fit:
        raise ValueError(rule)
    return url


def _private(parts: SplitResult) -> bool:
    return bool(parts.username or parts.password or parts.fragment)


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
    draft = file.with_name(f".{file.name}.new")
    draft.unlink(missing_ok=True)
    descriptor = os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    with os.fdopen(descriptor, "wb") as opened:
        opened.write(msgspec.json.format(msgspec.json.encode(tuple(hooks)), indent=2) + b"\n")
        opened.flush()
        os.fsync(descriptor)
    draft.replace(file)
