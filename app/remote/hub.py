"""The robot's side of all nodes: listens, admits who agrees with it, and says which may be used."""

from __future__ import annotations

import asyncio
import functools
import logging
from collections.abc import Callable, Mapping
from contextlib import AsyncExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.base import paths
from app.remote import wire
from app.remote.contract import Described, describe, refusal
from app.remote.health import BEAT_S
from app.remote.link import NodeLink
from app.remote.session import PREFIX, ROBOT_ALIVE, Mailbox, configuration, join_key, open_session
from app.remote.settings import NodesSettings, TlsFiles
from app.remote.wire import Admission, Offer
from app.runtime.clock import Clock
from app.runtime.graph import ModuleSpec

if TYPE_CHECKING:
    import zenoh

log = logging.getLogger("hbba.remote")

#: The class of modules at home that stand for those elsewhere.
STAND_IN = "app.remote.stand_in:RemoteModule"


class NodeHub:
    """The nodes of a program: ``async with hub:`` listens for them."""

    def __init__(self, settings: NodesSettings, modules: Mapping[str, ModuleSpec], clock: Clock, folder: Path) -> None:
        """``modules`` as configured; files of certificates are relative to ``folder``. Raises NotElsewhere for a module
        that cannot run elsewhere, KeyError for one that there is not."""
        self.settings = settings
        self._clock = clock
        self._folder = folder
        self._links = {name: NodeLink(name, node, clock) for name, node in settings.computers.items()}
        self._described: dict[str, dict[str, Described]] = {
            name: {module: describe(module, modules[module]) for module in node.modules}
            for name, node in settings.computers.items()
        }
        self._offers = {
            node: {name: module.offer() for name, module in modules.items()}
            for node, modules in self._described.items()
        }
        self._version = paths.version()
        self._session: zenoh.Session | None = None
        self._declared: list[object] = []
        self._stack = AsyncExitStack()

    def link(self, node: str) -> NodeLink:
        """The link to ``node``. Raises KeyError."""
        return self._links[node]

    @property
    def links(self) -> Mapping[str, NodeLink]:
        """All of them, by name."""
        return self._links

    def stand_ins(self) -> dict[str, ModuleSpec]:
        """The modules at home, ``Module@node`` each."""
        found = {}
        for node, described in self._described.items():
            computer = self.settings.computers[node]
            for name, module in described.items():
                settings = {
                    "node": node,
                    "module": name,
                    "spec": module.spec.model_dump(by_alias=True, exclude_unset=True),
                    "quality": computer.quality if computer.images == "jpeg" else None,
                }
                found[stand_in_name(name, node)] = ModuleSpec.model_validate(
                    {
                        "class": STAND_IN,
                        "inputs": module.spec.inputs,
                        "outputs": module.spec.outputs,
                        "settings": settings,
                        "stands_for": name,
                        # It waits for an answer as long as that may take, and is no more hung for it.
                        "hang_after_s": max(module.spec.hang_after_s, 2 * computer.deadline_s),
                    }
                )
        return found

    def observe(self, callback: Callable[[str, bool, str], None]) -> Callable[[], None]:
        """Call ``callback(node, usable, why)`` for each node now, and at each change; returns a function that ends
        this."""
        ends = [link.observe(functools.partial(callback, name)) for name, link in self._links.items()]

        def end() -> None:
            for each in ends:
                each()

        return end

    async def __aenter__(self) -> NodeHub:
        """Listen. Raises ConfigError where that cannot be."""
        async with AsyncExitStack() as stack:
            tls = self.settings.tls
            files = None if tls is None else absolute(tls, self._folder)
            session = await asyncio.to_thread(open_session, configuration(listen=self.settings.listen, tls=files))
            self._session = session
            stack.push_async_callback(asyncio.to_thread, session.close)
            for link in self._links.values():
                stack.callback(link.leave, f"{link.name} is no longer listened to")
            queries: Mailbox[zenoh.Query] = Mailbox("nodes that join", self._admit)
            tokens: Mailbox[tuple[str, bool]] = Mailbox("nodes that leave", self._token)
            stack.callback(queries.close)
            stack.callback(tokens.close)
            await asyncio.to_thread(self._declare, session, queries, tokens)
            beats = asyncio.create_task(self._beat(), name="beats of nodes")
            stack.callback(beats.cancel)
            log.info("nodes may join at %s: %s", self.settings.listen, ", ".join(self._links))
            self._stack = stack.pop_all()
        return self

    async def __aexit__(self, *_: object) -> None:
        await self._stack.aclose()

    def _declare(
        self, session: zenoh.Session, queries: Mailbox[zenoh.Query], tokens: Mailbox[tuple[str, bool]]
    ) -> None:
        import zenoh

        def changed(sample: zenoh.Sample) -> None:
            tokens.put((str(sample.key_expr), sample.kind == zenoh.SampleKind.PUT))

        # What is not kept is undeclared.
        watched = session.liveliness().declare_subscriber(f"{PREFIX}/*/*/alive", changed, history=True)
        asked = [session.declare_queryable(join_key(name), queries.put) for name in self._links]
        self._declared = [watched, *asked, session.liveliness().declare_token(ROBOT_ALIVE)]

    def _admit(self, query: zenoh.Query) -> None:
        name = str(query.key_expr).split("/")[-2]
        link, session = self._links.get(name), self._session
        if link is None or session is None or query.payload is None:
            return
        try:
            offer: Offer = wire.offer(query.payload.to_bytes())
        except wire.BadEnvelope as failure:
            why = f"the robot does not understand the offer of {name}: {failure}"
        else:
            why = self._refusal(link, offer)
            if not why:
                link.join(session, offer)
                log.info("%s has joined, on %s", name, offer.host)
        if why:
            log.warning("%s is refused: %s", name, why)
        query.reply(query.key_expr, wire.encode(Admission(why, self._clock.now())))
        query.drop()  # type: ignore[no-untyped-call]

    def _refusal(self, link: NodeLink, offer: Offer) -> str:
        if offer.node != link.name:
            return f"{offer.node!r} asks to join as {link.name}"
        joined = link.offer
        if joined is not None and joined.process != offer.process and link.usable:
            return f"a node named {link.name} has joined already, on {joined.host}"
        return refusal(self._offers[link.name], self._version, offer)

    def _token(self, change: tuple[str, bool]) -> None:
        key, alive = change
        name, instance = key.split("/")[-3:-1]
        link = self._links.get(name)
        if not alive and link is not None and link.offer is not None and link.offer.instance == instance:
            link.leave(f"{name} is lost")
            log.warning("%s is lost", name)

    async def _beat(self) -> None:
        while True:
            for link in self._links.values():
                link.beat()
            await self._clock.sleep(BEAT_S)


def stand_in_name(module: str, node: str) -> str:
    """The name at home of what represents ``module`` on ``node``."""
    return f"{module}@{node}"


def absolute(tls: TlsFiles, folder: Path) -> TlsFiles:
    """The same files, relative paths being relative to ``folder``."""
    fields: dict[str, Any] = {name: folder / path for name, path in tls.model_dump().items()}
    return TlsFiles(**fields)
