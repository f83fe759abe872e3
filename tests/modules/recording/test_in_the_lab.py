"""The Recorder in the lab's program: it costs the body nothing until a recording is desired, and keeps no colours."""

from __future__ import annotations

import asyncio
from pathlib import Path

from app.attention.desires import Source
from app.logs.library import RecordingLibrary
from app.logs.mcap.reader import McapLog
from app.messages import Image, IntentionReport, Odometry, RecorderStatus, TorsoColors
from app.program.config import load_configuration
from app.program.system import System
from tests.logs.mcap.disks import image, odometry
from tests.modules.actuation.arms import link as body_with_arms
from tests.patience import PATIENCE_S

CONFIG = Path(__file__).parents[3] / "config" / "lab.yaml"


async def test_the_kinect_runs_for_a_recording_only(tmp_path: Path) -> None:
    link = body_with_arms()
    configuration = await asyncio.to_thread(load_configuration, CONFIG)
    library = RecordingLibrary(tmp_path)
    # Building it reads its files; nothing runs yet.
    system = await asyncio.to_thread(System, configuration, link=link, recordings=library)
    async with system, asyncio.timeout(PATIENCE_S):
        reported = system.graph.channel("recorder").subscribe("test", capacity=1000)

        async def until(state: str) -> RecorderStatus:
            while (status := await reported.receive()).state != state:
                pass
            return status

        await until("idle")
        # What the robot looks for by itself needs the Kinect too: it is to want nothing here. Scans it always wants,
        # for nothing drives without.
        with system.workspace.transaction():
            for motive in system.workspace.desires():
                system.workspace.remove(motive.id)
        while link.demands["kinect"][-1]:
            await reported.receive()
        source = Source("operator", "somebody")
        desire = system.workspace.add("Record", params={"name": "lab"}, source=source, intensity=1.0, utility=1.0)
        await until("recording")
        assert link.demands["kinect"][-1]
        began = system.clock.now()
        for i in range(30):
            link.emit("odometry", odometry(began + i / 100))
            link.emit("kinect", image(began + i / 100, seed=i))
            await asyncio.sleep(0)
        system.workspace.remove(desire.id)
        await until("idle")
        assert system.graph.filters.divisors()["Recorder.kinect"] == float("inf")
        assert not link.demands["kinect"][-1]

    def read() -> tuple[list[type], dict[str, str]]:
        log = McapLog(tmp_path / "lab.mcap")
        try:
            return [type(logged.message) for logged in log.messages()], dict(log.manifest.facts)
        finally:
            log.close()

    types, facts = await asyncio.to_thread(read)
    assert types.count(Odometry) == 30
    assert types.count(Image) >= 1
    assert IntentionReport in types
    assert facts["stream.kinect"] == "kinect"


def test_what_people_wear_is_never_recorded() -> None:
    lab = load_configuration(CONFIG)
    worn = {name for name, spec in lab.channels.items() if spec.message_type is TorsoColors}
    assert worn == {"torso_colors"}
    assert {lab.channels[name].log for name in worn} == {"never"}
    recorded = set(System(lab).graph.modules["Recorder"].context.inputs)
    assert "faces" in recorded
    assert recorded.isdisjoint(worn)
