"""One control cycle on values: an obstacle that the camera saw once is in the costmap again when the body comes
back."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.base.geometry import CameraModel, Pose2
from app.messages import Image
from app.modules.behaviors.navigation.controller import MotionState
from app.modules.behaviors.navigation.costmap.footprint import Footprint
from app.modules.behaviors.navigation.costmap.persistent_obstacle_layer import PersistentObstacleLayer
from app.modules.behaviors.navigation.kernel_loading import load_kernels
from app.modules.behaviors.navigation.planning.goal_planning import GlobalPlan
from app.modules.behaviors.navigation.tracking.control_cycle import ControlCycle, ControlCycleSettings, CycleInput
from app.modules.behaviors.navigation.tracking.path_tracker import NavigationGoal
from tests.modules.behaviors.driven_world import DrivenLink, box, mapped
from tests.modules.behaviors.navigation.boxes import CAMERA, Box, World, looking

EYE = looking(0.0, 1.38)
#: Lower than the laser; the wall behind is not.
WORLD = World(((3.0, -0.2, 3.3, 0.2, 0.0, 0.22), (5.0, -3.0, 5.2, 3.0, 0.0, 2.5)))
X_MO = Pose2(2.0, 1.0, 0.3)
EMPTY = mapped(box(-5.0, -5.0, 5.0, 5.0), (-6.0, -6.0, 12.0, 12.0))


@pytest.fixture(scope="module", autouse=True)
def _kernels() -> None:
    """Compiled before, and loaded once: no test's own time."""
    load_kernels()


def inputs(stamp: float, pose: Pose2, *, look: bool, problem: str = "") -> CycleInput:
    scan, image = WORLD.scan(stamp, pose), WORLD.depth(stamp, pose, EYE)
    assert image.depth is not None
    # As fine as a Kinect's, from fewer rays
    depth = np.kron(image.depth, np.ones((4, 4), dtype=np.uint16))
    lens = CameraModel(640, 480, 4 * CAMERA.fx, 4 * CAMERA.fy, 4 * CAMERA.cx + 1.5, 4 * CAMERA.cy + 1.5)
    image = Image(stamp, "kinect", image.color, depth, lens, image.X_BC)
    seen = (image, pose) if look else None
    return CycleInput(stamp, MotionState(pose, 0.0, 0.0), X_MO, problem, None, (scan, pose, pose), seen)


def control() -> ControlCycle:
    return ControlCycle(DrivenLink().description, "pursuit", depth=True)


def box_cells(obstacles: np.ndarray) -> int:
    return int((np.abs(obstacles - np.array([3.1, 0.0])) < 0.3).all(axis=1).sum())


def drive_up(control: ControlCycle, problem: str = "") -> None:
    for k, x in enumerate(np.arange(-1.0, 0.2, 0.1)):
        control.remember(inputs(0.2 * k, Pose2(float(x), 0.0, 0.0), look=True, problem=problem))


def test_a_box_seen_while_others_drove_stands_there_when_the_body_turns_beside_it_minutes_later() -> None:
    here = control()
    drive_up(here)
    output = here.run(inputs(300.0, Pose2(2.2, 0.0, 1.5), look=False), 0.1)
    assert output.around is not None
    assert box_cells(output.around.obstacles) > 20
    corner, cell = output.around.origin, output.around.resolution_m
    assert output.around.distance[int((0.0 - corner[1]) / cell), int((3.05 - corner[0]) / cell)] < 0.06
    on_map = X_MO @ Pose2(3.05, 0.0)
    assert np.hypot(*(output.persistent_obstacles - np.array([on_map.x, on_map.y])).T).min() < 0.1
    far = here.run(inputs(300.1, Pose2(-4.0, 0.0, 3.1), look=False), 0.1)
    assert far.around is not None
    assert box_cells(far.around.obstacles) == 0
    assert len(far.persistent_obstacles) == len(output.persistent_obstacles), "a plan has it from anywhere"


def test_nothing_is_learned_without_knowing_where() -> None:
    here = control()
    drive_up(here, problem="it looks for itself on the map")
    assert not len(here.run(inputs(300.0, Pose2(2.2, 0.0, 1.5), look=False), 0.1).persistent_obstacles)


def shins(gap_m: float) -> tuple[Box, ...]:
    """Two shins before the body's front edge, which is at 0.25 m."""
    x = 0.25 + gap_m
    return ((x, 0.03, x + 0.1, 0.13, 0.0, 1.7), (x, -0.13, x + 0.1, -0.03, 0.0, 1.7))


