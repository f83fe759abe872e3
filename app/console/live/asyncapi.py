"""The live stream described for tools (AsyncAPI 3): every kind of message both ways, with its JSON Schema."""

from __future__ import annotations

import functools
from collections.abc import Iterable
from typing import Any, Literal, get_args

from app.console import schema
from app.console.access.auth import COOKIE
from app.console.live import protocol
from app.console.live.messages import FROM_ROBOT, TO_FACE, TO_VISITORS

_ABOUT = """One WebSocket carries everything that changes too fast for polling, and in the other direction the
operator's drive commands and voice. Text frames are JSON objects, distinguished by their `type`; binary frames are
pictures and sound, distinguished by their first byte, `kind`. More types and members may be added under the same
`protocol`: ignore unknown ones.
Rates, and the effect of each message: docs/live-stream.md.
"""

_PICTURE = (
    "A header of 24 bytes, then the picture: kind 1 camera and 2 panorama (coding 0: JPEG; of the camera also 1 and 2: "
    "VP9, a key frame or one that needs those before it), 3 map and 4 costmap (PNG)."
)
_SOUND = "Sound of the robot's microphones, kind 16: a header of 24 bytes, then `samples` of int16, little-endian."
_VOICE = "An operator's voice, kind 17: a header of 24 bytes, then `samples` of int16, at most 40 ms."


@functools.cache
def _channel_and_components() -> tuple[dict[str, Any], dict[str, Any], dict[str, Any]]:
    """Channels, operations and components: the same on every console."""
    kinds = FROM_ROBOT | TO_FACE | TO_VISITORS
    records = schema.sent([message.record for message in kinds.values()])
    texts = {
        kind: _text(message.about, schema.with_type(kind, records[message.record.__name__]))
        for kind, message in kinds.items()
    }
    from_robot = {kind: texts[kind] for kind in FROM_ROBOT}
    from_robot["picture"] = _binary(_PICTURE, protocol.PICTURE_HEADER.format, protocol.PICTURE_FIELDS)
    from_robot["sound"] = _binary(_SOUND, protocol.SOUND_HEADER.format, protocol.SOUND_FIELDS)

    structs = get_args(protocol.FromPage)
    commands = schema.received(structs)
    from_page = {
        str(struct.__struct_config__.tag): _text(
            (struct.__doc__ or "").strip(), {"$ref": schema.REFERENCE.format(name=struct.__name__)}
        )
        for struct in structs
    }
    from_page["voice"] = _binary(_VOICE, protocol.SOUND_HEADER.format, protocol.SOUND_FIELDS)

    channel = {
        "address": "/api/v1/live",
        "messages": {name: {"$ref": f"#/components/messages/{name}"} for name in (*from_robot, *from_page)},
        "bindings": {
            "ws": {
                "query": {
                    "type": "object",
                    "properties": {
                        "operator": {
                            "type": "string",
                            "maxLength": 40,
                            "description": "The operator's name, shown to other operators.",
                        }
                    },
                }
            }
        },
    }
    operations = {
        "send_to_page": _operation("send", "The robot to the page.", from_robot),
        "send_to_robot": _operation("receive", "The page to the robot.", from_page),
        "send_to_face": _operation("send", "The robot to a page that shows its face.", TO_FACE, channel="face"),
        "send_to_visitor": _operation("send", "The robot to a visitor's phone.", TO_VISITORS, channel="visitor"),
    }
    face = {
        "address": "/api/v1/face",
        "messages": {name: {"$ref": f"#/components/messages/{name}"} for name in TO_FACE},
    }
    visitor = {
        "address": "/api/v1/visitor/live",
        "messages": {name: {"$ref": f"#/components/messages/{name}"} for name in TO_VISITORS},
    }
    components = {
        "messages": {**texts, **from_robot, **from_page},
        "schemas": records | commands,
        "securitySchemes": {
            "token": {"type": "http", "scheme": "bearer"},
            "session": {"type": "httpApiKey", "in": "cookie", "name": COOKIE},
        },
    }
    return {"live": channel, "face": face, "visitor": visitor}, operations, components


def description(host: str, *, secure: bool = False, token_needed: bool = False, cookie: str = COOKIE) -> dict[str, Any]:
    """The AsyncAPI document of the console reached as ``host`` (name and port), whose session's cookie is ``cookie``.

    The first call takes 0.2 s: call it off the event loop.
    """
    channels, operations, components = _channel_and_components()
    schemes = components["securitySchemes"]
    components = components | {"securitySchemes": schemes | {"session": schemes["session"] | {"name": cookie}}}
    server: dict[str, Any] = {"host": host, "protocol": "wss" if secure else "ws"}
    if token_needed:
        server["security"] = [
            {"$ref": f"#/components/securitySchemes/{name}"} for name in components["securitySchemes"]
        ]
    return {
        "asyncapi": "3.0.0",
        "info": {"title": "HBBA live stream", "version": str(protocol.PROTOCOL), "description": _ABOUT},
        "defaultContentType": "application/json",
        "servers": {"console": server},
        "channels": channels,
        "operations": operations,
        "components": components,
    }


def _text(about: str, payload: schema.Schema) -> dict[str, Any]:
    return {"summary": about, "payload": payload}


def _binary(about: str, layout: str, fields: tuple[str, ...]) -> dict[str, Any]:
    """A message with a header: ``layout`` is that of Python's struct, of ``fields``."""
    return {
        "summary": about,
        "contentType": "application/octet-stream",
        "payload": {"type": "string", "format": "binary"},
        "x-header": {"struct": layout, "fields": list(fields)},
    }


def _operation(
    action: Literal["send", "receive"], about: str, messages: Iterable[str], channel: str = "live"
) -> dict[str, Any]:
    return {
        "action": action,
        "channel": {"$ref": f"#/channels/{channel}"},
        "summary": about,
        "messages": [{"$ref": f"#/channels/{channel}/messages/{name}"} for name in messages],
    }
