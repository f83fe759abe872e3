"""Webhooks on the disk."""

from __future__ import annotations

import re
import stat
from pathlib import Path

import pytest

from app.base.web_address import checked_url
from app.console.webhooks.kept import Webhook, WebhooksUnreadable, read_webhooks, write_webhooks
from app.console.webhooks.signing import new_secret


def hook(url: str = "https://example.org/robot") -> Webhook:
    return Webhook("one", url, ("tour", "goal"), "", new_secret())


def test_what_is_kept_is_read_and_is_this_users_alone(tmp_path: Path) -> None:
    file = tmp_path / "new" / "webhooks.json"
    assert read_webhooks(file) == ()
    write_webhooks(file, [hook()])
    write_webhooks(file, kept := (hook(), hook("http://127.0.0.1:9/")))
    assert read_webhooks(file) == kept
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    assert [path.name for path in file.parent.iterdir()] == ["webhooks.json"]


@pytest.mark.parametrize(
    "url",
    [
        "",
        "example.org",
        "ftp://example.org/",
        "https://",
        "https://ann:secret@example.org/",
        "https://example.org/#there",
        "https://example.org:0/",
        "https://example.org:65536/",
        "https://[::1/",
        "https://example.org/a b",
        "https://example.org/\n",
        f"https://example.org/{'a' * 2000}",
    ],
)
def test_what_cannot_be_posted_to_is_refused(url: str) -> None:
    with pytest.raises(ValueError, match="a URL "):
        checked_url(url)


@pytest.mark.parametrize(
    "content",
    [b"", b"{}", b'[{"id": "one"}]', b'[{"id":"a","url":"ftp://b","kinds":["tour"],"subject":"","secret":""}]'],
)
def test_a_file_that_is_none_is_named(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "webhooks.json"
    file.write_bytes(content)
    with pytest.raises(WebhooksUnreadable, match=re.escape(f"{file}: ")):
        read_webhooks(file)
