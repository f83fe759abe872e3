"""A run that is kept, and gone on with by a program that was started again."""

from __future__ import annotations

from dataclasses import replace

import pytest

from app.modules.motivations.tour_guide.kept import KeptRun, after_restart, kept_bytes, read_kept
from app.modules.motivations.tour_guide.progress import Progress, Scheduled, State, View
from app.modules.motivations.tour_guide.transitions import advance
from app.modules.motivations.tour_guide.wishes import wishes
from app.tours.tour_file import digest
from tests.modules.motivations.tour_guide.run import LAB, Run

AT = 1_795_000_000.0
SEEN = View(5.0, people=2, farthest_m=1.0, near=2)


def kept(run: Run) -> KeptRun:
    """What is read of ``run`` after it was kept."""
    found = read_kept(kept_bytes(KeptRun(digest(LAB), AT, run.progress)))
    assert found is not None
    assert found.progress == run.progress
    return found


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("leading", "leading"),
        ("waiting", "leading"),
        ("presenting", "presenting"),
        ("listening", "listening"),
        ("going_home", "going_home"),
        ("parting", "parting"),
    ],
)
def test_it_goes_on_where_it_was(before: State, after: State) -> None:
    run = Run().started().until("leading")
    run = run.see(farthest_m=6.0) if before == "waiting" else run.until(before)
    again = after_restart(kept(run), AT + 60, SEEN, run.scene)
    assert (again.state, again.stop, again.step) == (after, run.progress.stop, run.progress.step)
    assert again.since == SEEN.now
    texts = [wish.params["text"] for wish in wishes(again, run.scene, SEEN.now) if wish.cls == "Say"]
    assert ("I was interrupted. Let us go on." in texts) is (after not in ("going_home", "parting"))


def test_it_says_why_it_does_not_go_on_and_goes_home() -> None:
    run = Run().started().until("presenting")
    found = kept(run)
    for changed, at, view, reason in (
        (replace(found, digest="x"), AT, SEEN, "the tour was changed meanwhile"),
        (found, AT + 601, SEEN, "the program was away too long"),
        (found, AT - 1, SEEN, "the program was away too long"),
        (found, AT, replace(SEEN, people=0), "no visitor was there when the program was back"),
    ):
        again = after_restart(changed, at, view, run.scene)
        assert (again.state, again.reason) == ("going_home", reason)
        texts = [wish.params["text"] for wish in wishes(again, run.scene, view.now) if wish.cls == "Say"]
        assert texts == ["I was interrupted, and must end the tour here."]


def test_a_pause_stays_one_until_a_press() -> None:
    run = Run().started().until("leading").see(e_stop=True)
    again = after_restart(kept(run), AT + 5000, replace(SEEN, people=0), run.scene)
    assert (again.state, again.to_press, again.resume) == ("paused", True, "leading")


def test_what_the_emergency_stop_holds_is_held_after_a_restart() -> None:
    run = Run().see(people=0, near=0, e_stop=True).see(e_stop=False)
    for found in (
        kept(run),
        replace(kept(run), digest="x"),
        replace(kept(run), progress=replace(run.progress, stop=9)),
    ):
        again = after_restart(found, AT + 5000, SEEN, run.scene)
        assert (again.state, again.held) == ("idle", True)
        scheduled = advance(again, replace(SEEN, events=(Scheduled(),)), run.scene)
        assert (scheduled.state, scheduled.reason) == ("idle", "the emergency stop was pressed: press Resume")


def test_what_is_not_of_this_tour_is_forgotten() -> None:
    run = Run().started().until("presenting")
    for wrong in (replace(run.progress, stop=9), replace(run.progress, question=3), Progress()):
        again = after_restart(KeptRun(digest(LAB), AT, wrong), AT, SEEN, run.scene)
        assert not again.is_running
    assert [read_kept(data) for data in (b"", b"{}", b"[1]", b"\xff")] == [None] * 4
