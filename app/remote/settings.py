"""The computers that may run modules of a program, as its file declares them under ``nodes``."""

from __future__ import annotations

import ipaddress
import re
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

_ENDPOINT = re.compile(r"(?P<protocol>tcp|tls)/(?P<host>\[[0-9a-fA-F:.]+\]|[\w.-]+):(?P<port>\d{1,5})")
_NAME = r"^[A-Za-z][A-Za-z0-9_-]*$"


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class TlsFiles(_Model):
    """Files (PEM) of one end of an encrypted link, of which each proves to the other who it is."""

    ca: Path = Field(description="certificate of the authority that signed both ends' certificates")
    certificate: Path = Field(description="this end's own certificate")
    key: Path = Field(description="its private key")


class NodeSettings(_Model):
    """One other computer: what it may run, and what it and the link to it can bear."""

    modules: tuple[str, ...] = Field(min_length=1, description="modules of this program that it may run")
    cpu: float = Field(100.0, ge=0, le=1e6, description="what modules may use there, % of one core")
    speed: float = Field(1.0, gt=0, le=1000, description="how many times as fast a core of it is as one of the robot")
    bandwidth: float = Field(5.0, ge=0, le=1e5, description="what modules may send there, MB/s")
    deadline_s: float = Field(
        0.5, gt=0, le=60, description="95 % of all messages must be answered within it, or nothing is sent there"
    )
    images: Literal["jpeg", "raw"] = Field("jpeg", description="how the colours of images travel")
    quality: int = Field(85, ge=1, le=100, description="of JPEG")


class NodesSettings(_Model):
    """Where the robot listens, and the computers that may join it there."""

    listen: str = Field("tcp/127.0.0.1:7447", description="tcp/HOST:PORT on this computer alone, else tls/HOST:PORT")
    tls: TlsFiles | None = Field(None, description="of the robot's end, for tls/")
    computers: dict[str, NodeSettings] = Field(min_length=1, description="by name")

    @field_validator("listen")
    @classmethod
    def _listens(cls, value: str) -> str:
        return checked_endpoint(value)

    @field_validator("computers")
    @classmethod
    def _named(cls, value: dict[str, NodeSettings]) -> dict[str, NodeSettings]:
        for name in value:
            if not re.match(_NAME, name):
                raise ValueError(f"a computer is named by letters, digits, - and _, a letter first, not {name!r}")
        return value

    @model_validator(mode="after")
    def _encrypted(self) -> NodesSettings:
        if self.listen.startswith("tls/") and self.tls is None:
            raise ValueError("listen is tls/: tls should name ca, certificate and key")
        return self


def checked_endpoint(value: str) -> str:
    """``value`` if it is an endpoint that may be used: ``tcp/`` on this computer alone, ``tls/`` anywhere.

    Raises ValueError.
    """
    found = _ENDPOINT.fullmatch(value)
    if found is None or int(found["port"]) > 65535:
        raise ValueError(f"should be tcp/HOST:PORT or tls/HOST:PORT, not {value!r}")
    if found["protocol"] == "tcp" and not _is_loopback(found["host"].strip("[]")):
        raise ValueError(f"{value} leaves this computer unencrypted: tls/HOST:PORT, with certificates at both ends")
    return value


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"