def clearance_m(pose: Pose2, boxes: tuple[Box, ...]) -> float:
    """How far the hull, 0.5 m square, is from boxes beside it; under zero where it is in one."""
    least = math.inf
    for x0, y0, x1, y1, *_ in boxes:
        x, y = np.meshgrid(np.linspace(x0, x1, 21) - pose.x, np.linspace(y0, y1, 21) - pose.y)
        c, s = math.cos(pose.theta), math.sin(pose.theta)
        least = min(least, float((np.maximum(np.abs(c * x + s * y), np.abs(c * y - s * x)) - 0.25).min()))
    return least


def drive(control: ControlCycle, world: World, to: tuple[float, float], cycles: int) -> list[Pose2]:
    """Where the body goes that follows a straight way exactly as commanded, ``odom`` being the map."""
    goal = NavigationGoal(Pose2(*to, math.nan))
    x, y = (np.linspace(0.0, end, 60) for end in to)
    poses = np.stack((x, y, np.full(60, math.atan2(to[1], to[0]))), axis=1)
    plan: GlobalPlan | None = GlobalPlan("way", "", poses, goal.pose, math.hypot(*to))
    here, linear, angular = [Pose2()], 0.0, 0.0
    for k in range(cycles):
        at, now = here[-1], 0.1 * k
        scan = (world.scan(now, at), at, at)
        output = control.run(
            CycleInput(now, MotionState(at, linear, angular), Pose2(), "", goal, scan, None, plan, None, EMPTY), 0.1
        )
        plan, linear, angular = None, output.step.linear_mps, output.step.angular_radps
        middle = at.theta + 0.05 * angular
        step = 0.1 * linear
        here.append(Pose2(at.x + step * math.cos(middle), at.y + step * math.sin(middle), at.theta + 0.1 * angular))
    return here


@pytest.mark.parametrize(("gap_m", "people_m"), [(0.05, 0.1), (0.08, 0.18)])
def test_room_beside_people_that_the_body_stands_in_does_not_let_it_turn_into_their_legs(
    gap_m: float, people_m: float
) -> None:
    here = ControlCycle(DrivenLink().description, "pursuit", ControlCycleSettings(people_m=people_m), depth=False)
    way = drive(here, World(shins(gap_m)), (0.0, 3.0), 20)
    assert min(clearance_m(pose, shins(gap_m)) for pose in way) > 0.03


def passes(control: ControlCycle, at: tuple[float, float], cycles: int) -> tuple[float, Pose2]:
    """How near (m) the hull comes to the trunk (radius 0.22 m) of one who stands ``at`` the flank, as the body follows
    a way ahead and then around them to the right; and where it is then. The laser sees legs, and nothing beside
    itself."""
    x, y = at
    world = World(tuple((x + s - 0.05, y - 0.05, x + s + 0.05, y + 0.05, 0.0, 1.7) for s in (-0.08, 0.08)))
    ahead, right = np.linspace(0.0, 0.9, 40), np.linspace(0.0, -3.0, 60)[1:]
    poses = np.zeros((99, 3))
    poses[:40, 0], poses[40:] = ahead, np.column_stack((np.full(59, 0.9), right, np.full(59, -math.pi / 2)))
    goal = NavigationGoal(Pose2(0.9, -3.0, math.nan))
    plan: GlobalPlan | None = GlobalPlan("way", "", poses, goal.pose, 3.9)
    here, linear, angular, least = Pose2(), 0.0, 0.0, math.inf
    for k in range(cycles):
        scan = (world.scan(0.1 * k, here, noise_m=0.02), here, here)
        motion = MotionState(here, linear, angular)
        output = control.run(CycleInput(0.1 * k, motion, Pose2(), "", goal, scan, None, plan, None, EMPTY), 0.1)
        plan, linear, angular = None, output.step.linear_mps, output.step.angular_radps
        middle = here.theta + 0.05 * angular
        here = Pose2(
            here.x + 0.1 * linear * math.cos(middle),
            here.y + 0.1 * linear * math.sin(middle),
            here.theta + 0.1 * angular,
        )
        person = here.inverse() @ Pose2(*at)
        least = min(least, math.hypot(max(abs(person.x) - 0.25, 0.0), max(abs(person.y) - 0.25, 0.0)) - 0.22)
    return least, here


