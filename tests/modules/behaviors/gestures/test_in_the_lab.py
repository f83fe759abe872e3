"""Gestures of the simulated robot, by desires, through the whole program and the guard: where its hands truly are."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from app.attention.desires import Source
from app.base import paths
from app.base.geometry import FloatArray
from app.base.kinematic_model import KinematicModel, load_model
from app.experiments.world_run import WorldRun, run_in_world
from app.messages import DesireReport
from app.program.config import Configuration, load_configuration
from app.robots.config import RobotConfig, StartPose
from app.robots.factory import load_body
from tests.modules.behaviors.gestures.ideal_arms import ARMS
from tests.robots.conftest import make_hall

ME = Source("operator", "a test")


def lab() -> tuple[Configuration, RobotConfig, KinematicModel]:
    configuration = load_configuration(paths.config_dir() / "lab.yaml")
    body = load_body(configuration.path(configuration.program.robot))
    assert isinstance(body, RobotConfig)
    body = body.model_copy(update={"scenario": None})
    return configuration, body, load_model(body.model)


class Arms:
    """The true arms of a running body."""

    def __init__(self, run: WorldRun, model: KinematicModel) -> None:
        self.run = run
        self.model = model

    @property
    def joints(self) -> dict[str, float]:
        simulation = self.run.link._simulation
        assert simulation is not None
        physics = simulation.physics
        return dict(zip(physics.joints, physics.joint_positions().tolist(), strict=True))

    def p_BL(self, link: str) -> NDArray[np.float64]:
        return np.asarray(self.model.pose(link, self.joints).translation)

    def beside_deg(self, side: str, p_BP: FloatArray) -> float:
        """Angle at the shoulder between the hand and the point."""
        shoulder = self.p_BL(f"{side}_shoulder_link")
        to_hand, to_point = self.p_BL(f"{side}_hand_link") - shoulder, p_BP - shoulder
        return math.degrees(math.atan2(np.linalg.norm(np.cross(to_hand, to_point)), to_hand @ to_point))

    def desire(self, cls: str, **params: Any) -> str:
        return self.run.system.workspace.add(cls, intensity=6, utility=1, params=params, source=ME).id

    async def ended(self, desire: str) -> DesireReport:
        """The report of ``desire`` once it has left."""
        workspace, clock = self.run.system.workspace, self.run.system.clock
        while (report := workspace.report(desire)).ended is None:
            await clock.sleep(0.05)
        return report

    async def at_rest(self) -> None:
        """Wait until nothing is desired of the arms any more."""
        clock = self.run.system.clock
        await clock.sleep(2.0)
        while any(desire.cls == "Rest" for desire in self.run.system.workspace.desires()):
            await clock.sleep(0.1)


@pytest.mark.slow
def test_it_points_within_five_degrees_and_turns_to_what_is_behind() -> None:
    configuration, body, model = lab()

    async def script(run: WorldRun) -> dict[str, tuple[str, str, float, float]]:
        arms = Arms(run, model)
        found: dict[str, tuple[str, str, float, float]] = {}
        await run.system.clock.sleep(1.0)
        for name, frame, point in (
            ("left", "base_link", [2.0, 1.0, 0.6]),
            ("right", "base_link", [1.5, -2.0, 1.6]),
            ("behind", "odom", [-2.0, 1.0, 1.0]),
        ):
            p_FP = np.array(point)
            X_WF = run.link.true_pose() if frame == "base_link" else run.link.start_pose
            p_WP = X_WF.to_pose3().transform(p_FP)
            params = dict(zip("xyz", point, strict=True))
            report = await arms.ended(arms.desire("PointAt", **params, frame=frame, hold_s=0.5))
            p_BP = run.link.true_pose().to_pose3().inverse().transform(p_WP)
            side = min(("left", "right"), key=lambda side: arms.beside_deg(side, p_BP))
            found[name] = (report.outcome or "", side, arms.beside_deg(side, p_BP), run.link.true_pose().theta)
            await arms.at_rest()
        found["rest"] = (
            "",
            "",
            float(max(abs(arms.joints[f"{s}_shoulder_pitch_joint"]) for s in ("left", "right"))),
            0,
        )
        return found

    found = run_in_world(configuration, body, script, without=("SLAM2D",))
    for name in ("left", "right", "behind"):
        assert found[name][0] == "done", found
        assert found[name][2] <= 5.0, found
    assert (found["left"][1], found["right"][1]) == ("left", "right")
    assert found["left"][3] == pytest.approx(found["right"][3], abs=0.02), "the base does not turn for what is beside"
    assert abs(found["behind"][3] - found["right"][3]) > 0.5
    assert found["rest"][2] < 0.1, "after a gesture the arms rest"


@pytest.mark.slow
def test_a_hand_comes_to_a_point_and_what_cannot_be_reached_fails_with_the_reason() -> None:
    configuration, body, model = lab()

    async def script(run: WorldRun) -> dict[str, Any]:
        arms = Arms(run, model)
        found: dict[str, Any] = {}
        await run.system.clock.sleep(1.0)
        for point in ([0.35, 0.25, 0.9], [0.3, -0.3, 1.1]):
            report = await arms.ended(arms.desire("Reach", **dict(zip("xyz", point, strict=True)), frame="base_link"))
            side = "left" if point[1] > 0 else "right"
            found[f"reached {point}"] = report.outcome, float(np.linalg.norm(arms.p_BL(f"{side}_hand_link") - point))
        for point in ([1.5, 0.0, 0.9], [-0.02, 0.0, 0.7]):
            report = await arms.ended(arms.desire("Reach", **dict(zip("xyz", point, strict=True)), frame="base_link"))
            found[str(point)] = report.outcome, report.reason
        report = await arms.ended(arms.desire("Reach", x=0.3, y=0.3, z=1.0, frame="base_link", stiffness="stiff"))
        found["stiff"] = report.outcome, float(np.linalg.norm(arms.p_BL("left_hand_link") - [0.3, 0.3, 1.0]))
        return found

    found = run_in_world(configuration, body, script, without=("SLAM2D",))
    for name, (outcome, off_m) in found.items():
        if name.startswith(("reached", "stiff")):
            assert outcome == "done", found
            assert off_m < 0.03, found
    outcome, reason = found["[1.5, 0.0, 0.9]"]
    assert (outcome, "the arm reaches 0.5" in reason) == ("failed", True), found
    outcome, reason = found["[-0.02, 0.0, 0.7]"]
    assert outcome == "failed", found


@pytest.mark.slow
def test_it_waves_with_the_hand_above_the_shoulder() -> None:
    configuration, body, model = lab()

    async def script(run: WorldRun) -> tuple[DesireReport, list[NDArray[np.float64]]]:
        arms, hands = Arms(run, model), []
        run.link.attach("joints", lambda _: hands.append(arms.p_BL("right_hand_link")))
        await run.system.clock.sleep(1.0)
        report = await arms.ended(arms.desire("Wave", times=3))
        return report, hands

    report, hands = run_in_world(configuration, body, script, without=("SLAM2D",))
    assert (report.outcome, report.reason) == ("done", "the right arm waved")
    raised = np.array([hand for hand in hands if hand[2] > 1.0])
    middle = (raised[:, 1].min() + raised[:, 1].max()) / 2
    swings = np.flatnonzero(np.diff(np.sign(raised[:, 1] - middle)))
    assert np.ptp(raised[:, 1]) > 0.15
    assert len(swings) >= 5, "three times to and fro"


@pytest.mark.slow
def test_gestures_that_interrupt_each_other_do_not_bring_the_arms_into_the_body() -> None:
    configuration, body, model = lab()
    random = np.random.default_rng(12)
    boxes = {
        "PointAt": ([0.8, -1.0, 0.0], [3.0, 1.0, 2.0]),
        "Reach": ([0.05, -0.3, 0.6], [0.4, 0.3, 1.2]),
    }

    async def script(run: WorldRun) -> tuple[float, dict[str, int]]:
        arms, clearance, outcomes = Arms(run, model), [np.inf], dict.fromkeys(("done", "failed", "withdrawn"), 0)

        def measure(_: object) -> None:
            for arm in ARMS.values():
                (found,) = arm.collision.clearances(arm.positions(arms.joints)[None], arms.joints)
                clearance[0] = min(clearance[0], found.distance_m)

        run.link.attach("joints", measure)
        await run.system.clock.sleep(1.0)
        for number in range(6):
            cls = "PointAt" if number % 3 == 0 else "Reach"
            point = dict(zip("xyz", random.uniform(*boxes[cls]).tolist(), strict=True))
            desire = arms.desire(cls, **point, frame="base_link", hold_s=0.0)
            await run.system.clock.sleep(random.uniform(0.2, 3.5))
            report = run.system.workspace.report(desire)
            if report.ended is None:
                run.system.workspace.remove(desire)
            outcomes[report.outcome or "withdrawn"] += 1
        return clearance[0], outcomes

    clearance_m, outcomes = run_in_world(configuration, body, script, without=("SLAM2D",))
    assert clearance_m > 0.0, outcomes
    assert outcomes["withdrawn"] > 0, outcomes
    assert outcomes["done"] > 0, outcomes


@pytest.mark.slow
def test_a_gripper_closes_on_a_box_lifts_it_and_lets_it_go() -> None:
    configuration, body, model = lab()
    body = body.model_copy(update={"start": StartPose(x=5.0, y=10.0, heading_deg=0.0)})
    pillar = {"kind": "box", "at": (5.42, 10.2), "size": (0.1, 0.12, 0.66)}
    box = {"kind": "box", "at": (5.43, 10.2), "z": 0.661, "size": (0.04, 0.04, 0.12), "mass_kg": 0.2}
    # Up before forward, or the hand hits the pillar.
    folded, before, around, above = (
        ARMS["left"].kinematics.hand(np.array([pitch, 0.0, 0.0, elbow]))
        for pitch, elbow in ((0.0, -2.1), (-0.8, -2.1), (-0.8, -0.77), (-0.8, -1.4))
    )

    async def script(run: WorldRun) -> dict[str, Any]:
        arms, clock = Arms(run, model), run.system.clock
        found: dict[str, Any] = {}

        def lift() -> float:
            simulation = run.link._simulation
            assert simulation is not None
            return float(simulation.physics.data.body("box1").xpos[2]) - 0.66

        async def hold_at(point: NDArray[np.float64]) -> str:
            """The desire that keeps the hand at ``point``, once it is there."""
            place = dict(zip("xyz", (float(value) for value in point), strict=True))
            desire = arms.desire("Reach", **place, frame="base_link", arm="left", hold_s=60.0)
            while np.linalg.norm(arms.p_BL("left_hand_link") - point) > 0.02:
                assert run.system.workspace.report(desire).ended is None, run.system.workspace.report(desire)
                await clock.sleep(0.05)
            return desire

        await clock.sleep(1.0)
        found["empty"] = await arms.ended(arms.desire("Hold", arm="left"))
        found["open"] = await arms.ended(arms.desire("Release", arm="left"))
        desire = ""
        for point in (folded, before, around):
            if desire:
                run.system.workspace.remove(desire)
            desire = await hold_at(point)
        await clock.sleep(1.0)
        found["untouched"] = lift()
        found["held"] = await arms.ended(arms.desire("Hold", arm="left"))
        run.system.workspace.remove(desire)
        desire = await hold_at(above)
        await clock.sleep(3.0)
        found["lifted"] = lift()
        await arms.ended(arms.desire("Release", arm="left"))
        await clock.sleep(1.0)
        found["dropped"] = lift()
        return found

    world = make_hall(objects=[pillar, box])
    found = run_in_world(configuration, body, script, world=world, without=("SLAM2D",))
    assert (found["empty"].outcome, found["empty"].reason) == ("failed", "nothing is between the fingers")
    assert found["open"].outcome == "done"
    assert abs(found["untouched"]) < 0.002
    assert found["held"].outcome == "done", found
    assert found["lifted"] > 0.1, found
    assert found["dropped"] < 0.01, found
