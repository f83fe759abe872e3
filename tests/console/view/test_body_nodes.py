"""The robot's body in the view: where its joints put its parts."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import viser

from app.base import paths
from app.base.geometry import Pose3
from app.base.kinematic_model import load_model
from app.console.view.body_nodes import LEAST_MOVE, BodyNodes

MODEL = load_model(paths.config_dir() / "robots" / "irl1_tr.urdf")


@dataclass
class Frame:
    """As viser's handle: what was set."""

    sets: list[tuple[str, object]] = field(default_factory=list)

    def __setattr__(self, name: str, value: object) -> None:
        if name != "sets":
            self.sets.append((name, value))
        object.__setattr__(self, name, value)


def drawn() -> tuple[BodyNodes, dict[str, Frame]]:
    frames = {name: Frame() for name in MODEL.joints}
    handles: dict[str, viser.FrameHandle] = frames  # type: ignore[assignment]
    return BodyNodes(MODEL, handles), frames


def test_every_joint_is_placed_at_first_and_those_that_move_again() -> None:
    nodes, frames = drawn()
    assert all([name for name, _ in frame.sets] == ["wxyz", "position"] for frame in frames.values())
    moving = MODEL.joint_names[0]
    nodes.move({moving: 0.5, "no such joint": 1.0})
    expected: Pose3 = MODEL.joints[moving].pose(0.5)
    np.testing.assert_allclose(np.asarray(dict(frames[moving].sets)["wxyz"]), expected.quaternion_wxyz())
    np.testing.assert_allclose(np.asarray(dict(frames[moving].sets)["position"]), expected.translation)
    assert [len(frame.sets) for name, frame in frames.items() if name != moving] == [2] * (len(frames) - 1)


def test_what_hardly_moves_is_not_sent() -> None:
    nodes, frames = drawn()
    moving = MODEL.joint_names[0]
    nodes.move({moving: 0.5 * LEAST_MOVE})
    assert len(frames[moving].sets) == 2
    nodes.move({moving: 1.5 * LEAST_MOVE})
    assert len(frames[moving].sets) == 4


def test_a_joint_that_follows_another_moves_with_it() -> None:
    nodes, frames = drawn()
    before = np.array(frames["left_gripper_second_joint"].position)  # type: ignore[attr-defined]
    assert nodes.move({"left_gripper_joint": 0.03})
    after = np.array(frames["left_gripper_second_joint"].position)  # type: ignore[attr-defined]
    assert np.allclose(after - before, [0, -0.03, 0])


def test_a_joint_that_mimics_another_moves_with_it() -> None:
    nodes, frames = drawn()
    nodes.move({"eyes_pan_joint": 0.4})
    for name in ("eyes_pan_joint", "right_eye_pan_joint"):
        expected = MODEL.joints[name].pose(0.4).quaternion_wxyz()
        np.testing.assert_allclose(np.asarray(dict(frames[name].sets)["wxyz"]), expected)
