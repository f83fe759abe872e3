"""State of a scenario: people follow their scripts, wait for the robot, look in the given direction; sounds come at
their times."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.base import paths
from app.base.geometry import Pose2, wrap_angle
from app.base.yaml_source import parse
from app.modules.perception.height_prior import SHARES, STANDING
from app.robots.config import load_robot_config
from app.robots.simulated.scenery import gait
from app.robots.simulated.scenery.scenario_config import ScenarioConfig, load_scenario
from app.robots.simulated.scenery.scenario_state import (
    HEIGHT_MEAN_M,
    HEIGHT_SIGMA_M,
    LOOKAHEAD_S,
    Cue,
    ScenarioState,
    draw_heights,
)
from app.robots.simulated.world_config import WallConfig, WorldConfig

AWAY = Pose2(50.0, 50.0, 0.0)


def person(name: str = "person 1", at: tuple[float, float] = (0.0, 0.0), **more: Any) -> dict[str, Any]:
    return {"name": name, "face": "pilot", "at": at, **more}


def scenario_state(*people: dict[str, Any], seed: int = 1, **more: Any) -> ScenarioState:
    return ScenarioState(ScenarioConfig.model_validate({"name": "test", "seed": seed, "people": people, **more}))


def test_heights_are_drawn_from_the_gaussian_that_perceptions_suppose() -> None:
    assert (STANDING.mean_m, STANDING.sigma_m) == (HEIGHT_MEAN_M, HEIGHT_SIGMA_M)
    assert SHARES["mouth"] == gait.MOUTH_SHARE
    assert SHARES["eyes"] == gait.EYES_SHARE
    heights = draw_heights(np.random.default_rng(5), 4000)
    assert np.mean(heights) == pytest.approx(STANDING.mean_m, abs=0.01)
    assert np.std(heights) == pytest.approx(STANDING.sigma_m, rel=0.06)


def test_the_seed_draws_the_heights_and_a_given_height_stands() -> None:
    three = [person(f"person {i}", (i, 0)) for i in range(3)]
    one, again, other = scenario_state(*three), scenario_state(*three), scenario_state(*three, seed=2)
    assert [p.height_m for p in one.people] == [p.height_m for p in again.people]
    assert [p.height_m for p in one.people] != [p.height_m for p in other.people]
    assert scenario_state(person(height_m=1.52)).people[0].height_m == 1.52


def test_a_walk_takes_its_time_and_ends_at_its_point() -> None:
    walk = scenario_state(person(script=[{"walk": (3, 0), "speed": 1.2}], repeat=False))
    speeds = []
    for i in range(1, 500):
        before = walk.people[0].x
        walk.advance(i * 0.01, AWAY)
        speeds.append((walk.people[0].x - before) / 0.01)
    assert walk.people[0].x == pytest.approx(3.0, abs=0.02)
    assert walk.people[0].y == pytest.approx(0.0, abs=1e-9)
    assert max(speeds) == pytest.approx(1.2, abs=0.01)
    assert max(abs(b - a) for a, b in itertools.pairwise(speeds)) < 0.16  # no person starts or stops in an instant


def test_a_person_waits_before_the_robot_and_goes_on_when_it_is_gone() -> None:
    walk = scenario_state(person(script=[{"walk": (6, 0), "speed": 1.2}], repeat=False))
    robot = Pose2(3.0, 0.1, math.pi)
    nearest = math.inf
    for i in range(1, 1000):
        walk.advance(i * 0.01, robot)
        nearest = min(nearest, math.dist((robot.x, robot.y), (walk.people[0].x, walk.people[0].y)))
    assert 0.9 < nearest < 1.2
    assert walk.actors[0].speed == 0.0
    for i in range(1000, 1600):
        walk.advance(i * 0.01, AWAY)
    assert walk.people[0].x == pytest.approx(6.0, abs=0.02)


def test_who_gives_way_goes_back_the_way_they_came_and_tries_again() -> None:
    walk = scenario_state(person(script=[{"walk": (6, 0), "speed": 1.2}], repeat=False, gives_way_s=4))
    robot = Pose2(3.0, 0.1, math.pi)
    xs = []
    for i in range(1, 1400):
        walk.advance(i * 0.01, robot)
        xs.append(walk.people[0].x)
    stopped = xs[500]
    assert stopped == pytest.approx(1.9, abs=0.15)
    assert min(xs[800:1000]) == pytest.approx(stopped - 1.0, abs=0.1), "a metre back"
    assert xs[-1] == pytest.approx(stopped, abs=0.1), "there again, and waiting"
    for i in range(1400, 2600):
        walk.advance(i * 0.01, AWAY)
    assert walk.people[0].x == pytest.approx(6.0, abs=0.02)


def test_who_has_just_turned_a_corner_gives_way_round_it() -> None:
    script = [{"walk": (3, 0), "speed": 1.2}, {"walk": (3, 6), "speed": 1.2}]
    walk = scenario_state(person(script=script, repeat=False, gives_way_s=4))
    robot, least = Pose2(3.0, 1.2, 0.0), math.inf
    for i in range(1, 1300):
        walk.advance(i * 0.01, robot)
        least = min(least, walk.people[0].x) if i > 600 else least
    assert least == pytest.approx(2.0, abs=0.15)


def test_passing_beside_the_robot_is_no_reason_to_wait() -> None:
    walk = scenario_state(person(script=[{"walk": (6, 0), "speed": 1.2}], repeat=False))
    walk.advance(7.0, Pose2(3.0, 0.8, 0.0))
    assert walk.people[0].x == pytest.approx(6.0, abs=0.02)


@pytest.mark.parametrize("bearing_deg", [20.0, -80.0, 150.0, 179.0])
def test_who_looks_at_the_robot_turns_head_and_body_to_it(bearing_deg: float) -> None:
    look = scenario_state(person(script=[{"wait": 60, "look": "robot"}]))
    bearing = math.radians(bearing_deg)
    robot = Pose2(3 * math.cos(bearing), 3 * math.sin(bearing), 0.0)
    look.advance(6.0, robot)
    assert abs(wrap_angle(look.people[0].heading - bearing)) < math.radians(3)
    assert abs(wrap_angle(look.actors[0].heading - bearing)) < math.radians(40)  # no owl


def test_people_look_at_the_robot_only_where_the_script_says_so() -> None:
    look = scenario_state(person(heading_deg=90, script=[{"wait": 60}]))
    look.advance(6.0, Pose2(3.0, 0.0, 0.0))
    assert look.people[0].heading == pytest.approx(math.pi / 2)


def test_waiting_for_the_robot_ends_when_it_comes_or_the_time_is_over() -> None:
    script = [{"wait_for_robot": (5, 5), "within": 1.0, "at_most": 4.0}, {"walk": (1, 0)}]
    waits = scenario_state(person(script=script, repeat=False))
    waits.advance(3.9, AWAY)
    assert waits.people[0].x == 0.0
    waits.advance(7.0, AWAY)
    assert waits.people[0].x > 0.9
    comes = scenario_state(person(script=script, repeat=False))
    comes.advance(1.0, Pose2(5.5, 5.0, 0.0))
    comes.advance(3.5, AWAY)
    assert comes.people[0].x > 0.9


def test_what_is_said_comes_from_the_mouth_and_moves_with_it() -> None:
    script = [{"wait": 1}, {"say": "hello", "gain_db": 3}, {"walk": (4, 0), "speed": 1.0}]
    says = scenario_state(person(script=script, repeat=False, height_m=1.8))
    says.advance(1.5, AWAY)
    [cue] = says.cues
    assert (cue.kind, cue.person, cue.clip, cue.gain_db, cue.loop) == ("speech", "person 1", "hello", 3.0, False)
    assert cue.begin_s == pytest.approx(1.0, abs=0.011)
    begin = says.place(cue)
    assert begin == says.people[0].mouth
    assert begin[2] == pytest.approx(SHARES["mouth"] * 1.8, abs=0.02)
    says.advance(4.0, AWAY)
    assert says.place(cue)[0] > begin[0] + 1.5


def test_claps_are_reported_before_they_sound_and_the_palms_meet_then() -> None:
    claps = scenario_state(person(script=[{"wait": 1}, {"clap": 3, "every": 0.5}, {"wait": 60}]))
    apart: dict[int, float] = {}
    seen: dict[str, Cue] = {}
    for i in range(1, 400):
        claps.advance(i * 0.01, AWAY)
        for cue in claps.cues:
            if cue.name not in seen:
                assert cue.begin_s > claps.time_s + 0.2
                seen[cue.name] = cue
        apart[i] = claps.actors[0].posture.apart
    assert [cue.kind for cue in seen.values()] == ["clap"] * 3
    times = [cue.begin_s for cue in seen.values()]
    assert np.diff(times) == pytest.approx([0.5, 0.5])
    assert [apart[round(time / 0.01)] for time in times] == pytest.approx([0, 0, 0], abs=0.08)
    assert max(apart[i] for i in range(round(times[0] / 0.01), round(times[1] / 0.01))) == 1.0
    hands = claps.place(next(iter(seen.values())))
    assert 0.2 < math.hypot(hands[0], hands[1]) < 0.5
    assert 1.0 < hands[2] < 1.5


def test_steps_are_heard_while_walking_only() -> None:
    walks = scenario_state(person(script=[{"walk": (4, 0), "speed": 1.2}], repeat=False), footsteps={"clip": "step"})
    steps: dict[str, float] = {}
    for i in range(1, 800):
        walks.advance(i * 0.01, AWAY)
        steps |= {cue.name: cue.begin_s for cue in walks.cues}
    assert 5 <= len(steps) <= 9  # of about 0.6 m
    assert max(steps.values()) < 5.0


def sounds(seed: int) -> list[tuple[str, float]]:
    door = {"name": "door", "kind": "door", "clip": "door", "at": (1, 2, 1), "begin_s": 3, "every_s": 10, "jitter_s": 5}
    alarm = {"name": "alarm", "kind": "alarm", "clip": "alarm", "at": (0, 0, 2), "begin_s": 1, "loop": True}
    many = scenario_state(sounds=[door | {"count": 4}, alarm], seed=seed)
    found: dict[str, float] = {}
    for i in range(100):
        many.advance(i * 1.0, AWAY)
        for cue in many.cues:
            assert cue.name in found or cue.begin_s >= many.time_s - 1.0  # no sound is added too late
            assert cue.begin_s <= many.time_s + LOOKAHEAD_S
            found[cue.name] = cue.begin_s
            assert many.place(cue) == ((1, 2, 1) if cue.name.startswith("door") else (0, 0, 2))
    assert [cue.name for cue in many.cues if cue.loop] == ["alarm"]
    return list(found.items())


def test_sounds_come_at_their_times_with_jitter_from_the_seed() -> None:
    heard = sounds(1)
    assert heard[0] == ("alarm", 1.0)
    doors = [begin for _, begin in heard[1:]]
    assert len(doors) == 4
    for number, begin in enumerate(doors):
        assert 3 + 10 * number <= begin <= 8 + 10 * number
    assert sounds(1) == heard
    assert sounds(2) != heard


@settings(max_examples=20, deadline=None)
@given(
    cuts=st.lists(st.floats(0.001, 0.5), min_size=1, max_size=60),
    robot=st.tuples(st.floats(-3, 5), st.floats(-3, 3)),
)
def test_how_often_time_is_reported_changes_nothing(cuts: list[float], robot: tuple[float, float]) -> None:
    script = [{"walk": (2, 1)}, {"clap": 1, "look": "robot"}, {"say": "hello"}, {"walk": (0, 0), "look": "robot"}]
    pose = Pose2(*robot, 0.0)
    one, other = (scenario_state(person(script=script), footsteps={}) for _ in range(2))
    time = 0.0
    for cut in cuts:
        time += cut
        one.advance(time, pose)
    other.advance(time, pose)
    assert one.people == other.people
    assert [c for c in one.cues if c.kind != "steps"] == [c for c in other.cues if c.kind != "steps"]


@pytest.mark.parametrize("name", ["lab", "trial"])
def test_the_shipped_people_keep_off_walls_posters_each_other_and_the_start(name: str) -> None:
    folder = paths.config_dir()
    world = parse(folder / "worlds" / "lab.yaml", WorldConfig)
    scenario = load_scenario(folder / "scenarios" / f"{name}.yaml")
    start = scenario.start or load_robot_config(folder / "robots" / "irl1_tr.yaml").start
    robot = Pose2(start.x, start.y, math.radians(start.heading_deg))
    life = ScenarioState(scenario)
    before_a_poster = dict.fromkeys((poster.text for poster in world.posters), 0.0)
    moved = dict.fromkeys((p.name for p in life.people), 0.0)
    seconds, period = 200.0, 0.4
    for i in range(1, int(seconds / period)):
        last = {p.name: (p.x, p.y) for p in life.people}
        life.advance(i * period, robot)
        for p in life.people:
            moved[p.name] += math.dist(last[p.name], (p.x, p.y))
            assert math.dist((p.x, p.y), (robot.x, robot.y)) > 1.5
            for wall in world.walls:
                assert clearance((p.x, p.y), wall) > 0.25, (p, wall)
            for poster in world.posters:
                if math.dist((p.x, p.y), poster.at) < 1.0:
                    before_a_poster[poster.text] += period
        for one, other in itertools.combinations(life.people, 2):
            assert math.dist((one.x, one.y), (other.x, other.y)) > 0.6, (one.name, other.name)
    assert max(before_a_poster.values()) < 0.1 * seconds
    assert sum(distance > 5.0 for distance in moved.values()) >= 2


def clearance(at: tuple[float, float], wall: WallConfig) -> float:
    """Metres from ``at`` to what of ``wall`` is no door."""
    (x0, y0), (x1, y1) = wall.start, wall.end
    ux, uy = (x1 - x0) / wall.length_m, (y1 - y0) / wall.length_m
    along, aside = (at[0] - x0) * ux + (at[1] - y0) * uy, abs((at[1] - y0) * ux - (at[0] - x0) * uy)
    if any(abs(along - door.at) < door.width / 2 - 0.2 for door in wall.doors):
        return math.inf
    beyond = max(0.0, -along, along - wall.length_m)
    return math.hypot(beyond, aside) - wall.thickness / 2
