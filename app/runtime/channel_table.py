"""The one table of channels: what each carries, how often, and when it counts as stale.

Staleness, counters, the console's columns, recording and tests all read it (``config/channels.yaml``).
"""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import Any, Literal

from pydantic import BaseModel, Field

from app import messages
from app.base.extensions import load_named


class PageColumn(BaseModel, frozen=True, extra="forbid"):
    """How a channel goes to the console's page; a channel without this column does not."""

    frame_type: str = Field(
        "", alias="as", pattern=r"^\w*$", description="type of the frames; empty: the channel's name"
    )
    every_hz: float | None = Field(None, gt=0, description="at most so many frames a second; none: each message")
    keep: Literal["newest", "all"] = Field("newest", description="what a page that is slow, or comes late, is given")


class ChannelSpec(BaseModel, frozen=True, extra="forbid"):
    """One row of the table; the channel's name is its key in the file."""

    message: str = Field(
        alias="type", description="name of a message class of app.messages, or package.module:Class of another package"
    )
    title: str = Field("", description="what people call it")
    rate_hz: float | None = Field(None, gt=0, description="nominal rate; none for a channel of events")
    frame: str = Field("", description="frame of the message's coordinates")
    decimable: bool = Field(True, description="whether attention may decimate it")
    log: Literal["always", "never"] = Field("always", description="whether it is recorded")
    stale_periods: float = Field(3.0, gt=0, description="stale after this many commanded periods")
    stale_min_s: float = Field(0.3, gt=0, description="... but never before this many seconds")
    latched: bool = Field(False, description="whether the newest message stays true until the next: a state, no event")
    external: bool = Field(False, description="fed from outside the graph (the console), not by a module")
    feedback: bool = Field(False, description="whether a cycle of modules may run through it")
    page: PageColumn | None = Field(None, description="how it goes to the console's page; none: it does not")

    @property
    def message_type(self) -> type[Any]:
        """The message class: a dataclass with a ``stamp``. Raises KeyError, which names it, where there is none."""
        found = load_named(self.message) if ":" in self.message else vars(messages).get(self.message)
        if isinstance(found, type) and is_dataclass(found) and any(f.name == "stamp" for f in fields(found)):
            return found
        raise KeyError(self.message)

    def no_message(self) -> str:
        """The sentence for a type that there is not."""
        return (
            f"there is no message type {self.message!r}; allowed: a class of app.messages, or package.module:Class, a "
            "dataclass with a stamp"
        )

    def stale_after_s(self, divisor: float = 1) -> float | None:
        """Age (s) beyond which a message is stale at divisor ``divisor``; None for events.

        Judged against the *commanded* rate, or every switch of attention would raise a false alarm.
        """
        if self.rate_hz is None:
            return None
        return max(self.stale_periods * divisor / self.rate_hz, self.stale_min_s)


class ChannelTable(dict[str, ChannelSpec]):
    """The whole table by channel: a service of the program."""
