"""What is felt reaches face and voice: as a desire that gives way to others, and as what the voice follows."""

from __future__ import annotations

from typing import Any

import pytest

from app.attention.desires import Desire, DesireClasses
from app.attention.strategies import Strategy, StrategyTable
from app.messages import ShownEmotion
from app.modules.behaviors.face.face import EXPRESS
from app.runtime.clock import in_virtual_time
from tests.attention.setting import CLASSES, RIVALS
from tests.modules.motivations.test_emotions import Robot

WITH_FACE = StrategyTable(
    (*RIVALS.strategies, Strategy("express", "Express", 8, filters={"Face.command": 1}, costs={})),
    RIVALS.resources,
)
#: GoTo that is neglected angers, exploited it calms; driving by hand does nothing here.
ANGRY: dict[str, Any] = {"GoTo": {"exploited": {"anger": -0.05}, "neglected": {"anger": 0.05}}, "Teleoperation": {}}


def robot_with_face(**settings: Any) -> Robot:
    classes = DesireClasses([*(CLASSES[name] for name in CLASSES), EXPRESS])
    return Robot(WITH_FACE, classes, **{"shows": True, "effects": ANGRY, **settings})


def expressions(robot: Robot) -> list[Desire]:
    return [desire for desire in robot.workspace.desires() if desire.cls == "Express"]


@in_virtual_time
async def test_anger_shows_on_the_face_while_it_lasts_and_is_gone_with_it() -> None:
    robot = robot_with_face()
    async with robot.alive():
        driven = robot.add("Teleoperation", intensity=8)
        robot.add("GoTo", intensity=1)
        await robot.live(8)
        assert (expressions(robot), robot.state.shown, robot.state.shows) == ([], None, True)

        await robot.live(22)
        (wish,) = expressions(robot)
        assert wish.params["expression"] == "angry"
        assert (wish.params["strength"], wish.intensity, wish.utility, wish.security) == (0.75, 0.5, 1.0, False)
        assert (wish.source.kind, wish.source.name) == ("motivation", "Tested")
        assert robot.state.shown == ShownEmotion("anger", 0.75, wish.id)
        assert set(robot.selected) == {"express", "teleop"}

        robot.workspace.remove(driven)
        await robot.live(40)
        assert (expressions(robot), robot.state.shown) == ([], None)
        assert robot.selected == ("goto",)
        added = robot.workspace.statistics().added
        await robot.live(60)
        assert robot.workspace.statistics().added == added, "settled"


@in_virtual_time
async def test_an_expression_that_others_desire_counts_alone_at_once() -> None:
    robot = robot_with_face()
    async with robot.alive():
        robot.add("Teleoperation", intensity=8)
        robot.add("GoTo", intensity=1)
        await robot.live(20)
        assert len(expressions(robot)) == 1

        asked = robot.add("Express", intensity=0.1, params={"expression": "happy"})
        assert [desire.id for desire in expressions(robot)] == [asked], "weaker, and it has its way"
        await robot.live(3)
        assert robot.state.shown == ShownEmotion("anger", 0.75, ""), "the voice shows it still"
        robot.workspace.change(asked, utility=0)
        await robot.live(3)
        assert [desire.id for desire in expressions(robot)] == [asked], "one that inhibits, too"

        robot.workspace.remove(asked)
        (wish,) = expressions(robot)
        await robot.live(1)
        assert robot.state.shown == ShownEmotion("anger", 0.75, wish.id)


@in_virtual_time
async def test_what_a_person_withdraws_is_not_shown_again_for_the_same_emotion() -> None:
    robot = robot_with_face()
    async with robot.alive():
        driven = robot.add("Teleoperation", intensity=8)
        robot.add("GoTo", intensity=1)
        await robot.live(20)
        robot.workspace.remove(expressions(robot)[0].id)
        await robot.live(5)
        assert (expressions(robot), robot.state.shown) == ([], ShownEmotion("anger", 0.75, ""))
        robot.workspace.remove(driven)
        await robot.live(30)
        assert robot.state.shown is None
        robot.add("Teleoperation", intensity=8)
        await robot.live(30)
        assert len(expressions(robot)) == 1, "it has been calm meanwhile"


@in_virtual_time
async def test_its_own_desire_is_neither_felt_nor_a_change_of_desires_nor_raised() -> None:
    settings = {"effects": {**ANGRY, "Express": {"exploited": {"joy": 0.5}, "neglected": {"fear": 0.5}}}}
    silent, showing = (robot_with_face(modulates=True, shows=shows, **settings) for shows in (False, True))
    selections = {}
    for robot in (silent, showing):
        async with robot.alive():
            robot.add("Teleoperation", intensity=5)
            robot.add("GoTo", intensity=4)
            found = await robot.live(90)
            selections[robot] = [tuple(name for name in each if name != "express") for each in found]
            assert [level.intensity for level in robot.state.emotions if level.emotion != "anger"] == [0.0] * 3
    assert selections[silent] == selections[showing]
    assert len(set(selections[silent])) > 1, "what was ignored was raised"
    assert expressions(silent) == []


@in_virtual_time
async def test_it_ends_with_the_module_and_a_robot_without_a_face_has_its_voice() -> None:
    robot, faceless = robot_with_face(), Robot(shows=True, effects=ANGRY)
    for each in (robot, faceless):
        async with each.running():
            each.add("Teleoperation", intensity=8)
            each.add("GoTo", intensity=1)
            heard = each.emotions.listen("emotions")
            async with each.emotions:
                each.heard = heard
                await each.live(15)
                shown = each.state.shown
                assert shown is not None
                assert (shown.desire != "") == bool(expressions(each))
                assert each.emotions.problem == ""
                await each.emotions.supervisor.stop_modules()
                assert expressions(each) == []
                assert each.state.shown is None
    assert len(robot.workspace.desires()) == len(faceless.workspace.desires()) == 2


@pytest.mark.parametrize(
    ("emotion", "expression", "strength"), [("joy", "happy", 0.75), ("sadness", "sad", 0.75), ("fear", "sad", 0.375)]
)
@in_virtual_time
async def test_each_emotion_has_its_expression(emotion: str, expression: str, strength: float) -> None:
    robot = robot_with_face(effects={"GoTo": {"exploited": {emotion: 0.5}}})
    async with robot.alive():
        robot.add("GoTo", intensity=1)
        await robot.live(4)
        (wish,) = expressions(robot)
        assert (wish.params["expression"], wish.params["strength"]) == (expression, strength)
