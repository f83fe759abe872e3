"""The Intention Workspace: edits, transactions, expiry, who is the strongest."""

from __future__ import annotations

import random
from itertools import count

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel

from app.attention.desires import DesireClass, DesireClasses, InvalidDesire, Source, UnknownDesireClass
from app.attention.ended_desires import KEPT_FOR_S
from app.attention.workspace import IntentionWorkspace, UnknownDesire, WorkspaceChange
from app.messages import Accomplished, Accomplishment


class Goal(BaseModel):
    x: float = 0.0


CLASSES = DesireClasses([DesireClass("GoTo", "Go to", "", Goal, achievement=True), DesireClass("SLAM", "SLAM", "")])
ME = Source("operator", "console")


class Setting:
    def __init__(self) -> None:
        self.now = 100.0
        self.changes: list[WorkspaceChange] = []
        numbers = count(1)
        self.workspace = IntentionWorkspace(CLASSES, lambda: self.now, new_id=lambda: f"d-{next(numbers)}")
        self.workspace.observe(self.changes.append)

    def add(self, cls: str = "GoTo", intensity: float = 4, **more: object) -> str:
        return self.workspace.add(cls, intensity=intensity, utility=1, source=ME, **more).id  # type: ignore[arg-type]

    def report(self, desire: str, outcome: Accomplished = "done", reason: str = "there") -> Accomplishment:
        report = Accomplishment(self.now, desire, "Drive", outcome, reason)
        self.workspace.accomplish(report)
        return report


def test_add_change_remove() -> None:
    s = Setting()
    added = s.workspace.add("GoTo", intensity=4, utility=2, source=ME, params={"x": 3}, security=True, ttl=5)
    assert (added.created, added.expires, added.params, added.security) == (100, 105, {"x": 3.0}, True)
    s.now = 101
    changed = s.workspace.change(added.id, intensity=5, params={"x": 7}, ttl=None)
    assert (changed.id, changed.created, changed.intensity, changed.utility) == (added.id, 100, 5, 2)
    assert (changed.params, changed.expires) == ({"x": 7.0}, None)
    assert s.workspace.get(added.id) is changed
    s.workspace.remove(added.id)
    assert s.workspace.desires() == ()
    assert [bool(c.added) for c in s.changes] == [True, False, False]
    assert s.changes[1].changed == ((added, changed),)
    assert [(r.desire, r.reason) for r in s.changes[2].removed] == [(changed, "withdrawn")]
    statistics = s.workspace.statistics()
    assert (statistics.added, statistics.changed, statistics.withdrawn, statistics.desires) == (1, 1, 1, 0)


def test_a_change_to_the_same_notifies_no_observer() -> None:
    s = Setting()
    desire = s.add()
    s.workspace.change(desire, intensity=4)
    assert len(s.changes) == 1


@pytest.mark.parametrize(
    ("arguments", "field"),
    [
        ({"intensity": 0}, "intensity"),
        ({"intensity": 9}, "intensity"),
        ({"utility": -1}, "utility"),
        ({"security": 1}, "security"),
        ({"params": {"y": 1}}, "params.y"),
        ({"ttl": 0}, "ttl"),
    ],
)
def test_what_is_wrong_is_refused_and_nothing_has_changed(arguments: dict[str, object], field: str) -> None:
    s = Setting()
    whole = {"intensity": 1, "utility": 1, "source": ME, **arguments}
    with pytest.raises(InvalidDesire) as caught:
        s.workspace.add("GoTo", **whole)  # type: ignore[arg-type]
    assert caught.value.field == field
    desire = s.add()
    before = s.workspace.desires()
    with pytest.raises(InvalidDesire):
        s.workspace.change(desire, **arguments)  # type: ignore[arg-type]
    assert s.workspace.desires() == before


def test_unknown_class_and_id() -> None:
    s = Setting()
    with pytest.raises(UnknownDesireClass):
        s.add("Fly")
    for call in (s.workspace.get, s.workspace.remove, s.workspace.change):
        with pytest.raises(UnknownDesire, match="'d-9'"):
            call("d-9")
    assert s.changes == []


def test_strongest_of_each_class_of_equals_the_newest() -> None:
    s = Setting()
    first, second = s.add(intensity=4), s.add(intensity=4)
    s.now += 1
    slam = s.add("SLAM", 1)
    assert {c: d.id for c, d in s.workspace.strongest().items()} == {"GoTo": second, "SLAM": slam}
    third = s.add(intensity=4)
    assert s.workspace.strongest()["GoTo"].id == third
    s.workspace.change(first, intensity=4.5)
    assert s.workspace.strongest()["GoTo"].id == first


