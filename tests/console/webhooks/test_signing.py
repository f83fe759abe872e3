"""Signatures as the specification Standard Webhooks has them."""

from __future__ import annotations

import base64

import pytest

from app.console.webhooks.signing import new_secret, secret_bytes, signed


def test_the_signature_is_that_of_the_libraries_for_receivers() -> None:
    """The example that the specification's reference libraries test themselves with."""
    headers = signed(
        "whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw",
        "msg_p5jXN8AQM9LWM0D4loKWxJek",
        1614265330.9,
        b'{"test": 2432232314}',
    )
    assert headers == {
        "webhook-id": "msg_p5jXN8AQM9LWM0D4loKWxJek",
        "webhook-timestamp": "1614265330",
        "webhook-signature": "v1,g0hM9SsE+OTPJTGt/tmIKtSyZlE3uFJELVlNIOLJ1OE=",
    }


def test_a_new_secret_is_one_and_another_each_time() -> None:
    assert len(secret_bytes(new_secret())) == 32
    assert new_secret() != new_secret()


@pytest.mark.parametrize(
    "secret",
    ["", "whsec_", "MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw", "whsec_&", *(
        f"whsec_{base64.b64encode(bytes(length)).decode()}" for length in (23, 65)
    )],
)  # fmt: skip
def test_what_is_no_secret_is_refused_in_words(secret: str) -> None:
    with pytest.raises(ValueError, match="a secret is whsec_ and 24 to 64 bytes in base64"):
        secret_bytes(secret)
