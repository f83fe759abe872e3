from __future__ import annotations

from app.modules.actuation.arbitration import Contender
from app.modules.actuation.voice_arbitration import VoiceArbiter

CONTENDERS = (
    Contender(input="say", behavior="Say", priority=1),
    Contender(input="voice", behavior="Operator", priority=2),
)


def test_one_alone_is_heard_until_its_pause() -> None:
    arbiter = VoiceArbiter(CONTENDERS, 0.3)
    assert arbiter.speaker(10.0) is None
    assert arbiter.admit("say", 10.0)
    assert arbiter.speaker(10.29) == "Say"
    assert arbiter.speaker(10.31) is None


def test_the_higher_priority_is_heard_alone() -> None:
    arbiter = VoiceArbiter(CONTENDERS, 0.3)
    assert arbiter.admit("say", 10.0)
    assert arbiter.admit("voice", 10.02)
    assert not arbiter.admit("say", 10.04)
    assert arbiter.speaker(10.3) == "Operator"
    assert arbiter.admit("say", 10.4)


def test_among_equals_the_first_is_heard() -> None:
    arbiter = VoiceArbiter(
        (Contender(input="a", behavior="A", priority=1), Contender(input="b", behavior="B", priority=1)), 0.3
    )
    assert arbiter.admit("b", 10.0)
    assert arbiter.admit("a", 10.1)
    assert not arbiter.admit("b", 10.1)
