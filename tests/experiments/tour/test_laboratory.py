"""The laboratory as a map: its frame, its walls, and the places before its posters."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.base import paths
from app.base.errors import ConfigError
from app.base.geometry import Pose2
from app.base.kinematic_model import load_model
from app.experiments.simulated import simulated_body
from app.experiments.tour import laboratory
from app.experiments.tour.experiment import plan
from app.experiments.tour.observer import off_deg
from app.maps.grid_rays import GridRays
from app.program.config import load_configuration
from app.robots.factory import simulated_parts
from app.tours.tour_file import load_tour
from tests.tours.tours import tour

LAB_TOUR = paths.config_dir() / "tours" / "lab-tour.yaml"


@pytest.mark.slow
def test_the_packaged_tour_can_be_led_on_the_map_of_the_laboratory() -> None:
    body = simulated_body(load_configuration(paths.config_dir() / "lab.yaml"))
    robot, world, _ = simulated_parts(body.model_copy(update={"scenario": None}))
    X_WM = laboratory.origin_of(robot)
    rays = GridRays(laboratory.drawn(world, robot, X_WM))
    places = {place.id: place for place in laboratory.places(world.posters, X_WM)}
    packaged, _ = load_tour(LAB_TOUR)
    for name in (packaged.home, *(stop.place for stop in packaged.stops)):
        assert name is not None
        place = places[name]
        assert rays.clear_m(place.x, place.y) > 0.4, "the robot has room"
        if name == packaged.home:
            continue  # the dock is before its poster
        (wall_m,) = rays.cast(place.x, place.y, directions=np.array([place.heading]), reach_m=3.0)
        assert wall_m == pytest.approx(1.2, abs=0.12), "its poster hangs straight ahead, on a wall"
    points = [step.point for stop in packaged.stops for step in stop.do if step.point is not None]
    arm = next(each for each in world.objects if each.kind == "robot_arm" and each.at[0] > 10)
    (point,) = points
    at = X_WM @ Pose2(*point[:2])
    assert math.dist((at.x, at.y), arm.at) < 0.05, "what is pointed at is the arm on the table"


def test_places_that_the_world_does_not_have_are_refused() -> None:
    with pytest.raises(ConfigError, match=r"has no place nowhere; before the posters of the world there are: robot"):
        plan(tour(home="nowhere"))


def test_an_arm_that_hangs_down_points_at_the_floor() -> None:
    body = simulated_body(load_configuration(paths.config_dir() / "lab.yaml"))
    model, arm = load_model(body.model), body.arm_descriptions["left"]
    line = body.groups[arm.group].joints[0].name, arm.hand
    poses = model.poses((model.joints[line[0]].child, arm.hand), {})
    shoulder, hand = (poses[link].translation for link in (model.joints[line[0]].child, arm.hand))
    assert off_deg(model, {}, line, shoulder + 3 * (hand - shoulder)) == pytest.approx(0.0, abs=1e-4)
    assert off_deg(model, {}, line, shoulder - (hand - shoulder)) == pytest.approx(180.0, abs=1e-4)
