"""Where a robot may listen for nodes."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from app.remote.session import configuration
from app.remote.settings import NodesSettings, checked_endpoint

DESK = {"desk": {"modules": ["FaceDetector"]}}


@pytest.mark.parametrize("endpoint", ["tcp/127.0.0.1:7447", "tcp/localhost:1", "tcp/[::1]:7447", "tls/robot.lan:7447"])
def test_loopback_and_encrypted_endpoints_may_be_used(endpoint: str) -> None:
    assert checked_endpoint(endpoint) == endpoint


@pytest.mark.parametrize(
    "endpoint", ["tcp/0.0.0.0:7447", "tcp/robot.lan:7447", "tcp/192.168.1.2:7447", "tcp/[::]:7447"]
)
def test_nothing_leaves_this_computer_unencrypted(endpoint: str) -> None:
    with pytest.raises(ValueError, match="unencrypted"):
        checked_endpoint(endpoint)


@pytest.mark.parametrize("endpoint", ["", "7447", "udp/127.0.0.1:7447", "tcp/127.0.0.1", "tcp/127.0.0.1:70000"])
def test_what_is_no_endpoint_is_refused(endpoint: str) -> None:
    with pytest.raises(ValueError, match=r"should be tcp/HOST:PORT"):
        checked_endpoint(endpoint)


def test_encryption_needs_certificates() -> None:
    with pytest.raises(ValidationError, match="tls should name"):
        NodesSettings.model_validate({"listen": "tls/0.0.0.0:7447", "computers": DESK})
    with pytest.raises(ValueError, match="needs certificates"):
        configuration(join="tls/robot.lan:7447")


@pytest.mark.parametrize("name", ["", "a b", "a/b", "*", "desk@home"])
def test_a_computer_has_a_plain_name(name: str) -> None:
    with pytest.raises(ValidationError, match="named by letters"):
        NodesSettings.model_validate({"computers": {name: DESK["desk"]}})


def test_nobody_is_scouted_for() -> None:
    settings = configuration(listen="tcp/127.0.0.1:7447")
    assert settings["scouting/multicast/enabled"] is False
    assert settings["scouting/gossip/enabled"] is False
