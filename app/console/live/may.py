"""What a page may say on the live stream, by its role."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

from app.console.access.roles import MESSAGES, in_words
from app.console.live.viewer import Viewer

#: Messages that come again and again while something is held: refused with one notice for each hold.
HELD = frozenset({"drive", "voice"})

Notify = Callable[[str, Literal["info", "warning", "error"], str], None]


def permits(viewer: Viewer, kind: str, notify: Notify, *, lasting: bool = True) -> bool:
    """Whether ``viewer`` may send a message of ``kind``; else it gets a notice.

    ``lasting``: of :data:`HELD`, whether the message holds something; one that does not ends the hold.
    """
    needed, role = MESSAGES[kind], viewer.identity.role
    if role is not None and role.covers(needed):
        return True
    if kind in HELD and not lasting:
        viewer.refused.discard(kind)
    elif kind not in viewer.refused:
        if kind in HELD:
            viewer.refused.add(kind)
        you = "a visitor" if role is None else in_words(role)
        what = kind.replace("_", " ")
        notify(viewer.session, "warning", f"You are logged in as {you}: {what} needs the role {needed}.")
    return False
