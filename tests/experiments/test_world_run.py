"""A whole program in a world that keeps its time: it runs as configured, ends with its script, and fails loudly."""

from __future__ import annotations

from dataclasses import replace

import pytest

from app.attention.desires import Source
from app.base import paths
from app.base.errors import ConfigError
from app.experiments.world_run import WorldRun, able, run_in_world, with_settings
from app.link import LinkFailed
from app.messages import LaserScan, TeleopCommand
from app.program.config import Configuration, load_configuration
from app.robots.config import RobotConfig
from app.robots.factory import create_lockstep, load_body
from app.robots.simulated.world_config import WorldConfig
from app.runtime.clock import VirtualClock
from tests.robots.conftest import make_hall


@pytest.fixture
def jackal() -> tuple[Configuration, RobotConfig, WorldConfig]:
    """The Jackal's program without what maps and goes by itself, its body, and an empty hall around it."""
    configuration = load_configuration(paths.config_dir() / "jackal.yaml")
    body = load_body(configuration.path(configuration.program.robot))
    assert isinstance(body, RobotConfig)
    start = body.start.model_copy(update={"x": 5.0, "y": 10.0, "heading_deg": 0.0})
    return configuration, body.model_copy(update={"start": start}), make_hall()


def only(configuration: Configuration, *names: str) -> Configuration:
    modules = {name: spec for name, spec in configuration.program.modules.items() if name in names}
    return replace(configuration, program=configuration.program.model_copy(update={"modules": modules}))


BY_HAND = ("Hokuyo", "WheelOdometry", "Teleop", "MobileBaseControl")


def test_a_program_drives_in_virtual_time_and_two_runs_are_the_same(
    jackal: tuple[Configuration, RobotConfig, WorldConfig],
) -> None:
    configuration, body, hall = jackal

    async def script(run: WorldRun) -> tuple[float, int, str]:
        scans: list[LaserScan] = []
        run.system.graph.channels["scan"].observe(scans.append)
        desire = run.system.workspace.add("Teleoperation", intensity=1, utility=1, source=Source("operator", "a test"))
        operator = run.system.graph.channels["teleop_command"]
        for number in range(40):
            operator.publish(TeleopCommand(run.system.clock.now(), "a test", number, True, 0.5, 0.0))
            await run.system.clock.sleep(0.05)
        return run.link.true_pose().x, len(scans), desire.id

    one, two = (run_in_world(only(configuration, *BY_HAND), body, script, world=hall) for _ in range(2))
    assert one == two
    x, scans, desire_id = one
    assert 6.0 < x < 7.0  # half of 2 m/s for 2 s, less speeding up
    assert scans == pytest.approx(2.0 * 40, abs=4)
    assert desire_id == "d1"


def test_modules_of_streams_that_are_not_there_are_left_out_and_their_channels_silent() -> None:
    configuration = load_configuration(paths.config_dir() / "lab.yaml")
    body = load_body(configuration.path(configuration.program.robot))
    assert isinstance(body, RobotConfig)
    blind = able(configuration, create_lockstep(body, VirtualClock()))
    gone = set(configuration.program.modules) - set(blind.program.modules)
    assert gone == {"Kinect", "PanoramicCamera", "Microphones", "Recorder"}
    assert blind.channels["kinect"].external
    assert blind.channels["kinect"].rate_hz is None
    assert not blind.channels["scan"].external
    seeing = able(configuration, create_lockstep(body, VirtualClock(), cameras=True))
    assert set(configuration.program.modules) - set(seeing.program.modules) == {"Microphones", "Recorder"}


def test_the_scripts_mistakes_and_the_worlds_are_raised(
    jackal: tuple[Configuration, RobotConfig, WorldConfig],
) -> None:
    configuration, body, hall = jackal
    configuration = only(configuration, *BY_HAND)

    async def wrong(run: WorldRun) -> None:
        await run.system.clock.sleep(0.1)
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        run_in_world(configuration, body, wrong, world=hall)

    async def end_of_the_world(run: WorldRun) -> None:
        run.link.attach("odometry", lambda _: None)
        assert run.link._simulation is not None

        def fall(*_: object) -> None:
            raise RuntimeError("the sky falls")

        run.link._simulation.turn = fall  # type: ignore[assignment]
        await run.system.clock.sleep(10.0)

    with pytest.raises(LinkFailed, match="the sky falls"):
        run_in_world(configuration, body, end_of_the_world, world=hall)


def test_settings_stand_in_for_the_configurations() -> None:
    configuration = load_configuration(paths.config_dir() / "jackal.yaml")
    changed = with_settings(configuration, {"MobileBaseControl": {"max_age_s": 0.5}})
    settings = changed.program.modules["MobileBaseControl"].settings
    assert settings["max_age_s"] == 0.5
    assert settings["behaviors"] == configuration.program.modules["MobileBaseControl"].settings["behaviors"]
    with pytest.raises(ConfigError, match="there is no module Nobody; "):
        with_settings(configuration, {"Nobody": {}})