def test_security_yields_to_none_but_the_louder() -> None:
    s = Setting()
    safe = s.add(security=True)
    s.now += 1
    s.add(intensity=4)
    assert s.workspace.strongest()["GoTo"].id == safe
    louder = s.add(intensity=5)
    assert s.workspace.strongest()["GoTo"].id == louder


def test_a_transaction_notifies_once_of_its_net_effect() -> None:
    s = Setting()
    kept = s.add()
    with s.workspace.transaction():
        passing = s.add("SLAM")
        s.workspace.change(kept, intensity=5)
        with s.workspace.transaction():
            s.workspace.change(kept, intensity=6)
        s.workspace.remove(passing)
        assert len(s.changes) == 1
    assert len(s.changes) == 2
    change = s.changes[1]
    assert (change.added, change.removed) == ((), ())
    assert [(b.intensity, a.intensity) for b, a in change.changed] == [(4, 6)]


def test_a_transaction_that_raises_is_rolled_back() -> None:
    s = Setting()
    kept = s.add()
    before = s.workspace.desires()

    def failing() -> None:
        with s.workspace.transaction():
            s.add("SLAM")
            s.workspace.remove(kept)
            s.add(intensity=99)

    with pytest.raises(InvalidDesire):
        failing()
    assert s.workspace.desires() == before
    assert len(s.changes) == 1


def test_an_inner_transaction_that_raises_leaves_the_outer_whole() -> None:
    s = Setting()

    def failing() -> None:
        with s.workspace.transaction():
            s.add()
            raise RuntimeError

    with s.workspace.transaction():
        s.add("SLAM")
        with pytest.raises(RuntimeError):
            failing()
    assert [d.cls for d in s.workspace.desires()] == ["SLAM"]
    assert [d.cls for d in s.changes[0].added] == ["SLAM"]


def test_expiry() -> None:
    s = Setting()
    assert s.workspace.next_expiry is None
    s.add()
    short, long = s.add(ttl=5), s.add(ttl=8)
    assert s.workspace.next_expiry == 105
    s.now = 104.9
    assert s.workspace.expire() == ()
    s.workspace.change(long, ttl=1)
    assert s.workspace.next_expiry == 105
    s.now = 107
    assert {d.id for d in s.workspace.expire()} == {short, long}
    assert [r.reason for r in s.changes[-1].removed] == ["expired", "expired"]
    assert s.workspace.statistics().expired == 2
    assert s.workspace.next_expiry is None


@pytest.mark.parametrize("outcome", ["done", "failed"])
def test_an_achievement_leaves_once_it_is_accomplished(outcome: Accomplished) -> None:
    s = Setting()
    desire = s.workspace.get(s.add())
    s.now = 101
    report = s.report(desire.id, outcome)
    change = s.changes[-1]
    assert [(r.desire, r.reason) for r in change.removed] == [(desire, outcome)]
    assert change.accomplished == ((desire, report),)
    assert getattr(s.workspace.statistics(), outcome) == 1
    (ended,) = s.workspace.ended(5)
    assert (ended.outcome, ended.behavior, ended.reason, ended.ended) == (outcome, "Drive", "there", 101)
    assert s.workspace.report(desire.id) == ended
    with pytest.raises(UnknownDesire):
        s.workspace.get(desire.id)
    assert s.workspace.accomplishments() == ()


def test_what_is_maintained_stays_and_keeps_its_report_until_its_parameters_change() -> None:
    s = Setting()
    classes = DesireClasses([DesireClass("Look", "Look", "", Goal)])
    s.workspace = IntentionWorkspace(classes, lambda: s.now)
    desire = s.add("Look", params={"x": 1})
    assert s.workspace.report(desire).outcome is None
    first, second = s.report(desire, "failed"), s.report(desire, "done")
    assert first != second
    assert s.workspace.accomplishments() == (second,)
    s.workspace.change(desire, intensity=2)
    assert (s.workspace.report(desire).outcome, s.workspace.report(desire).ended) == ("done", None)
    s.workspace.change(desire, params={"x": 2})
    assert s.workspace.report(desire).outcome is None
    s.report(desire)
    s.now = 102
    s.workspace.remove(desire)
    assert (s.workspace.report(desire).outcome, s.workspace.report(desire).ended) == ("done", 102)
    assert s.workspace.accomplishments() == ()
    assert s.workspace.statistics().withdrawn == 1


def test_what_became_of_a_desire_is_kept_for_a_while() -> None:
    s = Setting()
    withdrawn, expired = s.add(), s.add(ttl=1)
    s.workspace.remove(withdrawn)
    s.now = 102
    s.workspace.expire()
    assert [s.workspace.report(each).outcome for each in (withdrawn, expired)] == ["withdrawn", "expired"]
    assert [each.id for each in s.workspace.ended(5)] == [expired, withdrawn]
    s.now = 100 + KEPT_FOR_S
    with pytest.raises(UnknownDesire, match=repr(withdrawn)):
        s.workspace.report(withdrawn)
    assert s.workspace.report(expired).ended == 102
    s.workspace.clear_ended()
    with pytest.raises(UnknownDesire):
        s.workspace.report(expired)


