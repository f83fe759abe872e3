"""The actuator groups of a model, proposed from how its joints follow each other."""

from __future__ import annotations

import itertools
import math
import re

from app.base.kinematic_model import KinematicModel


def wheels(model: KinematicModel) -> frozenset[str]:
    """The joints that are wheels or casters of a base: they turn without end, as do all joints above and below them."""
    movers = {name: (*model.moved_by(joint.parent), name) for name, joint in model.joints.items() if joint.moves}
    endless = {name: model.joints[name].kind == "continuous" for name in movers}
    ended = {each for chain in movers.values() if not all(endless[name] for name in chain) for each in chain}
    return frozenset(movers) - ended


def proposed_groups(model: KinematicModel) -> dict[str, tuple[str, ...]]:
    """Joints by group: a group is a chain of joints without a branch, in order from the base.

    Wheels are in no group; neither are joints that mimic another.
    """
    turning = wheels(model)
    joints = [name for name in model.joint_names if name not in turning]
    above = {name: _joint_above(model, name, joints) for name in joints}
    following: dict[str | None, list[str]] = {}
    for name in joints:
        following.setdefault(above[name], []).append(name)
    groups: dict[str, tuple[str, ...]] = {}
    for name in joints:
        before = above[name]
        if before is not None and len(following[before]) == 1:
            continue  # in the middle of a chain
        chain = [name]
        while len(next_ones := following.get(chain[-1], [])) == 1:
            chain += next_ones
        groups[_name_of(chain, groups)] = tuple(chain)
    return groups


def _joint_above(model: KinematicModel, name: str, joints: list[str]) -> str | None:
    """The nearest of ``joints`` that moves the joint ``name``."""
    movers = [each for each in model.moved_by(model.joints[name].parent) if each in joints]
    return max(movers, key=lambda each: len(model.moved_by(model.joints[each].child)), default=None)


def _name_of(chain: list[str], taken: dict[str, tuple[str, ...]]) -> str:
    """What the names of the joints have in common, else the first one's, as a name that is free."""
    names = [re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_") for name in chain]
    common = _stripped(_common_beginning(names)) if len(names) > 1 else ""
    name = common if len(common) > 1 else _stripped(names[0]) or names[0]
    free, number = name, 2
    while free in taken or free == "base":
        free, number = f"{name}_{number}", number + 1
    return free


def _common_beginning(names: list[str]) -> str:
    alike = itertools.takewhile(lambda letters: len(set(letters)) == 1, zip(*names, strict=False))
    return "".join(letters[0] for letters in alike)


def _stripped(name: str) -> str:
    """``name`` without what only numbers a joint or calls it one."""
    return re.sub(r"(_?(joint|j|\d+)_?)*$", "", name).strip("_")


def speed_of(model: KinematicModel, joints: tuple[str, ...]) -> float:
    """The least of the joints' own speed limits (rad/s, m/s), at most 1."""
    limits = [model.joints[name].velocity for name in joints]
    return min(1.0, *(limit for limit in limits if math.isfinite(limit) and limit > 0), 1.0)
