"""What becomes of a stop: not reached, presented from beside its place, a step that fails, a poster that is gone."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from app.maps.poster_places import Poster
from app.modules.motivations.tour_guide.progress import Failure, State
from tests.modules.motivations.tour_guide.run import Run, changed, say, stop


@pytest.mark.parametrize(
    ("then", "state", "stop_id"),
    [("skip", "leading", "two"), ("present_from_here", "presenting", "one"), ("end", "parting", "one")],
)
def test_a_stop_that_cannot_be_reached(then: str, state: State, stop_id: str) -> None:
    run = Run(changed(on_failure={"reach": {"retry": 1, "ask_s": 20, "then": then}})).started().until("leading")
    first = run.wish("GoTo").key
    assert run.done("GoTo", done=False).wish("GoTo").key != first, "tried again"
    assert run.done("GoTo", done=False).progress.state == "blocked"
    assert run.texts() == ["Excuse me, may I pass?"]
    assert run.see(after_s=19).progress.state == "blocked"
    assert run.see(after_s=2).progress.state == state
    assert run.scene.tour.stops[run.progress.stop].id == stop_id
    assert run.progress.failures == (Failure("one", "not reached"),)


def test_a_wait_for_visitors_is_no_new_try() -> None:
    run = Run(changed(on_failure={"reach": {"retry": 1}})).started().until("leading").done("GoTo", done=False)
    assert run.see(farthest_m=4.5).progress.state == "waiting"
    assert run.see(farthest_m=1.0).progress.state == "leading"
    assert run.done("GoTo", done=False).progress.state == "blocked"
    again = Run(changed(on_failure={"reach": {"retry": 1}})).started().until("leading").done("GoTo", done=False)
    again.see(farthest_m=4.5).press("skip").see(farthest_m=1.0)
    assert again.done("GoTo", done=False).progress.state == "leading", "the next stop has tries of its own"


def test_the_operator_is_asked_before_a_stop_is_given_up() -> None:
    run = Run(changed(on_failure={"reach": {"retry": 0}})).started().until("leading").done("GoTo", done=False)
    assert run.press("retry").progress.state == "leading"
    run.done("GoTo", done=False).press("skip")
    assert run.wish("GoTo").params["place"] == "two"
    unasked = changed(on_failure={"reach": {"retry": 0, "ask_s": 0}})
    run = Run(unasked).started().until("leading").done("GoTo", done=False)
    assert run.wish("GoTo").params["place"] == "two"


@pytest.mark.parametrize(("then", "state"), [("continue", "turning"), ("skip", "leading"), ("end", "parting")])
def test_a_step_that_fails(then: str, state: State) -> None:
    stops = [stop("one", do=[say("First."), say("Second.")]), stop("two")]
    run = Run(changed(stops=stops, on_failure={"present": {"retry": 1, "then": then}})).started().until("presenting")
    run.done("Say", done=False)
    assert run.texts() == ["First."], "tried again"
    run.done("Say", done=False)
    assert run.progress.failures == (Failure("one", "a text was not said"),)
    if then == "continue":
        assert run.see().texts() == ["Second."]
    else:
        assert run.progress.state == state


def test_a_step_that_reports_nothing_fails_in_the_end() -> None:
    run = Run().started().until("presenting").see(after_s=181)
    assert run.progress.failures == (Failure("one", "a text was not said"),)


def test_a_place_that_is_gone_is_passed_over_and_noted() -> None:
    run = Run(missing="one").started().until("leading")
    assert run.wish("GoTo").params["place"] == "two"
    assert run.progress.failures == (Failure("one", "there is no place one"),)
    run = Run(missing="dock").started().until("idle")
    assert run.progress.reason == "there is no place dock"


def test_a_stop_that_is_presented_from_beside_its_place_is_noted() -> None:
    run = Run().started().until("leading").see(X_MB=(1.3, 2.2, 0.0)).until("presenting")
    assert run.progress.failures == (Failure("one", "presented 0.36 m from its place"),)
    run = Run().started().until("leading").see(X_MB=(1.3, 2.1, 0.0)).until("presenting")
    assert run.progress.failures == (), "a pose is corrected by some centimetres"


@pytest.mark.parametrize(
    ("face", "turned", "noted"),
    [("place", 0.5, "presented turned 29° from its place"), ("place", 0.22, ""), ("visitors", 3.0, "")],
)
def test_a_stop_that_is_presented_turned_away_is_noted(face: str, turned: float, noted: str) -> None:
    run = Run(changed(stops=[stop("one", stand={"face": face})]))
    run.scene = replace(run.scene, places={"one": {"x": 1.0, "y": 2.0, "heading": 3.0}})
    run.started().until("leading").see(X_MB=(1.0, 2.0, 3.0 + turned - math.tau)).until("presenting")
    assert [failure.what for failure in run.progress.failures] == [noted] * bool(noted)


@pytest.mark.parametrize(
    ("stand", "posters", "heading"),
    [
        ("poster", [Poster(1, "P", 1.0, 4.0, None), Poster(2, "P", 9.0, 2.0, None)], 1.57),
        ("poster", [Poster(1, "other", 1.0, 4.0, None)], 0.5),
        ("place", [Poster(1, "P", 1.0, 4.0, None)], 0.5),
    ],
)
def test_it_stands_turned_to_the_poster_where_the_map_knows_that(
    stand: str, posters: list[Poster], heading: float
) -> None:
    run = Run(changed(stops=[stop("one", poster="P", stand={"face": stand})]))
    run.scene = replace(run.scene, places={"one": {"x": 1.0, "y": 2.0, "heading": 0.5}}, posters=tuple(posters))
    assert run.started().until("leading").wish("GoTo").params["heading"] == heading
    run.see(X_MB=(1.0, 2.0, heading)).until("presenting")
    assert (run.progress.failures, "turning" in run.states) == ((), False)
    turned = Run(run.scene.tour)
    turned.scene = run.scene
    turned.started().until("leading").see(X_MB=(1.0, 2.0, heading + 1.0)).until("presenting")
    assert [failure.what for failure in turned.progress.failures] == ["presented turned 57° from its place"]


def test_what_is_left_out_is_passed_over() -> None:
    run = Run(changed(stops=[stop("one", left_out=True), stop("two")])).started().until("idle")
    assert run.progress.presented == ("two",)


@pytest.mark.parametrize(
    ("then", "text"),
    [
        ("skip", "I cannot get there, so I leave it out."),
        ("present_from_here", "I cannot get any nearer, so I explain it from here."),
        ("end", "I cannot get any further. I must end the tour here."),
    ],
)
def test_a_stop_that_is_given_up_is_said(then: str, text: str) -> None:
    run = Run(changed(on_failure={"reach": {"retry": 0, "ask_s": 0, "then": then}})).started().until("leading")
    assert run.done("GoTo", done=False).texts()[0] == text
    after = run.done("Say", done=False, only="excuse-" + run.progress.excuse)
    assert after.progress.failures == (Failure("one", "not reached"),), "no step fails where nothing can be said"


def test_what_is_doubtful_about_a_place_is_noted_and_the_stop_presented() -> None:
    run = Run()
    run.scene = replace(run.scene, doubts={"one": "its poster is gone"})
    assert run.started().until("idle").progress.presented == ("one", "two")
    assert run.progress.failures == (Failure("one", "its poster is gone"),)


@pytest.mark.parametrize("face", ["visitors", "place"])
@pytest.mark.parametrize(
    ("doubt", "excuses"),
    [
        ("its poster is not known on this map: it was removed, or not seen yet", True),
        ("its poster hangs 2.1 m from where it was: place it again", True),
        ("it is in an obstacle of the map", False),
    ],
)
def test_a_poster_that_is_gone_is_said_as_it_arrives(doubt: str, excuses: bool, face: str) -> None:
    run = Run(changed(stops=[stop("one", stand={"face": face}), stop("two")]))
    run.scene = replace(run.scene, doubts={"one": doubt})
    said = ["Excuse me, the poster is not where I knew it."] * excuses
    assert run.started().until("presenting").texts() == [*said, "This is one."]
    if excuses:
        run.done("Say", done=False, only="excuse-poster")
        assert run.progress.failures == (Failure("one", doubt),), "no step fails where nothing can be said"
    assert run.press("repeat").texts() == ["This is one."], "said once"
    assert run.until("leading").until("presenting").texts() == ["This is two."]
    assert Run().started().until("presenting").texts() == ["This is one."]


def test_that_a_poster_is_gone_is_said_in_the_tours_language() -> None:
    run = Run()
    run.scene = replace(run.scene, language="fr", doubts={"one": "its poster is gone"})
    assert run.started().until("presenting").texts()[0] == "Excusez-moi, l'affiche n'est pas là où je la connaissais."
