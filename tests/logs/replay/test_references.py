"""The modules against the reference values of a recorded minute; and that a change would be noticed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from app.logs.open import open_log
from app.logs.replay.headless import run_headless
from app.logs.replay.options import ReplayOptions
from app.messages import Exploitation, Image, QRCode, Twist
from app.modules.perception import qr_code_detector
from tests.references.figures import LOG, VALUES, Values, _Figures, compare, flat, load_values, measure, write_values

pytestmark = pytest.mark.blocking(reason="the virtual loop waits for threads by design")


@pytest.mark.slow
def test_every_module_makes_of_the_reference_log_what_it_did() -> None:
    differences = compare(measure(LOG), load_values(VALUES))
    assert differences == [], "meant? `make references` writes them again"


def test_the_reference_log_is_replayed_by_its_own_configuration() -> None:
    """As `hbba replay tests/references/lab.mcap` does: its files name the message types and modules there are."""
    log = open_log(LOG)
    try:
        report = run_headless(log, ReplayOptions(only=("Kinect", "WheelOdometry"), desires=False), digests=False)
    finally:
        log.close()
    assert report.end - report.begin == pytest.approx(60, abs=1)


def test_the_references_hold_every_kind_of_output() -> None:
    values = load_values(VALUES)
    assert set(values["landmarks"]["place"]) == {"tour:robotics lab", "tour:office", "tour:workshop"}
    assert values["clouds"]["points"] > 50_000
    assert values["pictures"]["bytes"] > 50_000
    assert values["driving"]["distance"] > 5
    assert len(values["intentions"]) > 5
    assert LOG.stat().st_size <= 6_000_000


@pytest.mark.slow
def test_a_detector_that_is_off_by_some_centimetres_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    right: Callable[..., tuple[QRCode, ...]] = vars(qr_code_detector)["detect"]

    def wrong(image: Image, upscale: bool) -> tuple[QRCode, ...]:
        return tuple(
            code if code.p_BQ is None else replace(code, p_BQ=(code.p_BQ[0] + 0.05, *code.p_BQ[1:]))
            for code in right(image, upscale)
        )

    monkeypatch.setattr(qr_code_detector, "detect", wrong)
    differences = compare(measure(LOG), load_values(VALUES))
    assert differences
    assert all(line.startswith(("landmarks.place", "channels.landmarks", "channels.displaced")) for line in differences)


# --- Comparing -------------------------------------------------------------------------------------------------------

MEASURED: Values = {
    "channels": {"qr_codes": 10},
    "landmarks": {"place": {"a": [1.0, 2.0, 3.0]}},
    "clouds": {"points": 1000},
    "intentions": [{"strategies": ["one", "two"], "omega": 8.0}],
}
REFERENCE: dict[str, Any] = {"tolerances": {"landmarks": 0.02, "landmarks.place.a.2": 0.5, "clouds.points": "1 %"}}


def changed(**values: Any) -> list[str]:
    return compare({**MEASURED, **values}, {**REFERENCE, **MEASURED})


def test_what_is_within_its_tolerance_does_not_differ() -> None:
    assert changed() == []
    assert changed(landmarks={"place": {"a": [1.019, 1.981, 3.4]}}, clouds={"points": 1010}) == []


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"landmarks": {"place": {"a": [1.021, 2.0, 3.0]}}}, "landmarks.place.a.0 is 1.021, it was 1.0"),
        ({"clouds": {"points": 1011}}, "clouds.points is 1011, it was 1000"),
        ({"channels": {"qr_codes": 11}}, "channels.qr_codes is 11, it was 10"),
        ({"channels": {}}, "channels.qr_codes is gone: it was 10"),
        ({"sounds": 3}, "sounds is new: 3"),
        (
            {"intentions": [{"strategies": ["one", "six"], "omega": 8.0}]},
            "intentions.0.strategies.1 is six, it was two",
        ),
    ],
)
def test_what_differs_is_named_with_both_values(values: Values, words: str) -> None:
    assert changed(**values) == [words]


def test_values_come_back_as_they_were_written(tmp_path: Path) -> None:
    write_values(tmp_path / "values.yaml", MEASURED)
    read = load_values(tmp_path / "values.yaml")
    assert read.pop("tolerances")
    assert flat(read) == flat(MEASURED)


def test_driving_is_judged_by_the_base_alone() -> None:
    figures = _Figures()
    for stamp in (0.0, 1.0, 2.0):
        figures.take("exploitation", Exploitation(stamp, "Teleop", Twist(stamp, 0.4, 0.1)))
        figures.take("head_exploitation", Exploitation(stamp, "LookAt", Twist(stamp, 0.0, 0.0), group="head"))
    driving = figures.values()["driving"]
    assert driving == {"drivers": {"Teleop": 3}, "distance": 0.8, "turned": 0.2}