def test_a_report_on_a_desire_that_has_left_is_void() -> None:
    s = Setting()
    desire = s.add()
    s.workspace.remove(desire)
    changes = len(s.changes)
    s.report(desire)
    assert s.workspace.report(desire).outcome == "withdrawn"
    assert len(s.changes) == changes


def test_a_report_in_a_transaction_that_raises_is_rolled_back() -> None:
    s = Setting()
    goal, slam = s.add(), s.add("SLAM")

    def failing() -> None:
        with s.workspace.transaction():
            s.report(goal)
            s.report(slam)
            raise RuntimeError

    with pytest.raises(RuntimeError):
        failing()
    assert [d.id for d in s.workspace.desires()] == [goal, slam]
    assert s.workspace.report(goal).outcome is None
    assert s.workspace.accomplishments() == ()


def test_a_desire_that_came_and_was_accomplished_in_one_transaction_leaves_no_trace() -> None:
    s = Setting()
    with s.workspace.transaction():
        s.report(s.add())
    assert s.changes == []
    assert (s.workspace.accomplishments(), s.workspace.ended(5)) == ((), ())


def test_observers_may_edit_and_may_end() -> None:
    s = Setting()
    seen: list[int] = []

    def answer(change: WorkspaceChange) -> None:
        seen.append(len(s.workspace.desires()))
        if len(s.workspace.desires()) < 3:
            s.add("SLAM")

    end = s.workspace.observe(answer)
    s.add()
    assert seen == [1, 2, 3]
    assert [len(c.added) for c in s.changes] == [1, 1, 1]
    end()
    end()
    s.add()
    assert seen == [1, 2, 3]


def test_an_observer_that_fails_disturbs_no_other(caplog: pytest.LogCaptureFixture) -> None:
    s = Setting()

    def fail(change: WorkspaceChange) -> None:
        raise ZeroDivisionError

    s.workspace.observe(fail)
    later: list[WorkspaceChange] = []
    s.workspace.observe(later.append)
    s.add()
    s.add()
    assert len(later) == 2
    assert len(s.workspace.desires()) == 2
    assert caplog.text.count("an observer of the Intention Workspace failed and goes on") == 2


def test_ids_are_never_used_twice() -> None:
    workspace = IntentionWorkspace(CLASSES, lambda: 0.0)
    ids = {workspace.add("SLAM", intensity=1, utility=1, source=ME).id for _ in range(200)}
    assert len(ids) == 200
    doubled = iter(["d-1", "d-1", "d-2"])
    stubborn = IntentionWorkspace(CLASSES, lambda: 0.0, new_id=lambda: next(doubled))
    assert [stubborn.add("SLAM", intensity=1, utility=1, source=ME).id for _ in range(2)] == ["d-1", "d-2"]


@given(st.integers(0, 2**32))
def test_an_observer_can_rebuild_the_workspace_from_its_news(seed: int) -> None:
    s = Setting()
    mirror: dict[str, object] = {}

    def follow(change: WorkspaceChange) -> None:
        for removal in change.removed:
            assert mirror.pop(removal.desire.id) == removal.desire
            ended = s.workspace.report(removal.desire.id)
            assert ended.ended == s.now
            # What a behavior reported of one that stayed outlasts its end.
            assert ended.outcome == removal.reason or ended.behavior
        for before, after in change.changed:
            assert mirror[before.id] == before
            mirror[after.id] = after
        for desire in change.added:
            assert desire.id not in mirror
            mirror[desire.id] = desire

    s.workspace.observe(follow)
    rng = random.Random(seed)
    for _ in range(30):
        try:
            with s.workspace.transaction():
                for _ in range(rng.randrange(1, 4)):
                    ids = [d.id for d in s.workspace.desires()]
                    if not ids or rng.random() < 0.5:
                        s.add(rng.choice(["GoTo", "SLAM"]), rng.choice([1, 2, 3]), ttl=rng.choice([None, 3, 9]))
                    elif rng.random() < 0.3:
                        s.workspace.remove(rng.choice(ids))
                    elif rng.random() < 0.5:
                        s.report(rng.choice(ids), rng.choice(["done", "failed"]))
                    else:
                        s.workspace.change(rng.choice(ids), intensity=rng.choice([0, 4, 5]))
        except InvalidDesire:
            pass
        s.now += rng.random()
        s.workspace.expire()
        assert mirror == {d.id: d for d in s.workspace.desires()}
        assert {report.desire_id for report in s.workspace.accomplishments()} <= mirror.keys()
