"""A small room with three posters and two visitors who follow the robot: for tours that are led for real."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import yaml

from app.base.paths import config_dir
from tests.browser.running import Robot, lighten, look_round_seldom, write_rules
from tests.patience import PATIENCE_S

SIDE_M = 5.6
#: Side of the walls: their faces are a tenth inside.
_IN, _OUT = 0.06, SIDE_M - 0.06
#: The start in the middle, looking east, where no poster hangs.
START = {"x": SIDE_M / 2, "y": SIDE_M / 2, "heading_deg": 0}
#: Counter-clockwise, as a robot that turns to the left meets them.
POSTERS: dict[str, dict[str, Any]] = {
    "tour:arm": {"at": [2.8, _OUT], "facing_deg": -90},
    "tour:desk": {"at": [_IN, 2.8], "facing_deg": 0},
    "tour:door": {"at": [2.8, _IN], "facing_deg": 90},
}
VISITORS = {"pilot": ([4.6, 3.4], 1.3, 0.6), "lecturer": ([4.6, 2.2], 1.6, 1.2)}


def write_program(folder: Path, *, visitors: bool, heading_deg: float = START["heading_deg"]) -> Path:
    """The lab's program in the room, its files in ``folder``; the robot begins with that heading (degrees)."""
    config = config_dir()
    lab = yaml.safe_load((config / "worlds" / "lab.yaml").read_text())
    used = ("terrazzo", "ceiling", "white_plaster", "brick", "blue_plaster", "green_plaster")
    corners = [(0, 0), (SIDE_M, 0), (SIDE_M, SIDE_M), (0, SIDE_M)]
    walls = [
        {"from": begin, "to": end, "material": material, "thickness": 0.1}
        for begin, end, material in zip(corners, corners[1:] + corners[:1], used[2:], strict=True)
    ]
    world = {
        "name": "room",
        "size": [SIDE_M, SIDE_M],
        "wall_height": 2.7,
        "floor": "terrazzo",
        "ceiling": "ceiling",
        "ambient": 0.6,
        "lights": lab["lights"],
        "materials": {name: lab["materials"][name] for name in used},
        "walls": [{key: list(value) if isinstance(value, tuple) else value for key, value in w.items()} for w in walls],
        "posters": [
            {"text": text, "title": text.removeprefix("tour:"), "height": 1.25, **hangs}
            for text, hangs in POSTERS.items()
        ],
    }
    people = [
        {
            "name": name,
            "face": name,
            "at": at,
            "heading_deg": 180,
            "script": [{"follow": 3600, "distance": distance, "lag": lag, "look": "robot"}],
        }
        for name, (at, distance, lag) in VISITORS.items()
    ]
    scenario = {"name": "visitors" if visitors else "nobody", "seed": 1, "people": people if visitors else []}
    body = yaml.safe_load((config / "robots" / "irl1_tr.yaml").read_text())
    body |= {
        "model": str(config / "robots" / body["model"]),
        "world": "room.yaml",
        "scenario": "scenario.yaml",
        "start": START | {"heading_deg": heading_deg},
        "guard_log": str(folder / "guard.log"),
    }
    program: dict[str, Any] = yaml.safe_load((config / "lab.yaml").read_text())
    channels = yaml.safe_load((config / program["channels"]).read_text())
    # Whether a tour succeeds must not depend on how fast the computer is.
    lighten(body, channels, small=False)
    look_round_seldom(body, channels)
    program |= {
        "robot": "robot.yaml",
        "channels": "channels.yaml",
        "strategies": [str(config / file) for file in program["strategies"]],
        "attention": program["attention"] | {"closed_loop": "off"},
        "rules": [write_rules(folder, [{"desire": "Teleoperation", "security": True}])],
    }
    files = {"room": world, "scenario": scenario, "robot": body, "channels": channels, "program": program}
    for name, content in files.items():
        (folder / f"{name}.yaml").write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
    return folder / "program.yaml"


def prepare(robot: Robot, tour: dict[str, Any], *places: dict[str, Any]) -> None:
    """A map called ``room``, ``places`` on it, and a ``tour`` of them."""
    status, _, answer = robot.request("POST", "/desires", {"class": "SLAM", "intensity": 5, "utility": 1})
    assert status == 201, answer
    given_up = time.monotonic() + PATIENCE_S
    while robot.request("PUT", "/maps/room")[0] == 409:  # until it has seen something
        assert time.monotonic() < given_up
    made = [("POST", "/places", place) for place in places]
    for method, path, body in [("PUT", "/maps/room", None), *made, ("POST", "/tours", tour)]:
        status, _, answer = robot.request(method, path, body)
        assert status in (200, 201), answer
