"""viser's server, on a loopback port of its own, that answers to our relay alone.

viser has no access control: any client that reaches its port is a viewer, and any viewer may have it open a public
tunnel. What closes both is not part of its public interface; all of that is in this file.
"""

from __future__ import annotations

import asyncio
import warnings
from collections.abc import Callable
from typing import Any

import rich
import viser
from viser import _messages as messages


class ViewHost:
    """Starts with its construction, which takes a while; so may :meth:`stop`. Both are for a worker thread.

    ``admitted(port)`` gives the viewer (any name) whose relay connection comes from the local ``port``, or None for a
    stranger. ``came(viewer, client)`` and ``left(viewer)`` are called in viser's threads.
    """

    def __init__(
        self,
        admitted: Callable[[int], str | None],
        came: Callable[[str, viser.ClientHandle], None],
        left: Callable[[str], None],
    ) -> None:
        # A viewer may leave while it is drawn for: viser's warning of that says nothing.
        warnings.filterwarnings("ignore", message="Queued a .* on a closed connection")
        # viser prints a banner with an address that is not for users; it alone uses rich.
        rich.get_console().quiet = True
        self.server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
        # viser wakes its own loop from other threads in a way that asyncio's debug mode takes for an error.
        self.server._event_loop.set_debug(False)
        self._admitted = admitted
        self._viewers: dict[int, str] = {}
        sockets = self.server._websock_server
        for kind in (messages.ShareUrlRequest, messages.ShareUrlDisconnect):
            sockets.unregister_handler(kind)

        async def admit(connection: Any) -> None:
            live = sockets._live_connections[connection.client_id]
            viewer = self._admitted(live.remote_address[1])
            if viewer is None:
                # A close would wait for the client's answer, and viser would handle what came with the handshake.
                del sockets._live_connections[connection.client_id]
                del sockets._client_state_from_id[connection.client_id]
                live.transport.abort()
                raise asyncio.CancelledError
            self._viewers[connection.client_id] = viewer

        sockets.on_client_connect(admit)

        @self.server.on_client_connect
        def _(client: viser.ClientHandle) -> None:
            viewer = self._viewers.get(client.client_id)
            if viewer is not None:
                came(viewer, client)

        @self.server.on_client_disconnect
        def _(client: viser.ClientHandle) -> None:
            viewer = self._viewers.pop(client.client_id, None)
            if viewer is not None:
                left(viewer)

    @property
    def port(self) -> int:
        return int(self.server.get_port())

    def stop(self) -> None:
        self.server.stop()
