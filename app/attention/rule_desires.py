"""The desires of rules in the Intention Workspace, each with the rule, the event and the time it came from."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from typing import Any, Final

from app.attention.desires import Desire, InvalidDesire, Source
from app.attention.rule_engine import Act, Cause, Edit, Key, Post, Withdraw
from app.attention.rule_model import Action
from app.attention.workspace import KEEP, IntentionWorkspace, UnknownDesire

INTENSITY: Final = 8.0
"""Intensity of a desire whose rule says none."""
UTILITY: Final = 1.0
"""Desired utility of a desire whose rule says none."""
MOST: Final = 20
"""Most desires of one action with ``again: add`` at a time."""


class RuleDesires:
    """Applies what the rule engine decides. ``author`` is the motivation that goes by the rules."""

    def __init__(self, workspace: IntentionWorkspace, author: Source) -> None:
        self._workspace = workspace
        self._author = author
        self._ids: dict[Key, list[str]] = {}

    def apply(self, acts: Iterable[Act]) -> list[tuple[str, str]]:
        """Do all of ``acts`` in one transaction; returns the rules of those that were refused, and why."""
        refused = []
        with self._workspace.transaction():
            for act in acts:
                try:
                    self._apply(act)
                except InvalidDesire as failure:
                    rule = act.cause.rule
                    refused.append((rule, f"{act.action.cls}: {failure}" if not isinstance(act, Withdraw) else ""))
        return refused

    def clear(self) -> None:
        """Withdraw all that rules desire."""
        with self._workspace.transaction():
            for key in list(self._ids):
                self._withdraw(key)

    def by_rule(self) -> dict[str, tuple[str, ...]]:
        """Ids of the desires that are there, by rule."""
        found: dict[str, tuple[str, ...]] = {}
        for key in list(self._ids):
            found[key.rule] = (*found.get(key.rule, ()), *(desire.id for desire in self._there(key)))
        return {rule: ids for rule, ids in found.items() if ids}

    def _apply(self, act: Act) -> None:
        match act:
            case Post():
                if act.action.cls in self._workspace.classes:
                    self._post(act)
            case Withdraw():
                self._withdraw(act.key)
            case Edit():
                for desire in self._of(act.action):
                    if act.action.withdraw is not None:
                        self._workspace.remove(desire.id)
                    else:
                        self._change(desire, act.action, act.params)

    def _post(self, act: Post) -> None:
        action, there = act.action, self._there(act.key)
        if there and action.again == "keep":
            return
        if there and action.again == "renew":
            self._change(there[-1], action, act.params if action.params is not None else None)
            return
        if len(there) >= MOST:
            raise InvalidDesire(action.cls, f"{MOST} desires of this rule are there already")
        desire = self._workspace.add(
            action.cls,
            intensity=INTENSITY if action.intensity is None else action.intensity,
            utility=UTILITY if action.utility is None else action.utility,
            security=bool(action.security),
            params=act.params,
            ttl=action.ttl_s,
            source=self._source(act.cause),
        )
        self._ids[act.key] = [*(each.id for each in there), desire.id]

    def _change(self, desire: Desire, action: Action, params: Any) -> None:
        self._workspace.change(
            desire.id,
            intensity=KEEP if action.intensity is None else action.intensity,
            utility=KEEP if action.utility is None else action.utility,
            security=KEEP if action.security is None else action.security,
            params=KEEP if params is None else params,
            ttl=KEEP if action.ttl_s is None else action.ttl_s,
        )

    def _withdraw(self, key: Key) -> None:
        for desire_id in self._ids.pop(key, ()):
            # It may have expired, been accomplished or withdrawn.
            with suppress(UnknownDesire):
                self._workspace.remove(desire_id)

    def _there(self, key: Key) -> list[Desire]:
        found = []
        for desire_id in self._ids.get(key, ()):
            with suppress(UnknownDesire):
                found.append(self._workspace.get(desire_id))
        if key in self._ids:
            self._ids[key] = [desire.id for desire in found]
        return found

    def _of(self, action: Action) -> list[Desire]:
        """The desires that ``action`` changes or withdraws."""
        keys = [key for key in self._ids if action.rule in (None, key.rule)]
        return [desire for key in keys for desire in self._there(key) if desire.cls == action.cls]

    def _source(self, cause: Cause) -> Source:
        return replace(self._author, rule=cause.rule, event=cause.event, applied=cause.stamp)
