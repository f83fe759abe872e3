"""Commands to actuator groups other than the base, the state of every group at the guard, and forces on the body."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class JointCommand:
    """Set-points for joints of one actuator group: ``positions[i]`` (rad, or m where prismatic) of joint ``names[i]``.

    Joints of the group that are not named keep their set-points. ``stiffness`` (N m/rad) and ``damping`` (N m s/rad)
    are of a compliant group's impedance, one per named joint; empty: the group's own. ``stamp``: robot's clock (s).
    """

    stamp: float
    group: str
    names: tuple[str, ...]
    positions: tuple[float, ...]
    stiffness: tuple[float, ...] = ()
    damping: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class GroupStatus:
    """The guard's state of one actuator group of joints.

    ``guard`` is one of ``idle`` (no fresh command, at rest: set-points held), ``moving`` (a fresh command),
    ``holding`` and ``yielding`` (no fresh command, or emergency stop), ``refused``; ``reason``: the same in words.
    ``command_age_s`` is the age of the newest command, None before the first.
    """

    group: str
    guard: str
    reason: str
    command_age_s: float | None


@dataclass(frozen=True, slots=True)
class ExternalForce:
    """An estimate of the force ``f_B`` (N, in ``base_link``) on the body at the origin of its ``link``, which is at
    ``p_B`` (m, in ``base_link``)."""

    link: str
    p_B: tuple[float, float, float]
    f_B: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class ExternalForces:
    """The forces on the body at ``stamp``, as far as its joints show them; none where it is not touched."""

    stamp: float
    forces: tuple[ExternalForce, ...]
