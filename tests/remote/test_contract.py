"""What robot and node must agree on, and the words in which they do not."""

from __future__ import annotations

from collections.abc import Callable

import msgspec
import pytest

from app.remote.contract import NotElsewhere, describe, refusal
from app.remote.wire import ModuleOffer, Offer, PortShape
from app.runtime.graph import ModuleSpec

DARKNESS = {
    "class": "app.modules.perception.darkness_detector:DarknessDetector",
    "inputs": {"images": "kinect"},
    "outputs": {"darkness": "darkness"},
}
FACES = {
    "class": "app.modules.perception.face_detector:FaceDetector",
    "inputs": {"images": "kinect", "odometry": "odometry"},
    "outputs": {"faces": "faces"},
}


def offered(**changes: object) -> ModuleOffer:
    return describe("Darkness", ModuleSpec.model_validate(DARKNESS | changes)).offer()


def offer_of(module: ModuleOffer, version: str = "1") -> Offer:
    return Offer("desk", "instance", "process", "host", version, {"Darkness": module})


def test_equals_agree() -> None:
    assert refusal({"Darkness": offered()}, "1", offer_of(offered())) == ""


def test_ports_are_those_that_are_wired() -> None:
    faces = describe("Faces", ModuleSpec.model_validate(FACES))
    assert set(faces.inputs) == {"images", "odometry"}
    assert set(faces.outputs) == {"faces"}


def _other_field(module: ModuleOffer) -> ModuleOffer:
    shape = module.outputs["darkness"]
    fields = {**shape.fields, "Darkness.luma": "int"}
    return msgspec.structs.replace(module, outputs={"darkness": PortShape(shape.message, fields)})


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda m: msgspec.structs.replace(m, class_path="a:B"), "Darkness is app.modules.*, and a:B on desk"),
        (_other_field, "messages of Darkness.darkness differ, seen from the robot: Darkness.luma is float here"),
        (lambda m: msgspec.structs.replace(m, inputs={}), "input images of Darkness is connected on the robot alone"),
        (lambda _: offered(settings={"step": 4}), "other settings on desk: step is 8 on the robot and 4 there"),
    ],
)
def test_a_difference_is_refused_in_words(change: Callable[[ModuleOffer], ModuleOffer], words: str) -> None:
    why = refusal({"Darkness": offered()}, "1", offer_of(change(offered())))
    with pytest.raises(AssertionError, match=words):
        raise AssertionError(why)


def test_another_version_is_refused() -> None:
    assert "the robot runs version 1, desk runs 2" in refusal({"Darkness": offered()}, "1", offer_of(offered(), "2"))


def test_what_the_robot_does_not_let_it_run_is_refused_and_so_is_less() -> None:
    assert refusal({"Faces": offered()}, "1", offer_of(offered())).startswith("Darkness is not among")
    both = {"Darkness": offered(), "Faces": offered()}
    assert refusal(both, "1", offer_of(offered())).startswith("desk does not offer Faces")


@pytest.mark.parametrize(
    ("spec", "words"),
    [
        ({"class": "app.modules.behaviors.teleop:Teleop"}, "the robot's own computer alone"),
        ({"class": "tests.remote.stuck:Homebody"}, "the robot's own computer alone"),
        ({"class": "app.nothing:There"}, "is not a module class"),
        (DARKNESS | {"inputs": {"pictures": "kinect"}}, "no port 'pictures'"),
    ],
)
def test_what_cannot_run_elsewhere_is_refused(spec: dict[str, object], words: str) -> None:
    with pytest.raises(NotElsewhere, match=words):
        describe("It", ModuleSpec.model_validate(spec))