@pytest.mark.parametrize(("controller", "at"), [("mppi", (0.25, -0.51)), ("pursuit", (0.3, -0.5))])
def test_one_who_stands_at_the_flank_is_not_touched_when_the_laser_sees_their_legs_no_more(
    controller: str, at: tuple[float, float]
) -> None:
    here = ControlCycle(DrivenLink().description, controller, ControlCycleSettings(people_m=0.18), depth=False)
    least_m, _ = passes(here, at, 450)
    assert least_m > 0.01


def test_one_who_stands_at_the_flank_is_passed() -> None:
    here = ControlCycle(DrivenLink().description, "mppi", ControlCycleSettings(people_m=0.18), depth=False)
    _, end = passes(here, (0.35, -0.55), 200)
    assert end.y < -2.5


@pytest.mark.parametrize("inside_m", [0.01, 0.03])
def test_what_is_remembered_within_the_body_does_not_let_it_turn_into_legs(inside_m: float) -> None:
    here = seeing_no_depth()
    assert here.persistent_obstacles is not None
    here.persistent_obstacles.add_contacts(np.array([[0.25 - inside_m, y] for y in (-0.1, -0.05, 0.0, 0.05, 0.1)]), 0.0)
    way = drive(here, World(shins(0.05)), (0.0, 3.0), 20)
    assert min(clearance_m(pose, shins(0.05)) for pose in way) > 0.03


def test_what_is_remembered_before_the_body_stops_it_however_thin() -> None:
    here = seeing_no_depth()
    assert here.persistent_obstacles is not None
    here.persistent_obstacles.add_contacts(np.array([[0.62, y] for y in np.arange(-3.0, 3.0, 0.05)]), 0.0)
    way = drive(here, World(()), (3.0, 0.0), 60)
    assert 0.2 < max(pose.x for pose in way) < 0.35


def test_not_even_as_a_last_resort_does_it_drive_into_what_it_remembers() -> None:
    here = seeing_no_depth()
    assert here.persistent_obstacles is not None
    here.persistent_obstacles.add_contacts(np.array([[0.62, y] for y in np.arange(-3.0, 3.0, 0.05)]), 0.0)
    way = drive(here, World(()), (3.0, 0.0), 450)
    assert here._path_tracker.opened_up
    assert max(pose.x for pose in way) < 0.35


def seeing_no_depth() -> ControlCycle:
    """It remembers, and drives by its laser."""
    here = ControlCycle(DrivenLink().description, "pursuit", depth=True)
    here._depth = None
    return here


def test_the_planner_gets_what_is_kept_with_another_map_though_it_changed_as_often() -> None:
    here = seeing_no_depth()
    assert here.persistent_obstacles is not None
    for x in (1.0, 2.0):
        things = PersistentObstacleLayer(Footprint.of(DrivenLink().description), 1.4)
        things.add_contacts(np.array([[x, 2.0]]), 1.0)
        here.persistent_obstacles.take(things.snapshot())
        output = here.run(CycleInput(0.0, MotionState(Pose2(), 0.0, 0.0), Pose2(), "", None), 0.1)
        assert output.persistent_obstacles == pytest.approx(np.array([[x, 2.0]]), abs=0.05)
    here.persistent_obstacles.clear()
    assert not len(
        here.run(CycleInput(0.1, MotionState(Pose2(), 0.0, 0.0), Pose2(), "", None), 0.1).persistent_obstacles
    )


@pytest.mark.parametrize(("given_mps", "contacts"), [(None, True), (0.2, True), (0.0, False)])
def test_a_body_that_others_keep_standing_feels_nothing(given_mps: float | None, *, contacts: bool) -> None:
    """The collision monitor stops it before what the laser sees: no unseen thing is there to be remembered."""
    here = seeing_no_depth()
    assert here.persistent_obstacles is not None
    goal = NavigationGoal(Pose2(3.0, 0.0, math.nan))
    poses = np.stack((np.linspace(0.0, 3.0, 60), np.zeros(60), np.zeros(60)), axis=1)
    plan: GlobalPlan | None = GlobalPlan("way", "", poses, goal.pose, 3.0)
    standing = MotionState(Pose2(), 0.0, 0.0)
    for k in range(15):
        scan = (World(()).scan(0.1 * k, Pose2()), Pose2(), Pose2())
        here.run(
            CycleInput(0.1 * k, standing, Pose2(), "", goal, scan, None, plan, None, EMPTY, given_mps=given_mps), 0.1
        )
        plan = None
    assert (len(here.persistent_obstacles.points) > 0) is contacts
