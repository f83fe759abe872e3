"""Exceptions of channels and modules: one class per meaning."""

from __future__ import annotations


class ChannelClosed(Exception):
    """Nothing more will come: the producer is gone or this end was closed."""


class WouldBlock(Exception):
    """A ``_nowait`` operation has nothing to take."""


class InboxOverflow(Exception):
    """A lossless inbox was full; the message names it and the number of messages lost."""


class ModuleFailed(Exception):
    """A module cannot work as configured; the message gives a remedy."""
