"""One run of a calibration, on a log: what the module took, found and cost."""

from __future__ import annotations

import pytest

from app.base import paths
from app.base.geometry import Pose3
from app.logs.replay.calibration_runs import Run
from app.logs.replay.measure import WARM_UP_S, Bench, percepts
from app.messages import Landmarks, QRCode, QRCodes, SoundSources, Twist
from app.program.config import Configuration, load_configuration
from tests.logs.replay.logs import lab_log

# Nothing runs on a loop that others wait for: the replay's own loop is virtual.
pytestmark = pytest.mark.blocking(reason="the virtual loop waits for threads by design")

SECONDS = 4.0
RATE_HZ = 10.0


@pytest.fixture
def configuration() -> Configuration:
    return load_configuration(paths.config_dir() / "lab.yaml")


@pytest.mark.parametrize(("phi", "offset"), [(1, 0), (4, 0), (4, 3)])
def test_a_module_alone_is_measured_at_its_divisor(configuration: Configuration, phi: int, offset: int) -> None:
    log = lab_log(SECONDS, images_hz=RATE_HZ)
    bench = Bench(log, configuration, log.info.begin, log.info.end)
    shares: list[float] = []
    (measured,) = bench.measure([Run("CameraStream", "images", phi, offset)], shares.append)
    images = sum(logged.at > log.info.begin + WARM_UP_S for logged in log.messages(channels=["kinect"]))
    assert measured.events == len(range(offset, images, phi))
    assert measured.duration_s == pytest.approx(log.info.duration_s - WARM_UP_S)
    assert shares == sorted(shares)
    assert shares[-1] == pytest.approx(1.0)
    assert 0 < measured.cpu < 100


def test_what_came_before_is_only_warmed_up_with(configuration: Configuration) -> None:
    log = lab_log(SECONDS, images_hz=RATE_HZ)
    bench = Bench(log, configuration, log.info.begin + 2.0, log.info.begin + 3.0)
    (measured,) = bench.measure([Run("CameraStream", "images", 1)])
    assert measured.events == RATE_HZ
    assert measured.duration_s == pytest.approx(1.0)


def test_percepts_are_counted_not_messages() -> None:
    code = QRCode("door", None, None)  # type: ignore[arg-type]
    assert percepts(QRCodes(0.0, "camera", 640, 480, Pose3.identity(), (code, code))) == 2
    assert percepts(Landmarks(0.0, ())) == 0
    assert percepts(Twist(0.0, 1.0, 0.0)) == 1
    # A tuple of numbers is no percept.
    assert percepts(SoundSources(0.0, (0.0, 0.0, 1.0), ())) == 0
