"""Face by itself: the calm face, expressions, detections, gaze and speech."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.base.geometry import Pose3
from app.link import ActuatorGroup, SafeAction
from app.messages import (
    Audio,
    Exploitation,
    Face,
    Faces,
    JointCommand,
    JointState,
    LoudNoise,
    PerceptEvent,
    QRCode,
    QRCodes,
    Speech,
    Twist,
    read_only,
)
from app.modules.behaviors.face.expression import CALM, JOINTS, VARIANTS
from app.robots.config import load_robot_config
from app.runtime.clock import in_virtual_time
from tests.modules.fakes import Bench, FakeLink, drain

ROBOT = load_robot_config(Path(__file__).parents[4] / "config" / "robots" / "irl1_tr.yaml")
BROW, PAN, TILT, LIDS, CORNER, LOWER = (
    JOINTS.index(f"{name}_joint")
    for name in ("left_eyebrow", "eyes_pan", "eyes_tilt", "eyelids", "left_mouth_corner", "lower_lip")
)
INPUTS: dict[str, type[Any]] = {
    "joints": JointState,
    "gaze": JointCommand,
    "speech": Speech,
    "voice": Audio,
    "heard": Exploitation,
    "faces": Faces,
    "codes": QRCodes,
    "noises": LoudNoise,
    "events": PerceptEvent,
}


def bench(body: ActuatorGroup = ROBOT.groups["face"], without: str = "", **settings: Any) -> Bench:
    link = FakeLink()
    link.description = replace(link.description, model_path=ROBOT.model, groups={"face": body})
    return Bench(
        "app.modules.behaviors.face.face:Face",
        inputs={name: kind for name, kind in INPUTS.items() if name != without},
        outputs={"command": JointCommand, "calm": JointCommand},
        settings=settings,
        link=link,
        attended=("command",),
    )


async def given(b: Bench, seconds: float, output: str = "calm") -> np.ndarray:
    """The poses (n, 9) that it commands on ``output`` within ``seconds``."""
    listening = b.listen(output)
    await b.clock.sleep(seconds)
    b.graph.channel(output).unsubscribe(listening)
    commands: list[JointCommand] = drain(listening)
    assert all((command.group, command.names) == ("face", JOINTS) for command in commands)
    return np.array([command.positions for command in commands]).reshape(-1, len(JOINTS))


def express(b: Bench, **params: Any) -> None:
    b.graph.filters.apply({"Tested.command": 1})
    b.graph.configure("Tested", {"strength": 1.0, **params})


def faces(b: Bench, *tracks: int, p_BF: tuple[float, float, float] = (1.0, 0.0, 1.2)) -> Faces:
    nothing = np.zeros((5, 2), np.float32)
    seen = tuple(Face(track, 0.9, (0, 0, 9, 9), nothing, p_BF, np.eye(3), 1.0, 0.1) for track in tracks)
    return Faces(b.clock.now(), "kinect_optical_frame", 640, 480, Pose3.identity(), seen)


def event(b: Bench, kind: str, what: str = "appears") -> PerceptEvent:
    now = b.clock.now()
    return PerceptEvent(now, f"{kind}.{what}", kind, "", "", now, 1.0, None, None)


def speech(b: Bench, viseme: str, state: Any = "speaking") -> Speech:
    return Speech(b.clock.now(), state, "Ah.", 0, 2, viseme=viseme, language="en", desire="d", waiting=0)


@in_virtual_time
async def test_without_a_desire_it_is_calm_blinks_and_commands_ten_times_a_second() -> None:
    async with bench() as b:
        poses = await given(b, 30.0)
        assert len(await given(b, 2.0, "command")) == 0
        still = np.abs(poses[:, [i for i in range(9) if i != LIDS]] - np.delete(CALM, LIDS))
        assert still.max() < 1e-9
        shut = poses[:, LIDS] > 0.9
        assert 5 <= (shut[1:] & ~shut[:-1]).sum() <= 15
        assert 300 <= len(poses) < 500, "more often only while it blinks"


@in_virtual_time
async def test_a_desired_expression_is_shown_while_it_is_desired() -> None:
    async with bench() as b:
        express(b, expression="happy")
        happy = await given(b, 2.0, "command")
        second = VARIANTS["happy"]
        assert min(np.delete(np.abs(happy[-1] - variant), LIDS).max() for variant in second) < 0.35
        assert happy[-1][CORNER] > 0.5
        assert len(await given(b, 1.0)) == 0, "nothing else is commanded meanwhile"
        b.graph.filters.apply({"Tested.command": math.inf})
        b.graph.configure("Tested", {})
        calm = await given(b, 2.0)
        assert calm[0][CORNER] > 0.4, "it goes smoothly"
        assert calm[-1][CORNER] == pytest.approx(CALM[CORNER])


@in_virtual_time
async def test_weights_blend_and_strength_weakens() -> None:
    async with bench() as b:
        express(b, sad=1.0, happy=1.0)
        blend = (await given(b, 2.0, "command"))[-1]
        sad, happy = (sorted(variant[CORNER] for variant in VARIANTS[name]) for name in ("sad", "happy"))
        assert (sad[0] + happy[0]) / 2 <= blend[CORNER] <= (sad[1] + happy[1]) / 2
        express(b, expression="happy", strength=0.1)
        weak = (await given(b, 2.0, "command"))[-1]
        assert weak[CORNER] == pytest.approx(0.9 * CALM[CORNER] + 0.1 * happy[0], abs=0.02)


@pytest.mark.parametrize(
    "detected",
    [
        lambda b: b.feed("noises", LoudNoise(b.clock.now(), 9.0, -20.0)),
        lambda b: b.feed("faces", faces(b, 1)),
        lambda b: b.feed(
            "codes", QRCodes(0.0, "k", 9, 9, Pose3.identity(), (QRCode("a", np.zeros((4, 2), np.float32), None),))
        ),
        lambda b: b.feed("events", event(b, "dark")),
    ],
    ids=["noise", "face", "code", "darkness"],
)
@in_virtual_time
async def test_every_detection_raises_the_brows_at_once_and_shortly(detected: Any) -> None:
    async with bench() as b:
        await b.clock.sleep(1.0)
        detected(b)
        brows = (await given(b, 0.3))[:, BROW]
        assert brows[1] > CALM[BROW] + 0.1, "within a fifteenth of a second"
        assert (await given(b, 1.0))[-1, BROW] == pytest.approx(CALM[BROW])
    async with bench(reaction=False) as b:
        await b.clock.sleep(1.0)
        detected(b)
        assert (await given(b, 0.5))[:, BROW] == pytest.approx(CALM[BROW]), "it is switched off"


@in_virtual_time
async def test_what_is_seen_again_or_leaves_is_no_detection() -> None:
    async with bench(look_at_faces=False) as b:
        b.feed("faces", faces(b, 1, 2))
        await b.clock.sleep(1.5)
        b.feed("faces", faces(b, 2))
        b.feed("events", event(b, "dark", "leaves"))
        b.feed("events", event(b, "code"))
        assert (await given(b, 0.5))[:, BROW] == pytest.approx(CALM[BROW])
        b.feed("faces", faces(b, 3))
        assert (await given(b, 0.5))[:, BROW].max() > CALM[BROW] + 0.1


@in_virtual_time
async def test_the_eyes_are_where_the_head_is_still_turning_to() -> None:
    async with bench() as b:
        names = ("pan_joint", "tilt_joint")
        b.feed("joints", JointState(b.clock.now(), names, (0.2, 0.0)))
        b.feed("gaze", JointCommand(b.clock.now(), "head", names, (0.5, 0.1)))
        ahead = (await given(b, 0.3))[-1]
        assert ahead[[PAN, TILT]] == pytest.approx([0.3, 0.1], abs=0.01)
        b.feed("joints", JointState(b.clock.now(), names, (0.5, 0.1)))
        b.feed("gaze", JointCommand(b.clock.now(), "head", names, (0.5, 0.1)))
        assert (await given(b, 0.3))[-1][[PAN, TILT]] == pytest.approx([0.0, 0.0], abs=1e-6), "the head is there"
        b.feed("gaze", JointCommand(b.clock.now(), "head", names, (2.0, 0.1)))
        assert (await given(b, 0.3))[-1][PAN] == 0.6, "as far as they turn"
        assert (await given(b, 1.0))[-1][PAN] == 0.0, "nothing is looked at any more"


@in_virtual_time
async def test_the_eyes_look_at_the_nearest_face_unless_something_else_is_looked_at() -> None:
    async with bench(reaction=False) as b:
        height = 1.225  # of the eyes
        b.feed("faces", faces(b, 1, p_BF=(1.052, 0.3, height)))
        assert (await given(b, 0.3))[-1][[PAN, TILT]] == pytest.approx([math.atan2(0.3, 1.0), 0.0], abs=0.01)
        b.feed("gaze", JointCommand(b.clock.now(), "head", ("pan_joint",), (-0.2,)))
        assert (await given(b, 0.3))[-1][PAN] == pytest.approx(-0.2)
    async with bench(look_at_faces=False) as b:
        b.feed("faces", faces(b, 1, p_BF=(1.052, 0.3, height)))
        assert (await given(b, 0.3))[-1][PAN] == 0.0


@in_virtual_time
async def test_the_mouth_moves_with_speech_and_closes_after_it() -> None:
    async with bench() as b:
        opened = []
        for viseme in ("closed", "open", "pursed"):
            b.feed("speech", speech(b, viseme))
            opened.append((await given(b, 0.12))[-1][LOWER])
        assert opened[0] < opened[2] < opened[1]
        b.feed("speech", speech(b, "closed", "silent"))
        assert (await given(b, 0.5))[-1][LOWER] == pytest.approx(CALM[LOWER])
        b.feed("speech", speech(b, "open"))
        assert (await given(b, 3.0))[-1][LOWER] == pytest.approx(CALM[LOWER]), "who spoke has failed"


async def talked(b: Bench, seconds: float, level: int) -> np.ndarray:
    """The poses (n, 9) while an operator talks through the robot at ``level`` of full scale 32768."""
    listening = b.listen("calm")
    tone = read_only(np.full((960, 1), level, np.int16))
    for number in range(round(seconds / 0.02)):
        now = b.clock.now()
        b.feed("voice", Audio(now, "operator", tone, 48_000, 960 * number, read_only(np.zeros((0, 3)))))
        await b.clock.sleep(0.02)
    b.graph.channel("calm").unsubscribe(listening)
    return np.array([command.positions for command in drain(listening)]).reshape(-1, len(JOINTS))


def heard(b: Bench, behavior: str | None) -> None:
    now = b.clock.now()
    b.feed("heard", Exploitation(now, behavior, Twist(now, 0.0, 0.0), group="voice"))


@in_virtual_time
async def test_the_mouth_moves_with_the_voice_of_an_operator_while_that_is_played() -> None:
    async with bench() as b:
        assert (await talked(b, 0.3, 8000))[-1][LOWER] == pytest.approx(CALM[LOWER]), "it is not played"
        heard(b, "Operator")
        b.feed("speech", speech(b, "pursed"))
        loud, lower, pause = [(await talked(b, 0.3, level))[-1][LOWER] for level in (8000, 2500, 8)]
        assert loud > lower > pause
        assert (await given(b, 2.0))[-1][LOWER] == pytest.approx(CALM[LOWER])
        heard(b, None)
        b.feed("speech", speech(b, "open"))
        assert (await given(b, 0.3))[-1][LOWER] > CALM[LOWER] + 0.1, "its own voice"
    async with bench(without="heard") as b:
        assert (await talked(b, 0.3, 8000))[-1][LOWER] > CALM[LOWER] + 0.1


@pytest.mark.parametrize("file", ["irl1_tr.yaml", "irl1_holonomic.yaml"])
def test_a_body_whose_program_is_silent_or_stopped_has_the_calm_face(file: str) -> None:
    face = load_robot_config(Path(__file__).parents[4] / "config" / "robots" / file).groups["face"]
    assert (face.stale, face.stop) == (SafeAction.REST, SafeAction.REST)
    assert dict(zip((joint.name for joint in face.joints), face.rest, strict=True)) == dict(
        zip(JOINTS, CALM.tolist(), strict=True)
    )


@in_virtual_time
async def test_a_body_without_such_a_face_is_refused() -> None:
    head = replace(ROBOT.groups["head"], name="face")
    async with bench(head) as b:
        assert "needs the joint 'left_eyebrow_joint' in the group 'face' of a test body, which has pan" in b.problem
    async with bench(group="mask") as b:
        assert "the group 'mask', which a test body does not have" in b.problem
