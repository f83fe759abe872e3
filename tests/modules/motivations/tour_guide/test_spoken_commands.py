"""The packaged tour, steered by the sound of words: the microphones' sound, the recognizer, the guide."""

from __future__ import annotations

import asyncio
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import resample_poly

from app.base import paths
from app.base.geometry import Pose2
from app.messages import HeardWords
from app.runtime.clock import run_virtual
from app.speech.espeak import Espeak
from app.tours.model import Tour
from app.tours.tour_file import read_tour
from tests.modules.fakes import Bench
from tests.modules.motivations.tour_guide.led_lab import LedLab, Visitor
from tests.modules.perception.test_word_recognizer import listening, play
from tests.modules.perception.voices import sounds
from tests.modules.perception.voices.sounds import toward
from tests.modules.perception.words.test_utterance_listener import noisy, quiet

PLACES = {
    "charging-dock": Pose2(),
    "workshop": Pose2(6.0, 0.0),
    "robotics-lab": Pose2(6.0, 6.0),
    "office": Pose2(0.0, 6.0),
}


def recognized(text: str, words: str) -> HeardWords:
    """``text`` said 60 degrees to the left of the robot, which listens for ``words``."""
    utterance = Espeak("m3").synthesize(text, "en-us")
    said = resample_poly(utterance.samples / 32768.0, 320, 147).astype(np.float32)
    sound = noisy(sounds.heard(np.concatenate([quiet(1.0), said, quiet(1.2)]), toward(60.0)))

    async def script(bench: Bench) -> HeardWords:
        bench.slot.configure({"words": words, "language": "en"})
        found = bench.listen("words")
        await play(bench, sound)
        message: HeardWords = await found.receive()  # the recognizer takes real time
        return message

    return listening(script)


async def say_to(led: LedLab, text: str) -> None:
    """Have the guide hear ``text``, said again where it is not recognized for sure, as a visitor would.

    espeak-ng never says a sentence twice alike, and one of six is not.
    """
    for _ in range(6):
        words = await asyncio.to_thread(recognized, text, listened_for(led))
        led.bench.feed("words", words)
        if not words.unsure:
            break
        assert words.likeliest == text
        await led.live(0.4)
    assert words.text == text


def packaged() -> Tour:
    file = paths.config_dir() / "tours" / "lab-tour.yaml"
    return read_tour(file.read_text(), str(file))[0]


def listened_for(led: LedLab) -> str:
    desire = led.desired("ListenForWords")
    assert desire is not None
    return str(desire.params["words"])


@pytest.mark.slow
def test_a_visitor_pauses_the_tour_by_saying_so_and_has_it_go_on(tmp_path: Path) -> None:
    pytest.importorskip("pocketsphinx")
    pytest.importorskip("espeakng_loader")
    tour = packaged()

    async def main() -> None:
        led = await asyncio.to_thread(LedLab, tmp_path, tour, PLACES)
        led.visitors = [Visitor(1.5, 0.5)]
        async with led:
            led.start()
            await led.until("confirming")
            led.press("agree")
            await led.until("leading")
            await say_to(led, "please wait")
            await led.until("paused", limit_s=2)
            assert led.progress.reason == "a visitor asked for a pause"
            assert led.moving() == []
            await say_to(led, "go on")
            await led.until("leading", limit_s=2)

    run_virtual(main())


@pytest.mark.slow
def test_visitors_are_led_to_the_stops_whose_words_they_say(tmp_path: Path) -> None:
    """On the way to another stop, and at a stop that waits for other words."""
    pytest.importorskip("pocketsphinx")
    pytest.importorskip("espeakng_loader")
    tour = packaged()
    phrases = {stop.id: stop.words["en"][0] for stop in tour.stops}
    places = {stop.id: PLACES[stop.place] for stop in tour.stops}

    async def main() -> None:
        led = await asyncio.to_thread(LedLab, tmp_path, tour, PLACES)
        led.visitors = [Visitor(1.5, 0.5)]

        async def say(stop: str) -> None:
            await say_to(led, phrases[stop])
            await led.live(2.0)
            assert (led.progress.state, led.progress.stop) == ("leading", stop)
            goal = led.desired("GoTo")
            assert goal is not None
            assert math.dist((goal.params["x"], goal.params["y"]), (places[stop].x, places[stop].y)) < 0.01

        async with led:
            led.start()
            await led.until("confirming")
            led.press("agree")
            await led.until("leading")
            assert led.progress.stop == "workshop"
            await say("robotics-lab")
            await led.until("listening")
            assert led.progress.stop == "robotics-lab"
            await say("office")
            await say("workshop")

    run_virtual(main())
