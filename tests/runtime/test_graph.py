from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import pytest

from app.messages import Message, Odometry, Twist
from app.runtime.channel_table import ChannelSpec
from app.runtime.filter import CLOSED
from app.runtime.filter_bank import Pin
from app.runtime.graph import WiringError, load_class
from app.runtime.module import Module, ModuleContext
from tests.runtime.wired import WIRED, Build, Relay, Source, SourceSettings, Wheels, refused


class Sleeper(Module):
    """Needs its odometry only at work."""

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.numbers = self.input("numbers", Twist, capacity=3, rests=True)
        self.relayed = self.output("relayed", Twist)


class OdometryUser(Module):
    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.odometry = self.input("odometry", Odometry)


class Onlooker(Module):
    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.numbers = self.input("numbers", Twist, wants="never")


class Collector(Module):
    """Takes whatever there is."""

    @classmethod
    def default_inputs(cls, channels: Mapping[str, ChannelSpec]) -> Mapping[str, str]:
        return {f"of_{name}": name for name, spec in channels.items() if spec.log == "always"}

    def accept(self, name: str, message_type: type[Message]) -> None:
        self.input(name, message_type)


class NeedsDict(Module):
    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.found = self.service(dict)


NotAModule = dict


def test_a_wired_graph_delivers_from_output_to_input(build: Build, make: Callable[..., Twist]) -> None:
    graph = build(
        {"A": (Source, {}, {"numbers": "n"}), "B": (Relay, {"numbers": "n"}, {"relayed": "r"})}, {"n": {}, "r": {}}
    )
    graph.modules["A"].module.numbers.publish(make(1))  # type: ignore[attr-defined]
    assert graph.modules["B"].module.numbers.subscription.receive_nowait() == make(1)  # type: ignore[attr-defined]
    assert graph.producers == {"n": "A.numbers", "r": "B.relayed"}
    assert set(graph.filters.names()) == {"A.numbers", "B.numbers", "B.relayed"}
    assert graph.ports() == {"A": {"numbers"}, "B": {"numbers", "relayed"}}
    assert graph.modules["A"].title == "Counts"
    assert graph.modules["B"].title == "B"


def test_an_input_that_never_wants_keeps_no_source_awake_but_wants_what_comes_from_outside(
    build: Build, make: Callable[..., Twist]
) -> None:
    graph = build(
        {
            "A": (Source, {}, {"numbers": "n"}),
            "B": (Onlooker, {"numbers": "n"}, {}),
            "C": (Onlooker, {"numbers": "outside"}, {}),
        },
        {"n": {}, "outside": {"external": True}},
    )
    source = graph.modules["A"].module
    assert not source.numbers.wanted  # type: ignore[attr-defined]
    source.numbers.publish(make(1))  # type: ignore[attr-defined]
    assert graph.modules["B"].module.numbers.subscription.receive_nowait() == make(1)  # type: ignore[attr-defined]
    assert graph.channel("outside").wanted, "a log feeds only what is wanted"


def test_an_unknown_port_is_named_with_those_there_are(build: Build) -> None:
    said = refused(build, {"A": (Source, {}, {"sums": "n"})}, {"n": {}})
    assert said == "modules.A.outputs.sums: no output 'sums'; there are: numbers"
    said = refused(build, {"A": (Source, {"in": "n"}, {})}, {"n": {}})
    assert said == "modules.A.inputs.in: no input 'in'; there are: none"


def test_an_unknown_channel_is_named(build: Build) -> None:
    assert "no channel 'm'; there are: n" in refused(build, {"A": (Source, {}, {"numbers": "m"})}, {"n": {}})
    assert "no channel 'm'; there are: n" in refused(build, {"B": (Relay, {"numbers": "m"}, {})}, {"n": {}})


