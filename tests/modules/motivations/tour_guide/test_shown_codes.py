"""Codes that visitors show: which count, what those do that the tour's author accepted, and that no other does."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.base.geometry import Pose2, Pose3
from app.messages import QRCode, QRCodes
from app.modules.motivations.tour_guide.kept import KeptRun, kept_bytes, read_kept
from app.modules.motivations.tour_guide.listening import CODE_AGAIN_S, ShownCodes
from app.modules.motivations.tour_guide.perceptions import CODES, perceptions
from app.modules.motivations.tour_guide.progress import Asked, Clapped, CodeRead, State
from app.runtime.clock import in_virtual_time
from app.tours.codes import CarriedText
from app.tours.model import Tour
from tests.modules.motivations.tour_guide.led_lab import LedLab, Visitor
from tests.modules.motivations.tour_guide.run import LAB, QUESTION, WAIT, Run, changed, say, stop

ONE, TWO, HELLO = "HBBA:STOP/ONE", "HBBA:STOP/TWO/EN/Mind the step.", "HBBA:SAY/FR/Bonjour !"
STRANGERS = ("HBBA:STOP/TWO", "HBBA:SAY/FR/Salut !", "HBBA:SAY/FR/bonjour !", "https://example.org", "HBBA:", "two")
STOPS = [
    stop("one", poster=ONE, do=[say("This is one."), WAIT], questions=[QUESTION]),
    stop("two", do=[say("This is two."), WAIT]),
    stop("three", poster="HBBA:STOP/THREE/EN/THREE."),
]


def listening(**more: object) -> Run:
    """At the first stop, which listens."""
    return Run(changed(stops=STOPS, accept=[TWO, HELLO], **more)).started().until("listening")


def test_a_code_that_says_something_is_said_and_then_it_listens_again() -> None:
    run = listening().see(after_s=29).see(CodeRead(HELLO))
    assert (run.texts(), run.wish("Say").params["language"]) == (["Bonjour !"], "fr")
    assert run.see(after_s=60).progress.state == "listening", "it is still speaking"
    assert run.done("Say").texts() == []
    assert run.see(after_s=29).progress.state == "listening", "its time begins again"
    assert run.see(after_s=2).progress.state == "leading"
    assert run.until("presenting").texts() == ["This is two."]


def test_a_text_that_cannot_be_said_holds_nothing_up() -> None:
    run = listening().see(CodeRead(HELLO)).done("Say", done=False)
    assert (run.texts(), run.progress.state, run.progress.failures) == ([], "listening", ())
    run.see(CodeRead(HELLO)).see(after_s=181)
    assert run.progress.state == "leading"


def test_what_ends_listening_ends_what_a_code_says() -> None:
    assert listening().see(CodeRead(HELLO)).see(Clapped(2)).until("presenting").texts() == ["This is two."]
    run = listening().see(CodeRead(HELLO)).see(Asked("weight"))
    assert run.texts() == ["Four kilograms."]
    assert run.done("Say").texts() == []


def test_a_code_of_a_stop_leads_there_and_what_it_carries_is_said_there_once() -> None:
    run = listening().see(CodeRead(TWO))
    assert (run.wish("GoTo").params["place"], run.texts()) == ("two", [])
    run.see(farthest_m=4.5).see(farthest_m=1.0)
    assert run.until("presenting").texts() == ["Mind the step.", "This is two."]
    run.done("Say", only=".code")
    assert run.progress.state == "presenting", "the step is awaited, too"
    assert run.until("listening").texts() == []
    assert run.press("repeat").texts() == ["This is two."]


def test_what_a_code_carries_is_no_step_that_fails() -> None:
    run = listening().see(CodeRead(TWO)).until("presenting").done("Say", done=False, only=".code")
    assert (run.progress.failures, run.progress.state) == ((), "presenting")


def test_on_the_way_elsewhere_it_is_not_said() -> None:
    run = listening().see(CodeRead(TWO)).press("skip")
    assert run.wish("GoTo").params["place"] == "three"
    assert run.until("presenting").texts() == ["This is three."]


def test_it_is_said_after_a_pause_and_a_restart() -> None:
    run = listening().see(CodeRead(TWO)).press("pause").press("resume")
    assert run.until("presenting").press("pause").press("resume").texts() == ["Mind the step.", "This is two."]
    found = read_kept(kept_bytes(KeptRun("", 0.0, run.progress)))
    assert found is not None
    assert found.progress.carried == CarriedText("en", "Mind the step.")
    spoken = listening().see(CodeRead(HELLO)).press("pause")
    assert spoken.texts() == ["One moment, please."]
    assert spoken.press("resume").texts() == ["Bonjour !"]


def test_the_poster_of_this_stop_does_nothing_there() -> None:
    run = listening()
    assert run.see(CodeRead(ONE)).progress.state == "listening"
    back = listening().see(CodeRead(TWO)).until("listening").see(CodeRead(ONE))
    assert back.wish("GoTo").params["place"] == "one"
    three = [STOPS[0], STOPS[2] | {"do": [say("This is three."), WAIT]}]
    run = Run(changed(stops=three)).started().until("listening").see(Clapped(2)).until("listening")
    assert run.see(CodeRead("HBBA:STOP/THREE/EN/THREE.")).texts() == [], "it hangs there"


@pytest.mark.parametrize("text", STRANGERS)
def test_a_strangers_code_does_nothing_at_all(text: str) -> None:
    run = listening()
    before = run.progress
    assert run.see(CodeRead(text)).progress == replace(before, company=run.progress.company)
    assert run.wishes() == ()


@pytest.mark.parametrize(
    "state", ["inviting", "confirming", "leading", "turning", "presenting", "parting", "going_home"]
)
def test_codes_are_obeyed_only_while_it_listens(state: State) -> None:
    run = Run(changed(stops=STOPS, accept=[TWO, HELLO])).started().until(state)
    entry = run.progress.entry
    for text in (TWO, HELLO, ONE):
        run.see(CodeRead(text), after_s=0.0)
    assert (run.progress.entry, run.progress.carried) == (entry, None)


def test_codes_are_looked_for_where_some_are_obeyed() -> None:
    def looks(tour: Tour) -> bool:
        run = Run(tour).started().until("listening")
        return CODES in [wish.cls for wish in perceptions(run.progress, run.scene)]

    assert looks(changed(stops=STOPS))
    assert looks(changed(accept=[HELLO]))
    assert not looks(LAB)


def code(text: str, away_m: float | None = 0.8) -> QRCode:
    return QRCode(text, np.zeros((4, 2), np.float32), None if away_m is None else (away_m, 0.0, 1.2))


def codes(stamp: float, *seen: QRCode) -> QRCodes:
    return QRCodes(stamp, "kinect", 640, 480, Pose3.identity(), seen)


def test_a_code_counts_once_while_it_is_shown_and_again_a_minute_after() -> None:
    shown = ShownCodes()
    assert shown.read(codes(0.0, code("b"), code("a", None)), "listening") == [CodeRead("a"), CodeRead("b")]
    for at in range(1, 100):
        assert shown.read(codes(at, code("a")), "listening") == []
    assert shown.read(codes(99 + CODE_AGAIN_S, code("a")), "listening") == []
    assert shown.read(codes(100 + 2 * CODE_AGAIN_S, code("a")), "listening") == [CodeRead("a")]


def test_what_hangs_on_its_way_or_far_away_is_not_shown_to_it() -> None:
    shown = ShownCodes()
    assert shown.read(codes(0.0, code("passed", 2.5)), "leading") == []
    for at in range(0, 200, 10):
        assert shown.read(codes(at, code("passed"), code("far", 1.6)), "listening") == []
    assert shown.read(codes(200.0, code("far", 0.9)), "listening") == [CodeRead("far")], "it was brought nearer"


def test_a_code_that_is_held_up_early_counts_once_it_listens() -> None:
    shown = ShownCodes()
    assert shown.read(codes(0.0, code("a")), "presenting") == []
    assert shown.read(codes(1.0, code("a")), "answering") == []
    assert shown.read(codes(2.0, code("a")), "listening") == [CodeRead("a")]


@pytest.mark.slow
@in_virtual_time
async def test_a_visitors_code_is_obeyed_and_a_strangers_is_not(tmp_path: Path) -> None:
    places = {"one": Pose2(2.0, 0.0), "two": Pose2(2.0, 4.0), "three": Pose2(6.0, 0.0), "dock": Pose2()}
    made = await asyncio.to_thread(LedLab, tmp_path, changed(stops=STOPS, accept=[TWO, HELLO]), places)
    made.visitors = [Visitor(1.5, 0.5)]
    async with made as led:
        led.start()
        await led.until("confirming")
        led.press("agree")
        await led.until("leading")
        led.show(code(TWO, 2.0))
        await led.live(0.4)
        assert led.progress.stop == "one", "a poster is passed"
        await led.until("listening")
        assert led.desired("FindQRCodes") is not None
        said = list(led.said)
        for text in STRANGERS:
            led.show(code(text))
            await led.live(0.4)
            assert (led.progress.state, led.progress.stop, led.said) == ("listening", "one", said)
        led.show(code(HELLO))
        await led.live(1.0)
        assert led.said == [*said, "Bonjour !"]
        assert led.progress.text == {"fr": "Bonjour !"}
        await led.live(4.0)
        assert (led.progress.state, led.progress.stop, led.progress.text) == ("listening", "one", {})
        led.show(code("HBBA:STOP/THREE/EN/THREE."))
        await led.until("leading", limit_s=1)
        assert led.progress.stop == "three"
        await led.until("parting")
        assert led.said[-2:] == ["THREE.", "This is three."]
