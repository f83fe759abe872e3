"""Desired, intended, exploited: since when, and for how long in vain; perceptions by their activity."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from app.attention.activity import PATIENCE_S, PERIODS, ActivityMonitor, watched
from app.attention.desire_progress import ProgressLog, idle_time_s
from app.attention.desires import Desire, Source
from app.attention.strategies import CLOSED, Strategy
from app.messages import DesireProgress


def desire(number: int) -> Desire:
    source = Source("operator", "ann")
    return Desire(f"d-{number}", "SLAM", 4.0, utility=1.0, security=False, params={}, source=source, created=0.0)


def strategy(name: str, cls: str, **filters: float) -> Strategy:
    return Strategy(name, cls, 1.0, filters={key.replace("__", "."): phi for key, phi in filters.items()})


SEE = strategy("see", "LocateFaces", FaceDetector__images=2, FaceDetector__panorama=CLOSED)
HEAR = strategy("hear", "DetectNoises", LoudNoiseDetector__audio=1)
GO = strategy("go", "GoTo", Plan__scans=1, Plan__twist=1)


def test_what_arbiters_report_on_is_not_judged_by_its_activity() -> None:
    assert watched((SEE, HEAR, GO), {"Plan.twist"}) == {
        "LocateFaces": {"FaceDetector.images"},
        "DetectNoises": {"LoudNoiseDetector.audio"},
    }


def test_a_perception_is_exploited_while_it_takes_messages() -> None:
    monitor = ActivityMonitor()
    filters = watched((SEE,), ())

    def sample(now: float, count: int, period_s: float = 0.0) -> list[tuple[bool, str, str]]:
        changes = monitor.sample(now, filters, {"FaceDetector.images": count}, {"FaceDetector.images": period_s})
        return [(change.exploited, change.behavior, cls) for change, cls in changes]

    assert sample(0.0, 40) == [], "what it took before is of then"
    assert sample(1.0, 41) == [(True, "FaceDetector", "LocateFaces")]
    assert monitor.classes == {"LocateFaces"}
    assert sample(1.0 + PATIENCE_S, 41) == []
    assert sample(1.1 + PATIENCE_S, 41) == [(False, "FaceDetector", "LocateFaces")]
    assert sample(10.0, 42, period_s=4.0) == [(True, "FaceDetector", "LocateFaces")]
    assert sample(10.0 + 4.0 * PERIODS, 42, period_s=4.0) == [], "it gets one picture in four seconds"
    changes = monitor.sample(30.0, {}, {}, {})
    assert [change.exploited for change, _ in changes] == [False], "attention selected something else"
    assert monitor.sample(31.0, filters, {"FaceDetector.images": 50}, {}) == ()


def test_each_desire_has_the_times_of_its_states() -> None:
    log = ProgressLog(idle_after_s=10)
    one, two = desire(1), desire(2)
    assert log.update(0.0, [one], (), ()) == ()
    assert log.progress == (DesireProgress("d-1", intended=False, exploited=False),)
    log.update(1.0, [one, two], ["d-1"], ())
    log.update(3.0, [one, two], ["d-1"], ["d-1"])
    log.update(4.0, [one, two], ["d-1"], ["d-1"])
    assert log.progress[0] == DesireProgress(
        "d-1", intended=True, exploited=True, intended_since=1.0, exploited_since=3.0
    )
    log.update(6.0, [one], ["d-1"], ())
    assert idle_time_s(log.progress[0], 8.0) == 2.0
    assert len(log.progress) == 1, "one has left"
    assert log.update(15.9, [one], ["d-1"], ()) == ()
    (waiting,) = log.update(16.0, [one], ["d-1"], ())
    assert (waiting.desire, waiting.idle_s) == (one, 10.0)
    assert log.update(40.0, [one], ["d-1"], ()) == (), "that is said once"
    log.update(41.0, [one], ["d-1"], ["d-1"])
    log.update(42.0, [one], ["d-1"], ())
    assert len(log.update(52.0, [one], ["d-1"], ())) == 1, "and again after the next time"


STEP = st.tuples(st.floats(0.1, 5), st.sets(st.sampled_from("abc")), st.sets(st.sampled_from("abc")))


@given(st.lists(STEP, max_size=15))
def test_the_time_in_vain_is_that_since_the_last_change_for_the_worse(
    steps: list[tuple[float, set[str], set[str]]],
) -> None:
    log, now, since = ProgressLog(1e9), 0.0, dict.fromkeys("abc", 0.0)
    desires = [desire(number) for number in range(3)]
    ids = dict(zip("abc", (each.id for each in desires), strict=True))
    in_vain = dict.fromkeys("abc", False)
    for passed, intended, exploited in steps:
        now += passed
        log.update(now, desires, {ids[each] for each in intended}, {ids[each] for each in exploited})
        for each, progress in zip("abc", log.progress, strict=True):
            is_in_vain = each in intended and each not in exploited
            if is_in_vain and not in_vain[each]:
                since[each] = now
            in_vain[each] = is_in_vain
            assert idle_time_s(progress, now) == (now - since[each] if is_in_vain else None)