def test_a_type_mismatch_names_both_types(build: Build) -> None:
    modules: dict[str, Any] = {"A": (Source, {}, {"numbers": "n"}), "O": (OdometryUser, {"odometry": "n"}, {})}
    assert refused(build, modules, {"n": {}}) == (
        "modules.O.inputs.odometry: channel n carries Twist, the port wants Odometry"
    )


def test_two_producers_of_one_channel_are_refused(build: Build) -> None:
    modules: dict[str, Any] = {"A": (Source, {}, {"numbers": "n"}), "B": (Source, {}, {"numbers": "n"})}
    assert "channel n already has a producer, A.numbers" in refused(build, modules, {"n": {}})


def test_a_channel_without_producer_is_refused_unless_it_is_external(build: Build) -> None:
    modules: dict[str, Any] = {"B": (Relay, {"numbers": "n"}, {})}
    assert "no module publishes on channel n" in refused(build, modules, {"n": {}})
    assert build(modules, {"n": {"external": True}}).producers == {}


def test_a_cycle_is_refused_with_its_path_and_allowed_through_a_feedback_channel(build: Build) -> None:
    modules: dict[str, Any] = {
        "A": (Relay, {"numbers": "ba"}, {"relayed": "ab"}),
        "B": (Relay, {"numbers": "ab"}, {"relayed": "ba"}),
    }
    said = refused(build, modules, {"ab": {}, "ba": {}})
    assert "A -> B -> A" in said
    assert "feedback: true" in said
    assert build(modules, {"ab": {}, "ba": {"feedback": True}}).producers["ba"] == "B.relayed"


def test_outputs_that_can_move_the_body_are_known_by_what_they_lead_to(build: Build) -> None:
    modules: dict[str, Any] = {
        "A": (Source, {}, {"numbers": "n"}),
        "B": (Relay, {"numbers": "n"}, {"relayed": "r"}),
        "W": (Wheels, {"driven": "r", "pushed": "hand", "brake": "n"}, {}),
    }
    graph = build(modules, {"n": {}, "r": {}, "hand": {"external": True}})
    assert graph.moving() == {"B.relayed": "W.driven"}
    assert build(*WIRED).moving() == {}


def test_a_module_refuses_a_wiring_that_must_not_run(build: Build) -> None:
    said = refused(build, {"W": (Wheels, {"driven": "hand"}, {})}, {"hand": {"external": True}})
    assert said == "modules.W.inputs: wheels need a brake"


def test_a_module_may_not_feed_itself(build: Build) -> None:
    assert "A -> A" in refused(build, {"A": (Relay, {"numbers": "n"}, {"relayed": "n"})}, {"n": {}})


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"period_s": -1}, "settings.period_s: should be greater than 0, not -1"),
        ({"perod_s": 1}, "settings.perod_s: unknown key; did you mean 'period_s'? allowed: period_s"),
    ],
)
def test_bad_settings_name_the_key(build: Build, settings: dict[str, Any], said: str) -> None:
    assert said in refused(build, {"A": (Source, {}, {"numbers": "n"}, {"settings": settings})}, {"n": {}})


def test_a_module_finds_its_own_settings(build: Build) -> None:
    graph = build({"A": (Source, {}, {"numbers": "n"}, {"settings": {"period_s": 2}})}, {"n": {}})
    assert graph.modules["A"].module.settings == SourceSettings(period_s=2)


@pytest.mark.parametrize(
    "path",
    ["app.nowhere:Thing", "app.runtime.module:No", "app.runtime.module", ":Thing", ".x:Y", "", "a b:C", "json:loads"],
)
def test_a_path_that_is_no_module_class_is_refused(build: Build, path: str) -> None:
    assert f"{path!r} is not a module class" in refused(build, {"A": (path, {}, {})}, {})


