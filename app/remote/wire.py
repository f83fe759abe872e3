"""What goes over the link between the robot and a node: envelopes in MessagePack, distinguished by a tag.

robot ─▶ node   Data: a message for an input     Orders: parameters, outputs wanted     Beat: are you there?
node ─▶ robot   Result: an output's message      Handled: an input's message is done    Pulse: the beat's answer
node ─▶ robot   Offer, asked as a query          Admission, its answer
"""

from __future__ import annotations

from typing import Annotated, Any, TypeAlias

import msgspec

#: Whole numbers up to here are what they are in every recording and on every page.
MOST_KEPT = 2**53
#: Numbers that a module keeps over restarts (``Module.persistent``), which the same module elsewhere goes on from.
Kept: TypeAlias = Annotated[
    dict[Annotated[str, msgspec.Meta(max_length=64)], Annotated[int, msgspec.Meta(ge=-MOST_KEPT, le=MOST_KEPT)]],
    msgspec.Meta(max_length=16),
]


class Data(msgspec.Struct, frozen=True, tag=True):
    """A message for input ``port`` of ``module``, number ``seq`` of this link; 0: it need not be confirmed."""

    module: str
    port: str
    seq: int
    payload: bytes
    kept: Kept = {}


class Orders(msgspec.Struct, frozen=True, tag=True):
    """The intention's parameters for ``module``, and whether each of its outputs is wanted."""

    module: str
    parameters: dict[str, Any]
    wanted: dict[str, bool]


class Beat(msgspec.Struct, frozen=True, tag=True):
    """Asked five times a second, at ``now`` of the robot's clock (s). ``filling``: as many bytes as a message has,
    where the link is to be tried."""

    seq: int
    now: float
    filling: bytes = b""


ToNode: TypeAlias = Data | Orders | Beat


class Result(msgspec.Struct, frozen=True, tag=True):
    """A message that ``module`` published on its output ``port``."""

    module: str
    port: str
    payload: bytes
    kept: Kept = {}


class Handled(msgspec.Struct, frozen=True, tag=True):
    """The handler of the message ``seq`` has returned; what it published was sent before."""

    seq: int


class Pulse(msgspec.Struct, frozen=True, tag=True):
    """The answer to the beat ``seq``; ``down``: modules that do not run, each with the reason."""

    seq: int
    down: dict[str, str] = {}


FromNode: TypeAlias = Result | Handled | Pulse


class PortShape(msgspec.Struct, frozen=True):
    """A port's message type, by its fields (:func:`app.remote.codec.shape_of`)."""

    message: str
    fields: dict[str, str]


class ModuleOffer(msgspec.Struct, frozen=True):
    """A module as one end understands it. ``settings``: JSON of all of them."""

    class_path: str
    settings: dict[str, Any]
    inputs: dict[str, PortShape]
    outputs: dict[str, PortShape]


class Offer(msgspec.Struct, frozen=True):
    """What a node says of itself when it joins: ``instance`` names this membership, ``process`` the program there."""

    node: str
    instance: str
    process: str
    host: str
    version: str
    modules: dict[str, ModuleOffer]


class Admission(msgspec.Struct, frozen=True):
    """The robot's answer: ``refusal`` in words, "" if the node has joined; the robot's clock then (s)."""

    refusal: str
    now: float


_encode = msgspec.msgpack.Encoder().encode
_to_node = msgspec.msgpack.Decoder(ToNode)
_from_node = msgspec.msgpack.Decoder(FromNode)
_offer = msgspec.msgpack.Decoder(Offer)
_admission = msgspec.msgpack.Decoder(Admission)

#: What a decoder raises for bytes that are no such envelope.
BadEnvelope = msgspec.DecodeError


def encode(envelope: ToNode | FromNode | Offer | Admission) -> bytes:
    """The bytes of ``envelope``."""
    return _encode(envelope)


def to_node(data: bytes) -> ToNode:
    """What the robot sent. Raises BadEnvelope."""
    envelope: ToNode = _to_node.decode(data)
    return envelope


def from_node(data: bytes) -> FromNode:
    """What a node sent. Raises BadEnvelope."""
    envelope: FromNode = _from_node.decode(data)
    return envelope


def offer(data: bytes) -> Offer:
    """What a node says of itself. Raises BadEnvelope."""
    return _offer.decode(data)


def admission(data: bytes) -> Admission:
    """The robot's answer to an offer. Raises BadEnvelope."""
    return _admission.decode(data)
