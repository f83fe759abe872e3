"""Addresses of other programs on the web, as people write them."""

from __future__ import annotations

import re
from urllib.parse import SplitResult, urlsplit

LONGEST_URL = 2000


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
