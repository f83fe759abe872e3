"""When an arm is desired to rest."""

from __future__ import annotations

from app.attention.desires import DesireClasses, Source
from app.attention.workspace import IntentionWorkspace
from app.messages import Exploitation, Twist
from app.modules.behaviors.gestures.gesture_parameters import REST
from app.runtime.clock import VirtualClock, in_virtual_time
from tests.modules.fakes import Bench


class Scene:
    def __init__(self) -> None:
        # All virtual clocks of one loop are alike.
        self.workspace = IntentionWorkspace(DesireClasses([REST]), VirtualClock().now)
        self.bench = Bench(
            "app.modules.motivations.rest_after_gesture:RestAfterGesture",
            inputs={"left": Exploitation, "right": Exploitation},
            settings={"pause_s": 1.0},
            services={IntentionWorkspace: self.workspace},
        )

    async def commanded(self, seconds: float, **by: str | None) -> None:
        """For ``seconds`` the arms are commanded by these behaviors, or by none."""
        clock = self.bench.clock
        for _ in range(round(seconds / 0.1)):
            for side in ("left", "right"):
                now = clock.now()
                report = Exploitation(now, by.get(side), Twist(now, 0.0, 0.0), group=f"{side}_arm")
                self.bench.feed(side, report)
            await clock.sleep(0.1)

    @property
    def resting(self) -> list[str]:
        return [desire.params["arm"] for desire in self.workspace.desires()]


@in_virtual_time
async def test_an_arm_rests_a_pause_after_its_gesture_and_only_then() -> None:
    scene = Scene()
    async with scene.bench:
        await scene.commanded(3.0)
        assert scene.resting == [], "no gesture, no rest"
        await scene.commanded(2.0, left="PointAt")
        await scene.commanded(0.8)
        assert scene.resting == []
        await scene.commanded(0.5)
        assert scene.resting == ["left"]
        (desire,) = scene.workspace.desires()
        assert desire.source == Source("motivation", "Tested", motive="instinctive")
        assert desire.expires is not None
        await scene.commanded(2.0, left="Rest")
        scene.workspace.remove(desire.id)  # it is done
        await scene.commanded(5.0)
        assert scene.resting == [], "once"


@in_virtual_time
async def test_another_gesture_ends_the_wish_to_rest() -> None:
    scene = Scene()
    async with scene.bench:
        await scene.commanded(1.0, left="Wave", right="Reach")
        await scene.commanded(1.5)
        assert sorted(scene.resting) == ["left", "right"]
        await scene.commanded(0.5, left="Reach")
        assert scene.resting == ["right"]


@in_virtual_time
async def test_its_desires_leave_with_it() -> None:
    scene = Scene()
    async with scene.bench:
        await scene.commanded(1.0, right="Wave")
        await scene.commanded(1.5)
        assert scene.resting == ["right"]
    assert scene.resting == []