@pytest.mark.parametrize(
    ("path", "why"),
    [
        ("hbba_absent.a:A", "no package 'hbba_absent' is installed here"),
        ("app.runtme.module:Module", "app has no module 'runtme'; did you mean 'runtime'?"),
        ("app.runtime.modul:Module", "app.runtime has no module 'modul'; did you mean 'module'?"),
        ("app.runtime.module.x:Module", "app.runtime.module has no module 'x'"),
        ("app.runtime.module:Modul", "app.runtime.module has no class 'Modul'; did you mean 'Module'?"),
        ("app.runtime.module:Xyzzy", "app.runtime.module has no class 'Xyzzy'"),
        ("__main__:Xyzzy", "__main__ has no class 'Xyzzy'"),
    ],
)
def test_what_is_absent_of_a_path_is_named(build: Build, path: str, why: str) -> None:
    said = refused(build, {"A": (path, {}, {})}, {})
    assert said == f"modules.A.class: {path!r} is not a module class (package.module:Class): {why}"


def test_a_broken_import_inside_a_module_file_is_one_sentence(
    build: Build, tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "hbba_broken_module.py").write_text("import hbba_broken\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    said = refused(build, {"A": ("hbba_broken_module:Thing", {}, {})}, {})
    file = tmp_path / "hbba_broken_module.py"
    assert said == (
        f"modules.A.class: hbba_broken_module cannot be imported: {file}:1: ModuleNotFoundError: No module named "
        "'hbba_broken'"
    )


def test_a_class_that_is_no_module_is_refused(build: Build) -> None:
    assert load_class(f"{__name__}:NotAModule") is None


def test_a_missing_service_is_a_wiring_error(build: Build) -> None:
    said = refused(build, {"N": (NeedsDict, {}, {})}, {})
    assert said == "modules.N: N needs a dict, which this robot does not have"
    assert build({"N": (NeedsDict, {}, {})}, {}, services={dict: {}}).modules["N"].module.found == {}  # type: ignore[attr-defined]


@pytest.mark.parametrize("message_type", ["Nothing", "Pose2", "Message", "np", "read_only"])
def test_a_channel_of_an_unknown_message_type_is_refused(build: Build, message_type: str) -> None:
    said = refused(build, {}, {"n": {"type": message_type}})
    assert said == (
        f"channels.n.type: there is no message type {message_type!r}; allowed: a class of app.messages, or "
        "package.module:Class, a dataclass with a stamp"
    )


def test_attended_filters_begin_closed_and_all_others_open(build: Build) -> None:
    graph = build(*WIRED, attended=("A.numbers", "B.numbers"))
    assert graph.filters.divisors() == {"A.numbers": CLOSED, "B.numbers": CLOSED, "B.safety": 1, "B.relayed": 1}


def test_what_attention_may_not_touch_is_refused(build: Build) -> None:
    assert "B.inputs.safety: this input must stay open" in refused(build, *WIRED, attended=("B.safety",))


def test_filters_of_what_may_not_be_decimated_open_and_close(build: Build) -> None:
    modules, channels = WIRED
    graph = build(modules, {**channels, "n": {"decimable": False}}, attended=("B.numbers",))
    assert graph.filters.undivided() == {"A.numbers", "B.numbers", "B.safety"}
    assert graph.filters.divisors()["B.numbers"] == CLOSED


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("C.numbers", "no module 'C'; there are: A, B"),
        ("B.nothing", "no connected port 'nothing'; there are: numbers, relayed, safety"),
        ("B", "no connected port ''; there are: numbers, relayed, safety"),
    ],
)
def test_attending_what_does_not_exist_is_refused(build: Build, name: str, said: str) -> None:
    assert said in refused(build, *WIRED, attended=(name,))


def test_an_input_rests_while_attention_has_closed_its_module(build: Build, make: Callable[..., Twist]) -> None:
    wired = ({"A": (Source, {}, {"numbers": "n"}), "B": (Sleeper, {"numbers": "n"}, {"relayed": "r"})},)
    graph = build(*wired, {"n": {}, "r": {}}, attended=("B.relayed",))
    publish = graph.channels["n"].publish
    inbox = graph.modules["B"].context.inputs["numbers"].subscription
    for value in range(5):
        publish(make(value))
    assert not inbox.waiting
    graph.filters.apply({"B.relayed": 2})
    assert inbox.waiting
    assert [inbox.receive_nowait().linear_mps for _ in range(3)] == [2, 3, 4]
    graph.filters.apply({"B.relayed": CLOSED})
    publish(make(5))
    assert not inbox.waiting


