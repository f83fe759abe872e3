from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

from app.experiments.observation import Ages, Outcome, document
from app.experiments.overload.report import doubts, plot, table


def outcome(*, attention: bool, age: float) -> Outcome:
    series = [(t / 10, age) for t in range(50)]
    return Outcome(
        attention=attention,
        seconds=5.0,
        cpu=99.0,
        body_cpu=80.0,
        world_rate=1.0,
        ages={"faces": Ages.of([age] * 50), "exploitation": Ages.of([age / 10])},
        rates={"faces": 10.0, "exploitation": 10.0},
        dropped={"FaceDetector.images": 40},
        beats=40,
        missed=10,
        stops=1,
        loop_late_p99_s=0.25,
        found={"codes": 3, "faces": 2, "noises": 4, "voices": 1},
        true_claps=4,
        failures=0,
        series={"faces": series},
        utilities={"LocateFaces": 8.0},
    )


def test_both_conditions_stand_side_by_side() -> None:
    text = table(outcome(attention=False, age=1.5), outcome(attention=True, age=0.08))
    assert (
        "| faces looked for: age p50 / p95 / worst, ms (rate, Hz) | 1500 / 1500 / 1500 (10.0) | 80 / 80 / 80 (10.0) |"
        in text
    )
    assert "| 10 Hz beats of the base missed | 10 of 50 | 10 of 50 |" in text
    assert "qr" not in text.lower().split("codes found")[0], "what neither had has no row"


def test_machines_get_everything_but_the_series_and_no_nan() -> None:
    one = outcome(attention=False, age=math.nan)
    read = json.loads(json.dumps(document((one,), {"budget": 100}), allow_nan=False))
    assert read["budget"] == 100
    assert read["outcomes"][0]["ages"]["faces"]["median"] is None
    assert "series" not in read["outcomes"][0]


def test_the_picture_is_drawn(tmp_path: Path) -> None:
    plot(outcome(attention=False, age=1.5), outcome(attention=True, age=0.08), tmp_path / "picture.png")
    assert (tmp_path / "picture.png").stat().st_size > 10_000


def test_ages_of_nothing_are_unknown() -> None:
    ages = Ages.of([])
    assert ages.count == 0
    assert math.isnan(ages.p95)


def test_figures_of_a_busy_computer_are_doubted() -> None:
    quiet = outcome(attention=True, age=0.1)
    assert doubts((quiet,), 100) == []
    assert "other programs took 60 %" in doubts((replace(quiet, others_cpu=60.0),), 100)[0]
    assert doubts((replace(quiet, others_cpu=60.0),), 50) == [], "our own neighbour"
    assert "0.50 of real time" in doubts((replace(quiet, world_rate=0.5),), 100)[0]
