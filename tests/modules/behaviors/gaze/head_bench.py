"""One gaze behavior by itself, on the head of the lab's robot without physics."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from app.attention.workspace import IntentionWorkspace
from app.base.geometry import Pose2
from app.base.kinematic_model import load_model
from app.link import ActuatorGroup, JointLimits
from app.messages import Accomplishment, JointCommand, JointState, Odometry
from tests.modules.fakes import Bench, FakeLink, drain

URDF = Path(__file__).parents[4] / "config" / "robots" / "irl1_tr.urdf"
MODEL = load_model(URDF)
EYE = "kinect_optical_frame"
NAMES = ("pan_joint", "tilt_joint")
HEAD = ActuatorGroup(
    "head", tuple(JointLimits(n, MODEL.joints[n].lower, MODEL.joints[n].upper, 1.0, 5.0) for n in NAMES)
)


def bench_of(
    behavior: str,
    inputs: Mapping[str, type[Any]],
    *,
    outputs: Mapping[str, type[Any]] | None = None,
    workspace: IntentionWorkspace | None = None,
    **settings: Any,
) -> Bench:
    """``behavior``: file and class below ``gaze``; with a ``workspace``, it reports accomplishments."""
    link = FakeLink()
    link.description = replace(link.description, model_path=URDF, groups={"head": HEAD})
    reports = {} if workspace is None else {"accomplishments": Accomplishment}
    return Bench(
        f"app.modules.behaviors.gaze.{behavior}",
        inputs={"joints": JointState, **inputs},
        outputs={"command": JointCommand, **(outputs or {}), **reports},
        settings=settings,
        link=link,
        services={} if workspace is None else {IntentionWorkspace: workspace},
        attended=("command",),
    )


def head_bench(behavior: str, inputs: Mapping[str, type[Any]] | None = None, **settings: Any) -> Bench:
    """Of one that looks by an eye, with odometry."""
    return bench_of(behavior, {"odometry": Odometry, **(inputs or {})}, **{"eye": EYE, **settings})


def desire(b: Bench, **parameters: Any) -> None:
    """Attention lets the behavior look, with the parameters of a desire."""
    b.graph.configure("Tested", parameters)
    b.graph.filters.apply({"Tested.command": 1})


def move_base(b: Bench, X_OB: Pose2) -> None:
    """Odometry comes."""
    b.feed("odometry", Odometry(b.clock.now(), X_OB, 0.0, 0.0))


async def commanded(b: Bench, seconds: float, X_OB: Pose2 | None = None) -> list[JointCommand]:
    """What it commands within ``seconds``, while the joints go at once where they are commanded; with odometry at
    ``X_OB`` before each command."""
    given, commands = b.listen("command"), []
    for _ in range(round(seconds / 0.05)):
        if X_OB is not None:
            move_base(b, X_OB)
        await b.clock.sleep(0.05)
        for command in drain(given):
            commands.append(command)
            b.feed("joints", JointState(b.clock.now(), command.names, command.positions))
    b.graph.channel("command").unsubscribe(given)
    return commands


def off_axis_deg(command: JointCommand, p_BP: tuple[float, float, float] | list[float]) -> float:
    """Angle between the eye's axis and a point in ``base_link``."""
    pose = MODEL.pose(EYE, dict(zip(command.names, command.positions, strict=True)))
    x, y, z = pose.inverse().transform(np.array(p_BP))
    return math.degrees(math.atan2(math.hypot(x, y), z))
