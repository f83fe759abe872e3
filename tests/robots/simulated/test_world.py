"""The world's builder: the laboratory is what the issue of a lab asks for, and wrong worlds are refused."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pytest
from pydantic import ValidationError

from app.base.errors import ConfigError
from app.base.yaml_source import parse
from app.robots.config import RobotConfig
from app.robots.simulated.body import build_simulation
from app.robots.simulated.odometry import TrueBase
from app.robots.simulated.scenery import textures
from app.robots.simulated.scenery.people import add_people
from app.robots.simulated.scenery.scenario_config import ScenarioConfig
from app.robots.simulated.scenery.scenario_state import ScenarioState
from app.robots.simulated.world import X_WP_of_page, build_world
from app.robots.simulated.world_config import (
    CODE_RISE_M,
    CODE_SIDE_M,
    LETTER_HEIGHT_M,
    LETTER_WIDTH_M,
    MaterialConfig,
    WorldConfig,
)
from tests.robots.conftest import make_hall


@pytest.fixture(scope="module")
def probe(lab: WorldConfig) -> Callable[[float, float, float, float, float], float]:
    """``probe(x, y, z, dx, dy)``: distance (m) from a point to the first thing along a direction; inf if none."""
    model = build_world(lab).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)

    def cast(x: float, y: float, z: float, dx: float, dy: float) -> float:
        hit = np.zeros(1, dtype=np.int32)
        direction = np.array([dx, dy, 0.0]) / math.hypot(dx, dy)
        distance = mujoco.mj_ray(model, data, np.array([x, y, z]), direction, None, True, -1, hit)
        return float(distance) if hit[0] >= 0 else math.inf

    return cast


def test_the_lab_is_large_and_closed(lab: WorldConfig, probe: Callable[..., float]) -> None:
    assert lab.size[0] >= 20
    assert lab.size[1] >= 15
    for degrees in range(0, 360, 2):
        angle = math.radians(degrees)
        assert probe(11.1, 8.0, 1.0, math.cos(angle), math.sin(angle)) < 25


@pytest.mark.parametrize(
    ("start", "towards", "through_m"),
    [
        ((4.5, 8.0), (0, 1), 1.8),  # corridor to workshop
        ((12.3, 8.0), (0, 1), 1.8),  # corridor to robotics lab
        ((19.0, 8.0), (0, 1), 1.8),
        ((7.2, 8.0), (0, -1), 1.8),  # corridor to office
        ((17.2, 8.0), (0, -1), 1.8),  # corridor to living room
        ((11.0, 1.6), (-1, 0), 1.8),  # south corridor to office
        ((11.0, 2.6), (1, 0), 1.8),  # south corridor to living room
        ((9.6, 13.8), (1, 0), 1.5),  # workshop to robotics lab
    ],
)
def test_the_doors_are_open_wide_enough_for_the_robot(
    probe: Callable[..., float], start: tuple[float, float], towards: tuple[int, int], through_m: float
) -> None:
    across = (-towards[1], towards[0])
    for shift in (-0.30, 0.0, 0.30):
        x, y = start[0] + shift * across[0], start[1] + shift * across[1]
        assert probe(x, y, 0.4, *towards) > through_m, (start, shift)


def test_there_are_low_things_under_the_lasers_plane(lab: WorldConfig) -> None:
    low = [o for o in lab.objects if o.size and o.z == 0 and o.size[2] < 0.38]
    assert len(low) >= 5


def test_four_posters_hang_on_walls_beside_doors(lab: WorldConfig, probe: Callable[..., float]) -> None:
    posters = [poster for poster in lab.posters if poster.text.startswith("tour:")]
    assert len({poster.text for poster in posters}) == 4
    for poster in posters:
        facing = math.radians(poster.facing_deg)
        c, s = math.cos(facing), math.sin(facing)
        x, y, z = poster.p_WQ
        assert z == pytest.approx(1.25)
        page = X_WP_of_page(poster)
        np.testing.assert_allclose(page.rotation[:, 2], [c, s, 0], atol=1e-9)
        # from a metre in front, beside the page, the wall is as far as the page's face
        beside = 0.2
        assert probe(x + c - s * beside, y + s + c * beside, z, -c, -s) == pytest.approx(1.0, abs=0.002)
        assert probe(x + c, y + s, z, -c, -s) == pytest.approx(1.0, abs=0.003)
        door = min(
            math.dist((x, y), (wall.start[0] + d.at * u, wall.start[1] + d.at * v))
            for wall in lab.walls
            for u, v in [((wall.end[0] - wall.start[0]) / wall.length_m, (wall.end[1] - wall.start[1]) / wall.length_m)]
            for d in wall.doors
        )
        assert door < 1.3


def test_the_start_pose_is_free(robot: RobotConfig, lab: WorldConfig) -> None:
    simulation = build_simulation(robot, lab, TrueBase(0.10, 0.10, 0.44))
    for _ in range(500):
        simulation.step()
    model, contacts = simulation.model, simulation.data.contact
    of_robot = model.body_rootid[model.geom_bodyid] == simulation.base_body
    pairs = [pair for pair in contacts.geom[: simulation.data.ncon].tolist() if of_robot[pair].any()]
    touched = {model.geom(geom).name for pair in pairs for geom in pair if not of_robot[geom]}
    assert touched == {"floor"}


def test_a_loose_object_lies_still_where_it_was_put(robot: RobotConfig, lab: WorldConfig) -> None:
    simulation = build_simulation(robot, lab, TrueBase(0.10, 0.10, 0.44))
    number = next(number for number, item in enumerate(lab.objects) if item.mass_kg is not None)
    block = simulation.data.body(f"box{number}")
    for _ in range(500):
        simulation.step()
    settled = block.xpos.copy()
    for _ in range(2500):
        simulation.step()
    assert np.abs(block.xpos - settled).max() < 2e-5, "in five seconds: a camera draws again what moved by 1e-4 m"
    assert settled == pytest.approx((*lab.objects[number].at, lab.objects[number].z), abs=0.001)


def test_the_same_configuration_gives_the_same_world(lab: WorldConfig) -> None:
    first, second = build_world(lab).compile(), build_world(lab).compile()
    np.testing.assert_array_equal(first.geom_pos, second.geom_pos)
    np.testing.assert_array_equal(first.tex_data, second.tex_data)
    other = build_world(lab.model_copy(update={"seed": 2})).compile()
    assert not np.array_equal(first.tex_data, other.tex_data)


def test_without_a_camera_nothing_is_painted_and_all_else_is_the_same(lab: WorldConfig) -> None:
    painted, plain = build_world(lab).compile(), build_world(lab, textured=False).compile()
    assert painted.ntex > 0
    assert plain.ntex == 0
    for array in ("geom_type", "geom_size", "geom_pos", "geom_quat", "geom_contype", "geom_group", "body_mass"):
        np.testing.assert_array_equal(getattr(painted, array), getattr(plain, array))


def test_without_a_camera_people_are_not_painted_either_and_stand_all_the_same(lab: WorldConfig) -> None:
    visitor = {"name": "visitor", "face": "pilot", "at": (2.0, 3.0), "heading_deg": 30, "height_m": 1.7}
    actors = ScenarioState(ScenarioConfig.model_validate({"name": "one", "people": [visitor]})).actors
    models = []
    for textured in (True, False):
        spec = build_world(lab, textured=False)
        add_people(spec, actors, lab.seed, textured=textured)
        models.append(spec.compile())
    painted, plain = models
    assert (painted.ntex, plain.ntex) == (1, 0)
    for array in ("body_pos", "body_quat", "geom_type", "geom_size", "geom_pos", "geom_contype", "geom_group"):
        np.testing.assert_array_equal(getattr(painted, array), getattr(plain, array))


@pytest.mark.parametrize("pattern", sorted(textures._PATTERNS))
def test_every_pattern_has_texture_and_is_reproducible(pattern: str) -> None:
    material = MaterialConfig.model_validate({"pattern": pattern, "color": (160, 120, 80), "second": (90, 70, 50)})
    image = textures.texture(material, 4)
    assert image.dtype == np.uint8
    assert image.shape[2] == 3
    np.testing.assert_array_equal(image, textures.texture(material, 4))
    assert image.std() > 1.0


def test_a_poster_page_is_us_letter_with_the_code_where_the_configuration_says() -> None:
    page = textures.poster_page("tour:nine", "Nine", pixels_per_m=2000)
    assert page.shape[:2] == (round(2000 * LETTER_HEIGHT_M), round(2000 * LETTER_WIDTH_M))
    dark = np.argwhere(page[: round(2000 * (LETTER_HEIGHT_M / 2 + CODE_SIDE_M / 2 - CODE_RISE_M + 0.003)), :, 0] < 60)
    top, left = dark.min(axis=0)
    bottom, right = dark.max(axis=0)
    assert (right - left + 1) / 2000 == pytest.approx(CODE_SIDE_M, abs=0.002)
    assert (top + bottom) / 2 == pytest.approx(2000 * (LETTER_HEIGHT_M / 2 - CODE_RISE_M), abs=3)


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"objects": [{"kind": "tabel", "at": (3, 3)}]}, "did you mean 'table'"),
        ({"floor": "lava"}, "no material 'lava'"),
        (
            {"walls": [{"from": (0, 0), "to": (4, 0), "material": "wall", "doors": [{"at": 1}, {"at": 1.5}]}]},
            "overlaps another",
        ),
        ({"walls": [{"from": (0, 0), "to": (4, 0), "material": "wall", "doors": [{"at": 3.9}]}]}, "leaves its wall"),
    ],
)
def test_worlds_that_cannot_be_are_refused(change: dict[str, object], complaint: str) -> None:
    with pytest.raises(ValidationError, match=complaint):
        make_hall(**change)


def test_errors_in_a_world_file_name_the_line(tmp_path: Path) -> None:
    path = tmp_path / "world.yaml"
    path.write_text("name: w\nsize: [3, 3]\nfloor: f\nmaterials: {f: {pattern: sponge}}\n")
    with pytest.raises(ConfigError) as refused:
        parse(path, WorldConfig)
    assert refused.value.line == 4