def test_no_input_rests_in_a_module_that_no_strategy_names(build: Build, make: Callable[..., Twist]) -> None:
    modules = {"A": (Source, {}, {"numbers": "n"}), "B": (Sleeper, {"numbers": "n"}, {"relayed": "r"})}
    graph = build(modules, {"n": {}, "r": {}}, attended=("A.numbers",))
    graph.channels["n"].publish(make(1))
    assert graph.modules["B"].context.inputs["numbers"].subscription.waiting


def test_attending_an_input_that_is_not_wired_is_refused(build: Build) -> None:
    modules = {"A": (Source, {}, {"numbers": "n"}), "B": (Relay, {"safety": "n"}, {})}
    assert "no connected port 'numbers'" in refused(build, modules, {"n": {}}, attended=("B.numbers",))


def test_a_refused_attendance_changes_nothing(build: Build) -> None:
    graph = build(*WIRED)
    with pytest.raises(WiringError):
        graph.attend(("A.numbers", "B.safety"))
    assert set(graph.filters.divisors().values()) == {1}


def test_channels_are_found_by_name(build: Build) -> None:
    graph = build(*WIRED)
    assert graph.channel("n") is graph.channels["n"]
    with pytest.raises(KeyError, match="no channel 'm'; there are: n, r"):
        graph.channel("m")


def test_a_module_that_names_no_inputs_may_choose_its_own(build: Build) -> None:
    source: tuple[type[Module], dict[str, str], dict[str, str]] = (Source, {}, {"numbers": "n"})
    channels = {"n": {}, "quiet": {"log": "never", "external": True}, "late": {"external": True}, "unfed": {}}
    graph = build({"A": source, "C": (Collector, {}, {})}, channels)
    assert graph.ports()["C"] == {"of_n", "of_late"}
    named = build({"A": source, "C": (Collector, {"it": "n"}, {})}, channels)
    assert named.ports()["C"] == {"it"}
    assert "C.it" in named.filters.names()


def test_a_graph_that_forgets_filters_as_at_its_start(build: Build, make: Callable[..., Twist]) -> None:
    graph = build(
        {"S": (Source, {}, {"numbers": "n"}), "R": (Relay, {"numbers": "n"}, {"relayed": "r"})}, {"n": {}, "r": {}}
    )
    inbox = graph.modules["R"].context.inputs["numbers"].subscription
    graph.filters.pin("R.numbers", Pin(3, offset=1))
    passed = []
    for _ in range(2):
        before = inbox.statistics().passed
        for value in range(4):
            graph.channels["n"].publish(make(value))
            passed.append(inbox.statistics().passed - before)
        graph.reset()
        assert graph.channels["n"].latest is None
        assert not inbox.waiting
    assert passed == [0, 1, 1, 1] * 2


def test_inputs_are_listed_with_their_channels(build: Build) -> None:
    graph = build(
        {"S": (Source, {}, {"numbers": "n"}), "R": (Relay, {"numbers": "n"}, {"relayed": "r"})}, {"n": {}, "r": {}}
    )
    assert graph.inputs() == {"R.numbers": "n"}


def test_what_a_module_keeps_is_there_for_its_next_instance_until_all_is_forgotten(build: Build) -> None:
    graph = build(*WIRED)
    slot = graph.modules["A"]
    assert slot.module.persistent == {}
    slot.module.persistent["next"] = 7
    assert slot.module_class(slot.context).persistent == {"next": 7}
    assert graph.modules["B"].module.persistent == {}
    graph.reset()
    assert slot.module.persistent == {}
