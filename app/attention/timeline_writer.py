"""Attention's events on the timeline: desires, intentions and filters, each with data for machines and a sentence."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec

from app.attention.desires import Desire, Source
from app.attention.intention import Intention
from app.attention.strategies import CLOSED
from app.attention.timeline import Timeline
from app.attention.workspace import WorkspaceChange
from app.messages import Accomplishment

#: Kinds of sources with another word in sentences.
_KINDS = {"rest": "REST client"}


def note_desires(timeline: Timeline, change: WorkspaceChange) -> bool:
    """Note what a transaction did. Returns whether it can matter: a longer life alone cannot, and is not noted."""
    for desire in change.added:
        _note_desire(timeline, "added", desire, f"{source_words(desire.source)} desires {_wish(desire)}")
    moved = bool(change.added or change.removed)
    for before, after in change.changed:
        if msgspec.structs.replace(before, expires=after.expires) == after:
            continue
        moved = True
        if msgspec.structs.replace(before, expires=after.expires, modulation=after.modulation) == after:
            _note_modulation(timeline, before, after)
        else:
            _note_desire(timeline, "changed", after, f"desire for {_wish(after)} changed")
    for desire, report in change.accomplished:
        _note_accomplishment(timeline, desire, report)
    for removal in change.removed:
        desire = removal.desire
        _note_desire(timeline, removal.reason, desire, f"desire for {_wish(desire)} {removal.reason}")
    return moved


def note_intention(timeline: Timeline, before: Intention | None, after: Intention) -> None:
    """Note a switch of strategies; nothing if the same ones stay selected."""
    if before is not None and before.selection.strategies == after.selection.strategies:
        return
    old = set(before.selection.strategies) if before is not None else set()
    new = set(after.selection.strategies)
    on, off = sorted(new - old), sorted(old - new)
    parts = [f"+ {', '.join(on)}"] if on else []
    parts += [f"- {', '.join(off)}"] if off else []
    selection = after.selection
    data = {
        "on": on,
        "off": off,
        "strategies": list(selection.strategies),
        "fulfilled": list(selection.fulfilled),
        "omega": selection.omega,
        "use": dict(selection.use),
        "proven": selection.proven,
        "relaxed": list(selection.relaxed),
        "solve_ms": round(selection.solve_time_s * 1000, 3),
    }
    text = "; ".join(parts) or "nothing is selected"
    if selection.relaxed:
        text += f"; security cannot be kept for {', '.join(selection.relaxed)}"
    timeline.add("intention", "intention", f"{text} (Ω {selection.omega:g})", data)


def note_filters(timeline: Timeline, before: Mapping[str, float], after: Mapping[str, float]) -> None:
    """Note each filter of ``after`` whose φ changed; one not in ``before`` was closed."""
    for name, phi in after.items():
        was = before.get(name, CLOSED)
        if was != phi:
            data = {"before": divisor_json(was), "after": divisor_json(phi)}
            timeline.add("filter", name, f"{name}: φ {_words(was)} → {_words(phi)}", data)


def divisor_json(divisor: float) -> int | None:
    """φ as JSON has it: a whole number, or null for closed."""
    return None if divisor == CLOSED else int(divisor)


def source_words(source: Source) -> str:
    """The author of a desire as sentences name it: kind and name, once where they are equal."""
    kind = _KINDS.get(source.kind, source.kind)
    author = kind if source.name in ("", source.kind) else f"{kind} {source.name}"
    return f"{author} by rule {source.rule!r} ({source.event})" if source.rule else author


def _wish(desire: Desire) -> str:
    """The class of a desire, with what people call that which it is about, where its parameters have such a name."""
    name = desire.params.get("name")
    return f"{desire.cls} {name!r}" if isinstance(name, str) and name else desire.cls


def _note_accomplishment(timeline: Timeline, desire: Desire, report: Accomplishment) -> None:
    words = "is done" if report.outcome == "done" else "failed"
    text = f"{_wish(desire)} of {source_words(desire.source)} {words}, as {report.behavior} reports"
    data = {
        "id": desire.id,
        "class": desire.cls,
        "behavior": report.behavior,
        "outcome": report.outcome,
        "reason": report.reason,
    }
    timeline.add("accomplishment", desire.cls, f"{text}: {report.reason}" if report.reason else text, data)


def _note_modulation(timeline: Timeline, before: Desire, after: Desire) -> None:
    """Note that a desire begins to be raised, and that it is so no more; not each step between."""
    if before.modulation is not None and after.modulation is not None:
        return
    modulation = after.modulation or before.modulation
    assert modulation is not None
    data = {"id": after.id, "class": after.cls, "emotion": modulation.emotion, "raised": after.modulation is not None}
    text = f"{_wish(after)} is ignored: {modulation.emotion} raises its intensity"
    if after.modulation is None:
        text = f"{_wish(after)} is raised no more by {modulation.emotion}"
    timeline.add("emotion", after.cls, text, data)


def _note_desire(timeline: Timeline, what: str, desire: Desire, text: str) -> None:
    security = ", security" if desire.security else ""
    inhibits = ", inhibits the class" if desire.utility == 0 else ""
    data = {
        "change": what,
        "id": desire.id,
        "class": desire.cls,
        "intensity": desire.intensity,
        "utility": desire.utility,
        "security": desire.security,
        "source": msgspec.to_builtins(desire.source),
    }
    text += f" (intensity {desire.intensity:g}, utility {desire.utility:g}{security}{inhibits})"
    timeline.add("desire", desire.cls, text, data)


def _words(divisor: float) -> str:
    return "∞" if divisor == CLOSED else f"{divisor:g}"
