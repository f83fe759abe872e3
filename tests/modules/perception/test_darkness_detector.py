"""Darkness: the lit lab is light, a black image is dark, and between two thresholds nothing changes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.base.geometry import Pose2
from app.logs.open import open_log
from app.messages import Darkness, Image, PerceptEvent
from app.modules.perception.luma import mean_luma
from app.runtime.clock import run_virtual
from tests.modules.fakes import Bench, drain
from tests.modules.perception.rendering import kinect_image
from tests.references.figures import LOG


def bench(**settings: float) -> Bench:
    return Bench(
        "app.modules.perception.darkness_detector:DarknessDetector",
        inputs={"images": Image},
        outputs={"darkness": Darkness},
        settings=settings,
    )


def grey(luma: float, stamp: float = 0.0) -> Image:
    """An image of one grey."""
    image = kinect_image(stamp, Pose2(0.0, 0.0, 0.0), {})
    return replace(image, color=np.full_like(image.color, round(255 * luma)))


async def judge(b: Bench, *images: Image) -> list[bool]:
    judged = b.listen("darkness")
    for image in images:
        b.feed("images", image)
        await b.settle()
    return [message.dark for message in drain(judged)]


def test_the_lit_lab_is_not_dark_and_without_light_it_is() -> None:
    log = open_log(LOG)
    images = [logged.message for logged in log.messages(channels={"kinect"})]
    log.close()
    black = [replace(image, color=np.zeros_like(image.color)) for image in images]
    dim = [replace(image, color=image.color // 16) for image in images]

    async def main() -> None:
        async with bench() as b:
            assert await judge(b, *images) == [False] * len(images)
            assert await judge(b, *black) == [True] * len(images)
            assert await judge(b, *images) == [False] * len(images)
            assert await judge(b, *dim) == [True] * len(images)

    assert len(images) > 50
    run_virtual(main())


def test_between_the_thresholds_it_is_as_before() -> None:
    async def main() -> None:
        async with bench(dark_below=0.2, light_above=0.4) as b:
            lumas = (0.3, 0.1, 0.3, 0.5, 0.3, 0.1)
            assert await judge(b, *map(grey, lumas)) == [False, True, True, False, False, True]

    run_virtual(main())


@pytest.mark.parametrize(("color", "luma"), [((255, 0, 0), 0.2126), ((0, 255, 0), 0.7152), ((255, 255, 255), 1.0)])
def test_luma_weighs_the_colours_as_the_eye_does(color: tuple[int, int, int], luma: float) -> None:
    assert mean_luma(np.full((48, 64, 3), color, np.uint8), 8) == pytest.approx(luma)


def test_thresholds_in_the_wrong_order_are_refused() -> None:
    with pytest.raises(Exception, match="light_above should be at least dark_below"):
        bench(dark_below=0.5, light_above=0.4)


def test_it_darkens_and_lightens_as_events() -> None:
    b = Bench(
        "app.modules.perception.percept_events:PerceptEvents",
        inputs={"darkness": Darkness},
        outputs={"events": PerceptEvent},
    )

    async def main() -> None:
        async with b:
            events = b.listen("events")
            for step, dark in enumerate([False, True, True, True, False, True, False, False]):
                b.feed("darkness", Darkness(float(step), "kinect", 0.0, dark))
                await b.settle()
            happened = [(event.stamp, event.name, event.subject) for event in drain(events)]
            assert happened == [(2.0, "dark.appears", "kinect"), (7.0, "dark.leaves", "kinect")]

    run_virtual(main())
