"""From desires to the joints of the simulated robot's face, through attention, arbiter and guard."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.attention.desires import Source
from app.base import paths
from app.experiments.world_run import WorldRun, run_in_world, with_settings
from app.messages import JointState
from app.modules.behaviors.face.expression import CALM, JOINTS, VARIANTS
from app.program.config import load_configuration
from app.robots.config import RobotConfig
from app.robots.factory import load_body
from app.speech.config import EspeakConfig
from app.speech.text_only import TextOnly

MODULES = ("WheelOdometry", "Loudspeaker", "Say", "Face", "FaceControl", "Emotions")
#: A text without sound saddens it: not a short one, but a long one.
FEELINGS = {"shows": True, "effects": {"Say": {"neglected": {"sadness": 0.1}}}}
CORNER, LIDS, LOWER = (JOINTS.index(f"{name}_joint") for name in ("left_mouth_corner", "eyelids", "lower_lip"))


@pytest.mark.slow
def test_the_face_blinks_expresses_and_speaks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(EspeakConfig, "make", lambda _: TextOnly())
    configuration = load_configuration(paths.config_dir() / "lab.yaml")
    modules = {name: spec for name, spec in configuration.program.modules.items() if name in MODULES}
    configuration = replace(configuration, program=configuration.program.model_copy(update={"modules": modules}))
    configuration = with_settings(configuration, {"Emotions": FEELINGS})
    body = load_body(configuration.path(configuration.program.robot))
    assert isinstance(body, RobotConfig)

    async def script(run: WorldRun) -> tuple[dict[str, np.ndarray], list[str]]:
        moved: list[JointState] = []
        run.link.attach("joints", moved.append)
        shown: dict[str, np.ndarray] = {}

        async def watch(name: str, seconds: float) -> None:
            moved.clear()
            await run.system.clock.sleep(seconds)
            states = [dict(zip(state.names, state.positions, strict=True)) for state in moved]
            shown[name] = np.array([[state[joint] for joint in JOINTS] for state in states])

        def desire(cls: str, **params: object) -> str:
            source = Source("rest", "a test")
            return run.system.workspace.add(cls, intensity=8, utility=1, params=params, source=source).id

        await watch("calm", 15.0)
        sad = desire("Express", expression="sad")
        await watch("sad", 3.0)
        assert run.system.exploited() == (sad,)
        run.system.workspace.remove(sad)
        await watch("calm again", 3.0)
        assert run.system.exploited() == ()
        desire("Say", text="Aha, a banana.")
        await watch("speaking", 2.0)
        await watch("silent", 4.0)
        desire("Say", text="It is a long sentence, and " * 5 + "no more.")
        await run.system.clock.sleep(10.0)
        await watch("saddened", 2.0)
        (wish,) = [each for each in run.system.workspace.desires() if each.cls == "Express"]
        assert (wish.source.name, wish.params["expression"]) == ("Emotions", "sad")
        assert run.system.exploited() == (wish.id,)
        asked = desire("Express", expression="calm")
        await watch("asked to be calm", 2.0)
        assert run.system.exploited() == (asked,)
        moved.clear()
        while not moved or dict(zip(moved[-1].names, moved[-1].positions, strict=True))[JOINTS[LIDS]] < 0.9:
            await run.system.clock.sleep(1 / 30)
        run.link.e_stop("a test")
        await watch("stopped", 1.0)
        return shown, [event.text for event in run.system.timeline.query(kinds=["exploitation"])]

    shown, events = run_in_world(configuration, body.model_copy(update={"scenario": None}), script)
    moved = ["Face moves the face", "Face moves the face no more", "Face moves the face"]
    assert [text for text in events if "face" in text] == moved, "speech and calm exploit no expression"
    assert shown["calm"][:, LIDS].max() > 1.0, "a blink, seen by joints at 30 Hz"
    calm = np.median(shown["calm"], axis=0)
    np.testing.assert_allclose(calm, CALM, atol=1e-6)
    assert min(np.abs(shown["sad"][-1][CORNER] - variant[CORNER]) for variant in VARIANTS["sad"]) < 0.2
    np.testing.assert_allclose(np.median(shown["calm again"][-30:], axis=0), calm, atol=1e-6)
    assert shown["speaking"][:, LOWER].max() > 0.25, "an a is said"
    assert np.ptp(shown["speaking"][:, LOWER]) > 0.2
    assert shown["silent"][-1][LOWER] == pytest.approx(CALM[LOWER])
    assert shown["saddened"][:, CORNER].max() < CALM[CORNER] - 0.15
    assert shown["asked to be calm"][-1][CORNER] == pytest.approx(CALM[CORNER])
    np.testing.assert_allclose(shown["stopped"][-1], CALM, atol=1e-6, err_msg="an emergency stop in mid-blink")
    for name, poses in shown.items():
        for joint, positions in zip(JOINTS, poses.T, strict=True):
            limits = next(each for each in body.groups["face"].joints if each.name == joint)
            assert limits.lower <= positions.min() <= positions.max() <= limits.upper, (name, joint)
            assert np.abs(np.diff(positions)).max() <= limits.velocity / 30 * 1.01, (name, joint)
