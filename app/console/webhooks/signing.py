"""Signed requests of the specification Standard Webhooks 1.0 (https://www.standardwebhooks.com), symmetric scheme."""

from __future__ import annotations

import base64
import binascii
import hashlib
import hmac
import secrets

PREFIX = "whsec_"
#: Bytes of a secret, as the specification allows.
SHORTEST, LONGEST = 24, 64


def new_secret() -> str:
    """A random secret of 32 bytes, written as the specification says."""
    return PREFIX + base64.b64encode(secrets.token_bytes(32)).decode()


def secret_bytes(secret: str) -> bytes:
    """The bytes of ``secret``. Raises ValueError, in words for people, where it is none."""
    rule = f"a secret is {PREFIX} and {SHORTEST} to {LONGEST} bytes in base64"
    if not secret.startswith(PREFIX):
        raise ValueError(rule)
    try:
        key = base64.b64decode(secret.removeprefix(PREFIX), validate=True)
    except binascii.Error:
        raise ValueError(rule) from None
    if not SHORTEST <= len(key) <= LONGEST:
        raise ValueError(f"{rule}; this one has {len(key)}")
    return key


def signed(secret: str, message: str, at: float, body: bytes) -> dict[str, str]:
    """The headers of a request with ``body``, sent ``at`` (seconds since the Unix epoch).

    ``message`` is the event's id, the same in each attempt. Raises ValueError for what is no secret.
    """
    stamp = str(int(at))
    content = b".".join((message.encode(), stamp.encode(), body))
    signature = base64.b64encode(hmac.digest(secret_bytes(secret), content, hashlib.sha256)).decode()
    return {"webhook-id": message, "webhook-timestamp": stamp, "webhook-signature": f"v1,{signature}"}
