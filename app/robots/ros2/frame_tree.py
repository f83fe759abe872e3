"""The tree of a robot's frames, drawn; and held against its model: pure functions."""

from __future__ import annotations

import math
from collections.abc import Iterable

from app.base.kinematic_model import KinematicModel
from app.logs.importers.transforms import Transforms

#: Farther apart (m, rad) than this, the model and the robot say two things of a sensor's place.
_APART_M, _TURNED_RAD = 0.03, math.radians(3)


def text(frames: Transforms) -> list[str]:
    """The tree in lines, children indented below their parents; ``~`` before those that move."""
    below: dict[str, list[tuple[str, bool]]] = {}
    for parent, child, static in frames.edges():
        below.setdefault(parent, []).append((child, static))
    children = {child for _, child, _ in frames.edges()}
    lines: list[str] = []
    drawn: set[str] = set()

    def draw(frame: str, depth: int, mark: str) -> None:
        lines.append(f"{'  ' * depth}{mark}{frame}")
        if frame in drawn:
            lines[-1] += " (above)"  # a ring of frames, which tf refuses
            return
        drawn.add(frame)
        for child, static in sorted(below.get(frame, ())):
            draw(child, depth + 1, "" if static else "~ ")

    for root in sorted(set(below) - children):
        draw(root, 0, "")
    for frame in sorted(set(below) - drawn):
        if frame not in drawn:
            draw(frame, 0, "")
    return lines


def dot(frames: Transforms) -> str:
    """The tree for Graphviz; dashed lines lead to frames that move."""
    lines = [
        f"  {_quoted(parent)} -> {_quoted(child)}{'' if static else ' [style=dashed]'};"
        for parent, child, static in sorted(frames.edges())
    ]
    return "\n".join(("digraph frames {", *lines, "}", ""))


def differences(frames: Transforms, model: KinematicModel, links: Iterable[str]) -> list[str]:
    """What the robot's static transforms say otherwise than ``model`` of the ``links``, in sentences.

    Links that a joint moves, and those of which the transforms say nothing, are left out.
    """
    found = []
    base = model.links[0]
    standing = frames.standing()
    for link in links:
        if link not in model.links or model.moved_by(link):
            continue
        theirs = standing.lookup(base, link, 0.0)
        if theirs is None:
            continue
        apart = theirs.inverse() @ model.pose(link)
        off = math.hypot(*apart.translation)
        turned = math.acos(min(max((float(apart.rotation.trace()) - 1.0) / 2.0, -1.0), 1.0))
        if off > _APART_M or turned > _TURNED_RAD:
            found.append(
                f"{link}: the robot's transforms have it {off:.2f} m and {math.degrees(turned):.0f}° from where the "
                "model has it"
            )
    return found


def _quoted(name: str) -> str:
    return '"' + name.replace("\\", "\\\\").replace('"', '\\"') + '"'
